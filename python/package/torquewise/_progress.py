"""Progress of long work, by tqdm where it is installed."""

import sys
from contextlib import contextmanager


@contextmanager
def shown(progress):
    """The function that is told what is done, or None.

    progress: a function of (what, rows since the last call, rows in all or None); True for a bar;
    None for a bar on a terminal; False for nothing.
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


def _is_terminal():
    return sys.stderr is not None and sys.stderr.isatty()


def _bar():
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None
    return _Bar(tqdm)


class _Bar:
    def __init__(self, tqdm):
        self._tqdm, self._own, self._doing = tqdm, None, None

    def told(self, doing, rows, total):
        if doing != self._doing:
            self.close()
            self._doing = doing
            self._own = self._tqdm(
                desc=doing, total=total, unit=" rows", unit_scale=True, leave=False
            )
        if total is not None:
            self._own.total = total
        self._own.update(rows)

    def close(self):
        if self._own is not None:
            self._own.close()
            self._own = None
