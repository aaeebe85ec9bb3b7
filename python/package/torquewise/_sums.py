"""Logs summed up apart, merged, and solved for the model that all of them give."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from . import _core
from ._fit import Fit
from ._log import read_log
from ._options import FitOptions, MethodOptions, Progress, explicit, split
from ._progress import shown

if TYPE_CHECKING:
    from ._options import Unpack


class Summary(_core.Summary):
    """Sums of logs that add up: picklable, bounded in size, the same bits in any order.

    >>> sums = Summary.of("day1.csv").merge(Summary.of("day2.csv"))     # doctest: +SKIP
    >>> found = sums.solve()                                            # doctest: +SKIP

    A chain is fitted in rounds: while `solve` returns a :class:`Request`, sum up all logs again with
    ``request=found``, merge, and solve.
    """

    @classmethod
    @explicit(FitOptions)
    def of(
        cls,
        log: Any = None,
        *,
        request: _core.Request | None = None,
        progress: Progress = None,
        **options: Unpack[FitOptions],
    ) -> Summary:
        """Sums up a log; options are those of :func:`torquewise.fit`."""
        of_log, of_fit = split(options)
        log = read_log(log, **of_log)
        with shown(progress) as told:
            return cls(_core.Summary._of(log, request, of_fit, told))

    @classmethod
    def from_bytes(cls, data: bytes) -> Summary:
        """Sums from the bytes of a moments file."""
        return cls(_core.Summary.from_bytes(data))

    def merge(self, *others: _core.Summary) -> Summary:
        """The sums of these logs and others, each of other logs: the same sums twice are refused."""
        found: _core.Summary = self
        seen = {self.to_bytes()} if others else set()
        for other in others:
            content = other.to_bytes()
            if content in seen:
                raise ValueError("the same sums twice: each log counts once, leave one of them out")
            seen.add(content)
            found = _core.Summary.merge(found, other)
        return type(self)(found)

    @explicit(FitOptions)
    def update(self, log: Any = None, **options: Unpack[FitOptions]) -> Summary:
        """The sums of these logs and one more."""
        return self.merge(type(self).of(log, **options))

    @explicit(MethodOptions)
    def solve(
        self, *, progress: Progress = None, **options: Unpack[MethodOptions]
    ) -> Fit | _core.Request:
        """The :class:`Fit` of a model, or the :class:`Request` of another round."""
        with shown(progress) as told:
            found = self._solve({**options}, told)
        return found if isinstance(found, _core.Request) else Fit(found)
