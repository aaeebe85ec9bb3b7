"""Keywords that functions share: each is listed once, here."""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Mapping, Sequence
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any, Literal, TypedDict, TypeVar

from numpy.typing import ArrayLike

from . import _core
from ._engine_options import EngineOptions

if TYPE_CHECKING:
    from typing_extensions import Unpack as Unpack

Path = str | os.PathLike[str]
Progress = bool | Callable[[str, int, int | None], object] | None
_Function = TypeVar("_Function", bound=Callable[..., Any])


class LogOptions(TypedDict, total=False):
    """Keywords of :func:`torquewise.read_log`."""

    t: ArrayLike | None
    q: ArrayLike | None
    dq: ArrayLike | None
    ddq: ArrayLike | None
    tau: ArrayLike | None
    rate: float | None
    joints: Sequence[str] | None
    profile: Path | None
    topic: str | None
    repair: bool
    filter: Literal["auto", "none"] | float
    delay: float | None


class MethodOptions(EngineOptions, total=False):
    """Keywords of :func:`torquewise.fit` that are not about the log."""

    urdf: Path | None
    lock: Sequence[str] | None
    gravity: Sequence[float] | None


class FitOptions(MethodOptions, LogOptions, total=False):
    """Keywords of :func:`torquewise.fit`."""


class RobotOptions(TypedDict, total=False):
    """Keywords of :meth:`torquewise.Model.to_urdf` and of its like."""

    name: str
    reversal: float | None
    force: bool
    onto: Path | None
    lock: Sequence[str] | None


class ExportOptions(RobotOptions, total=False):
    """Keywords of :meth:`torquewise.Model.export`."""

    precision: Literal["double", "float"]
    binary: bool
    samples: int | None
    seed: int


_USUAL = {"repair": False, "filter": "auto", "name": "arm", "force": False}
_USUAL |= {"precision": "double", "binary": True}

#: Keywords of :func:`torquewise.fit` that are about the log, not about the fit.
OF_LOG = LogOptions.__optional_keys__


def split(options: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Options of the log, and those of the fit; others are refused."""
    known = list(FitOptions.__annotations__)
    for key in options.keys() - known:
        close = get_close_matches(key, known, 1)
        meant = f", did you mean {close[0]}?" if close else ""
        raise _core.UsageError(
            f"{key} is no option of a fit{meant}\nhelp: choose among {', '.join(known)}"
        )
    of_log = {key: own for key, own in options.items() if key in OF_LOG}
    return of_log, {key: own for key, own in options.items() if key not in OF_LOG}


def explicit(options: type) -> Callable[[_Function], _Function]:
    """Makes the signature of a function name each of its `**options`, those of a TypedDict."""

    def decorate(function: _Function) -> _Function:
        own = inspect.signature(function)
        *before, last = own.parameters.values()
        assert last.kind is last.VAR_KEYWORD
        after = [
            inspect.Parameter(
                name,
                inspect.Parameter.KEYWORD_ONLY,
                default=_USUAL.get(name),
                annotation=getattr(kind, "__forward_arg__", kind),
            )
            for name, kind in options.__annotations__.items()
            if name not in own.parameters
        ]
        function.__signature__ = own.replace(parameters=[*before, *after])  # type: ignore[attr-defined]
        return function

    return decorate
