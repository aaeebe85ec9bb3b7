"""Arrays of others, as arrays of float64."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def numbers(values: Any) -> NDArray[np.float64]:
    """Numbers as float64, a copy only where they are not; those that are masked are NaN."""
    found = np.asarray(values)
    if found.dtype.kind not in "fiu" and found.size:
        raise ValueError(f"holds {found.dtype}, not numbers: convert it to float64")
    if np.ma.is_masked(values):
        found = np.where(np.ma.getmaskarray(values), np.nan, found)
    return found.astype(np.float64, copy=False)


def states(values: Any) -> NDArray[np.float64]:
    """One state, n numbers, or several in rows, m×n: what the methods of a model take."""
    if np.ma.is_masked(values):
        place = np.argwhere(np.ma.getmaskarray(values))[0].tolist()
        raise ValueError(f"the value at {place} is masked: fill it or leave the state out")
    if any(isinstance(name, str) for name in getattr(values, "columns", ())):
        raise ValueError(
            "a frame of named columns, which would be taken by their place: give "
            "`frame[names].to_numpy()`, the names in the order of the joints"
        )
    try:
        found = numbers(values)
    except ValueError as error:
        raise ValueError(
            f"expected numbers of one or several states, one for each joint: {error}"
        ) from None
    if len(found.shape) not in (1, 2):
        raise ValueError(
            f"an array of {found.ndim} dimensions: expected numbers of one state, one for each joint, "
            "or of several states in rows"
        )
    return found
