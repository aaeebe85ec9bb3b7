"""Results by name, and as frames of pandas where it is installed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np


class Trajectory(dict[str, Any]):
    """Arrays of one trajectory by name: m numbers, or m×n of n joints; perhaps what it is of."""

    def to_frame(self) -> Any:
        """A frame of pandas with a row for each time: t, q1, q2, … and whatever else it holds."""
        arrays = {key: own for key, own in self.items() if isinstance(own, np.ndarray)}
        columns = {key: own for key, own in arrays.items() if own.ndim == 1}
        for key, own in arrays.items():
            if own.ndim == 2:
                columns.update({f"{key}{k}": column for k, column in enumerate(own.T, 1)})
        return frame(columns)


def frame(columns: Mapping[str, Any], index: str | None = None) -> Any:
    """A frame of these columns, one of them its index if named."""
    try:
        import pandas as pd
    except ImportError:
        raise ImportError("frames are those of pandas: pip install pandas") from None
    found = pd.DataFrame(dict(columns))
    return found if index is None else found.set_index(index)
