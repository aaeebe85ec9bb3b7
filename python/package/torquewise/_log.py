"""Logs: files of any format, arrays, or tables of other packages."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._arrays import numbers
from ._options import LogOptions, Path, Progress, explicit
from ._progress import shown
from ._tables import Trajectory, frame

if TYPE_CHECKING:
    from ._options import Unpack

SIGNALS = ("q", "dq", "ddq", "tau")

Columns = Iterator[tuple[str, list[NDArray[np.float64]]]]


class Log(_core.Log):
    """Logs of one arm, opened by :func:`read_log`: nothing is read before it is needed.

    One of files can be pickled, and is opened again where it arrives.
    """

    _made: tuple[list[str], dict[str, Any]] | None = None

    def inspect(self, *, progress: Progress = None) -> Inspection:
        """What it holds and what it lacks, see :func:`inspect`."""
        return inspect(self, progress=progress)

    def trajectories(
        self, conditioned: bool = False, model: _core.Model | None = None
    ) -> list[Trajectory]:
        """Each trajectory as t, q, dq, ddq and perhaps tau: as recorded, or filtered (as by `model`)."""
        return [Trajectory(own) for own in super().trajectories(conditioned, model)]

    def __reduce__(self) -> tuple[Any, ...]:
        if self._made is None:
            raise TypeError(
                "a log of arrays or tables cannot be pickled: pickle these, or what "
                "Log.trajectories gives, and call read_log where they arrive"
            )
        return _opened, self._made


def _opened(files: list[str], options: dict[str, Any]) -> Log:
    log = Log(files, **options)
    log._made = files, options
    return log


def read_log(
    log: Any = None,
    *,
    t: ArrayLike | None = None,
    q: ArrayLike | None = None,
    dq: ArrayLike | None = None,
    ddq: ArrayLike | None = None,
    tau: ArrayLike | None = None,
    rate: float | None = None,
    joints: Sequence[str] | None = None,
    profile: Path | None = None,
    topic: str | None = None,
    repair: bool = False,
    filter: Literal["auto", "none"] | float = "auto",
    delay: float | None = None,
) -> Log:
    """Opens logs of one arm.

    log
        A path of a ``.csv``, ``.parquet``, ``.db3``, ``.mcap``, ``.npz`` or ``.mat`` file or of the
        folder of a bag; a dict of arrays with the keys t, q, dq, ddq, tau (each m×n, or columns q1,
        q2, …); a table of pandas, polars or pyarrow with such columns, t perhaps as its index; a list
        of paths or of tables, one trajectory each; or a log that is open. Arrays of float64 are not
        copied, dates and times as t are counted from the first.
    t, q, dq, ddq, tau
        Arrays instead of `log`: t [s] of m numbers, the others m×n. All but q may be missing.
    rate
        Rows per second [Hz] of arrays, where there is no t.
    joints
        Names of the joints of arrays, base to tip; joint1 … without.
    profile, topic
        File that says what other columns mean, topic of a bag that has several.
    repair
        Drops rows that go back in time or hold no number; else they are errors.
    filter, delay
        ``"auto"``, ``"none"`` or a cut-off [Hz]; seconds by which torque lags, chosen by a fit without.
    """
    if log is None:
        if q is None:
            raise ValueError("no log: give a path, a table, or arrays with q")
        log = {"t": t, "q": q, "dq": dq, "ddq": ddq, "tau": tau}
        log = {key: value for key, value in log.items() if value is not None}
    elif any(own is not None for own in (t, q, dq, ddq, tau)):
        raise _core.UsageError("a log and arrays: give one of them")
    options: dict[str, Any] = {
        "profile": profile,
        "topic": topic,
        "repair": repair,
        "filter": filter,
        "delay": delay,
    }
    if isinstance(log, Log):
        usual = {"repair": False, "filter": "auto"}
        given = {**options, "rate": rate, "joints": joints}
        _refuse([key for key, own in given.items() if own != usual.get(key)], "an opened log")
        return log
    logs = log if isinstance(log, (list, tuple)) else [log]
    if not logs:
        raise ValueError("no log: the list is empty")
    if all(isinstance(own, (str, os.PathLike)) for own in logs):
        own = [name for name, value in (("rate", rate), ("joints", joints)) if value is not None]
        _refuse(own, "files, whose profile says it")
        return _opened([os.fspath(own) for own in logs], options)
    _refuse(["topic"] if topic is not None else [], "arrays and tables")
    many = len(logs) > 1
    frames = [
        (f"table {k}" if many else "table", _frame(own, rate, joints))
        for k, own in enumerate(logs, 1)
    ]
    return Log(frames, **options)


def _refuse(options: list[str], what: str) -> None:
    if options:
        raise _core.UsageError(f"{', '.join(options)}: not for {what}")


def write_log(path: Path, log: Mapping[str, Any], *, joints: Sequence[str] | None = None) -> None:
    """Writes a trajectory, a dict with t, q, dq, ddq and perhaps tau, as ``.csv`` or ``.parquet``."""
    missing = [key for key in ("t", "q", "dq", "ddq") if key not in log]
    if missing:
        raise ValueError(f"the log has no {', '.join(missing)}: see Log.trajectories")
    n = np.shape(log["q"])[1]
    joints = joints or log.get("joints") or [f"joint{k}" for k in range(1, n + 1)]
    t = np.asarray(log["t"], dtype=float)
    _core.write_log(
        os.fspath(path), list(joints), t, log["q"], log["dq"], log["ddq"], log.get("tau")
    )


@dataclass
class Inspection:
    """What a log holds and what it lacks."""

    facts: dict[str, Any]
    warnings: list[str]

    def __getattr__(self, name: str) -> Any:
        try:
            return self.__dict__["facts"][name]
        except KeyError:
            raise AttributeError(
                f"an inspection has no {name}: it has {', '.join(self.__dict__.get('facts', ()))}"
            ) from None

    def __repr__(self) -> str:
        facts = self.facts
        lines = [
            f"{facts['rows']} rows of {len(facts['joints'])} joints, {facts['seconds']:.1f} s at"
            f" {facts['rate_hz']:.4g} Hz"
        ]
        if facts["rows_recorded"]:
            lines[0] += f", filtered, of {facts['rows_recorded']} recorded"
        lines += [f"- {warning}" for warning in self.warnings]
        return "\n".join(lines)


@explicit(LogOptions)
def inspect(
    log: Any = None,
    *,
    model: _core.Model | None = None,
    progress: Progress = None,
    **options: Unpack[LogOptions],
) -> Inspection:
    """What a log holds and what it lacks: rows, ranges, noise, patterns, and warnings.

    Options are those of :func:`read_log`; `model` says how the log is filtered. For columns that are
    not understood, the error ends in the profile they ask for.
    """
    try:
        log = read_log(log, **options)
    except _core.ColumnError as error:
        logs = list(log) if isinstance(log, (list, tuple)) else [log]
        if not all(isinstance(own, (str, os.PathLike)) for own in logs):
            raise
        toml, reasons, _ = _core.suggest([os.fspath(own) for own in logs])
        raise _core.ColumnError(
            f"{error}\n\nA profile for it, to be saved, corrected and given as profile=…:\n\n{toml}\n"
            + "\n".join(f"- {reason}" for reason in reasons)
        ) from None
    with shown(progress) as told:
        facts, warnings = _core.inspect(log, model, told)
    return Inspection(json.loads(facts), warnings)


@dataclass(eq=False)
class Patterns:
    """The pattern of each row: 0 standstill, 1 uniform velocity, 2 variable velocity."""

    labels: NDArray[np.uint8]
    inertia: NDArray[np.float64]
    """Sum of squared distances within clusters, with 1, 2, … of them."""
    warnings: list[str]

    NAMES = ("standstill", "uniform", "variable")

    @property
    def counts(self) -> dict[str, int]:
        """Rows of each pattern."""
        counts = np.bincount(self.labels, minlength=3)
        return dict(zip(self.NAMES, (int(count) for count in counts)))

    def to_frame(self) -> Any:
        """A frame of pandas with a row for each row of the log."""
        return frame({"label": self.labels, "pattern": np.array(self.NAMES)[self.labels]})


@explicit(LogOptions)
def patterns(
    log: Any = None,
    *,
    activation: Literal["scaled", "paper"] = "scaled",
    clusters: int | None = None,
    seed: int = 0,
    progress: Progress = None,
    **options: Unpack[LogOptions],
) -> Patterns:
    """Tells standstill, uniform and variable velocity apart, row by row."""
    log = read_log(log, **options)
    with shown(progress) as told:
        labels, inertia, warnings = _core.patterns(
            log, activation=activation, clusters=clusters, seed=seed, progress=told
        )
    return Patterns(labels, np.array(inertia), warnings)


def _frame(table: Any, rate: float | None, joints: Sequence[str] | None) -> _core.ArrayFrame:
    columns = dict(_columns(table))
    if rate is not None:
        if "t" in columns:
            raise _core.UsageError("rate and t: give one of them")
        if not columns:
            raise ValueError("the table has no columns of numbers")
        rows = sum(len(part) for part in next(iter(columns.values())))
        columns["t"] = [np.arange(rows) / float(rate)]
    if joints is None and isinstance(table, Mapping):
        joints = table.get("joints")
    return _core.ArrayFrame(list(columns.items()), list(joints) if joints is not None else None)


def _columns(table: Any) -> Columns:
    """Names and arrays of float64 of the columns of a table, in parts where it has parts.

    Columns that are no numbers are left out, unless they are called as a signal.
    """
    if isinstance(table, Mapping):
        return _of_mapping(table)
    kind = type(table).__module__.partition(".")[0]
    if kind == "pandas":
        return _of_pandas(table)
    if kind == "polars":
        return _of_polars(table)
    if (
        hasattr(table, "__arrow_c_stream__")
        or hasattr(table, "__arrow_c_array__")
        or kind == "pyarrow"
    ):
        return _of_arrow(table)
    raise TypeError(
        f"{type(table).__name__} is no log: give a path, a dict of arrays with t, q, …, or a table of "
        "pandas, polars or pyarrow; in a list, all paths or all tables"
    )


def _of_mapping(table: Mapping[str, Any]) -> Columns:
    for name, values in table.items():
        if values is None or name == "joints":
            continue
        found = _numbers(name, values)
        if found is None:
            continue
        if found.ndim == 1:
            yield (name if name not in SIGNALS else f"{name}1"), [found]
        elif found.ndim == 2 and name != "t":
            for k in range(found.shape[1]):
                yield f"{name}{k + 1}", [found[:, k]]
        elif _is_signal(name):
            wanted = "m numbers" if name == "t" else "m×n numbers"
            raise ValueError(f"{name} is of shape {found.shape}: expected {wanted}")


def _of_pandas(table: Any) -> Columns:
    for name in table.columns:
        column = table[name]
        if getattr(column.dtype, "kind", "O") in "fiu":
            yield str(name), [column.to_numpy(dtype=np.float64, na_value=np.nan)]
        elif (found := _numbers(str(name), _of_zone(column.array))) is not None:
            yield str(name), [found]
    kind = getattr(table.index.dtype, "kind", "O")
    if "t" not in table.columns and (table.index.name == "t" or kind in "mM"):
        found = _numbers("t", _of_zone(table.index))
        assert found is not None
        yield "t", [found]


def _of_zone(values: Any) -> Any:
    """Times of a zone as those of UTC, which NumPy knows; others as they are."""
    return values.tz_convert(None) if getattr(values, "tz", None) is not None else values


def _of_polars(table: Any) -> Columns:
    import polars as pl

    for column in table.iter_columns():
        if column.dtype.is_numeric():
            parts = column.cast(pl.Float64).get_chunks()
            yield column.name, [part.to_numpy() for part in parts]
        elif (found := _numbers(column.name, column.to_numpy())) is not None:
            yield column.name, [found]


def _of_arrow(table: Any) -> Columns:
    try:
        import pyarrow as pa
    except ImportError:
        raise ImportError("tables of Arrow are read by pyarrow: pip install pyarrow") from None
    if not isinstance(table, pa.Table):
        table = pa.table(table)
    for name, column in zip(table.column_names, table.columns):
        if pa.types.is_floating(column.type) or pa.types.is_integer(column.type):
            chunks = column.cast(pa.float64()).chunks
            yield name, [chunk.to_numpy(zero_copy_only=False) for chunk in chunks]
        elif (found := _numbers(name, column.to_numpy())) is not None:
            yield name, [found]


def _numbers(name: str, values: Any) -> NDArray[np.float64] | None:
    """A column as float64, time in seconds; None where it is none of numbers and no signal."""
    try:
        return numbers(_seconds(values) if name == "t" else values)
    except ValueError as error:
        if not _is_signal(name):
            return None
        raise _core.LogError(f"column {name} {error}") from None


def _seconds(times: Any) -> Any:
    """Dates and times as seconds since the first; other values as they are."""
    found = np.asarray(times)
    if found.dtype.kind not in "mM" or not found.size:
        return times
    return (found - found[0]) / np.timedelta64(1, "s")


def _is_signal(name: str) -> bool:
    return re.fullmatch(r"t|(q|dq|ddq|tau)\d*", name) is not None
