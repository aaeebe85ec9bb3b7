"""Progress of long work, by tqdm where it is installed."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from ._options import Progress

Told = Callable[[str, int, int | None], object]


@contextmanager
def shown(progress: Progress) -> Iterator[Told | None]:
    """The function that is told what is done, or None.

    progress: a function of (what, how much since the last call, how much in all or None), in rows,
    or in starts, offers or cut-offs where those are what is done; True for a bar; None for a bar on
    a terminal; False for nothing.
    """
    if callable(progress):
        yield progress
        return
    bar = _bar() if progress or (progress is None and _is_terminal()) else None
    if bar is None:
        yield None
        return
    try:
        yield bar.told
    finally:
        bar.close()


def _is_terminal() -> bool:
    return sys.stderr is not None and sys.stderr.isatty()


def _bar() -> _Bar | None:
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None
    return _Bar(tqdm)


class _Bar:
    def __init__(self, tqdm: Any):
        self._tqdm = tqdm
        self._own: Any = None
        self._doing: str | None = None

    def told(self, doing: str, rows: int, total: int | None) -> None:
        if doing != self._doing:
            self.close()
            self._doing = doing
            self._own = self._tqdm(desc=doing, total=total, unit="", unit_scale=True, leave=False)
        if total is not None and self._own.n + rows > total:
            # Another pass, or another search.
            self._own.reset()
        if total is not None:
            self._own.total = total
        self._own.update(rows)

    def close(self) -> None:
        if self._own is not None:
            self._own.close()
            self._own = None
