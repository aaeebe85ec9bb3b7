"""From the motion log of a robot arm to its equations of motion.

>>> import torquewise
>>> fit = torquewise.fit("train.csv")                       # doctest: +SKIP
>>> fit.verdict, fit.evaluate("test.csv").nrmse_percent     # doctest: +SKIP
>>> fit.model.torque(q, dq, ddq)                            # doctest: +SKIP

q [rad], dq [rad/s], ddq [rad/s²] and tau [N·m] are one state of n joints, or m states in rows (m×n).
Wherever a log is wanted, a path, several paths, arrays, or a table of pandas, polars or pyarrow will
do: see :func:`read_log`.
"""

from importlib import import_module as _import_module
from typing import TYPE_CHECKING as _TYPE_CHECKING
from typing import Any as _Any

from ._control import Tracking, control
from ._core import (
    ColumnError,
    FitError,
    FrictionState,
    Interrupted,
    LogError,
    ModelError,
    Request,
    TorquewiseError,
    UsageError,
    __version__,
)
from ._fit import Evaluation, Fit, compare, fit
from ._log import Log, inspect, patterns, read_log, write_log
from ._model import Model
from ._observer import Contacts, Gains, Payload, contacts, gains, payload, residuals
from ._options import FitOptions, LogOptions
from ._rollout import Rollout
from ._simulation import arms, excite, simulate
from ._sums import Summary

if _TYPE_CHECKING:
    from . import plot
    from ._estimators import Chain, OneShot, Stepwise

__all__ = [
    "Chain",
    "ColumnError",
    "Contacts",
    "Evaluation",
    "Fit",
    "FitError",
    "FitOptions",
    "FrictionState",
    "Gains",
    "Interrupted",
    "Log",
    "LogError",
    "LogOptions",
    "Model",
    "ModelError",
    "OneShot",
    "Payload",
    "Request",
    "Rollout",
    "Stepwise",
    "Summary",
    "TorquewiseError",
    "Tracking",
    "UsageError",
    "__version__",
    "arms",
    "compare",
    "contacts",
    "control",
    "excite",
    "fit",
    "gains",
    "inspect",
    "patterns",
    "payload",
    "plot",
    "read_log",
    "residuals",
    "simulate",
    "write_log",
]

# Loaded when they are asked for: they need, or are for, other packages.
_LATE = {"Chain": "._estimators", "OneShot": "._estimators", "Stepwise": "._estimators"}


def __getattr__(name: str) -> _Any:
    if name in _LATE:
        return getattr(_import_module(_LATE[name], __name__), name)
    if name == "plot":
        return _import_module(".plot", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
