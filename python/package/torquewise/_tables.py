"""Results as frames of pandas, where it is installed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def frame(columns: Mapping[str, Any], index: str | None = None) -> Any:
    """A frame of these columns, one of them its index if named."""
    try:
        import pandas as pd
    except ImportError:
        raise ImportError("frames are those of pandas: pip install pandas") from None
    found = pd.DataFrame(dict(columns))
    return found if index is None else found.set_index(index)
