"""Many logs, of one robot or of a fleet, on an engine that is there already: Dask.

>>> from torquewise import fleet
>>> found = fleet.fit("s3://arms/*/*.parquet", by=["robot", "week"],
...                   name="s3://arms/{robot}/{week}-*.parquet")               # doctest: +SKIP
>>> found.model, found.changes, found.bad                                      # doctest: +SKIP

Each worker sums up some files (:class:`torquewise.Summary`); only sums travel, a few MB whatever the
rows, and are merged on the workers. A chain takes two or three rounds over the files. The model is the
same, byte for byte, as that of :func:`torquewise.fit` on all files at once, whatever the workers do.
"""

from __future__ import annotations

import glob
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from .. import _core as _engine
from .._model import Model
from .._options import FitOptions, Progress, explicit
from .._progress import shown
from . import _dask, _drift
from ._core import MOST_ROUNDS, File, Part, Plan, merge, pilot, rounds, solve, summarise
from ._drift import Change, Reading

if TYPE_CHECKING:
    from .._options import Unpack

__all__ = [
    "Change",
    "File",
    "Fleet",
    "Part",
    "Plan",
    "Reading",
    "fit",
    "merge",
    "rounds",
    "solve",
    "summarise",
]

#: Logs that choose the filter, where logs have no accelerations.
_PILOTS = 8


@dataclass
class Fleet:
    """What was found in the logs of a fleet."""

    model: Model
    """Of all robots together."""
    verdict: str
    because: list[str]
    files: list[File]
    """Each with its checksum and rows, or the reason why it was left out."""
    rounds: int
    models: dict[Any, Model] = field(default_factory=dict)
    """Of each robot, where `by` was given."""
    changes: list[Change] = field(default_factory=list)
    """What changed, of which robot, since when; most certain first."""
    readings: dict[Any, list[tuple[Any, Reading]]] = field(default_factory=dict)
    """Of each robot, logs in the order of time, with the changes of parameters in each."""
    plan: Plan = field(default_factory=Plan)
    """What was fitted, with the filter that was chosen."""

    @property
    def bad(self) -> list[File]:
        """Files that were left out, each with its reason."""
        return [own for own in self.files if own.reason is not None]

    @property
    def rows(self) -> int:
        """Rows that the model was fitted to."""
        return sum(own.rows for own in self.files)

    def table(self) -> Any:
        """A row for each log, joint and parameter: a table of pyarrow."""
        from . import _page

        return _page.table(self)

    def save(self, folder: Any) -> None:
        """Writes model.json, a model of each robot, drift.parquet, files.csv and fleet.html."""
        from . import _page

        _page.save(self, folder)

    def report(self, path: Any = None) -> str:
        """One page of HTML: what changed, each robot, files that were left out."""
        from . import _page

        page = _page.html(self)
        if path is not None:
            _engine.write_whole(path, page.encode())
        return page

    def __repr__(self) -> str:
        lines = [
            f"Fleet of {len(self.models) or 1} robots, {self.rows} rows in "
            f"{len(self.files) - len(self.bad)} files, {len(self.bad)} left out; {self.verdict}"
        ]
        lines += [f"- {own}" for own in self.changes]
        return "\n".join(lines)


@explicit(FitOptions)
def fit(
    paths: str | Sequence[str],
    client: Any = None,
    *,
    by: Sequence[str] = (),
    name: str | Callable[[str], dict[str, Any]] | None = None,
    level: float = 0.01,
    store: str | None = None,
    storage_options: dict[str, Any] | None = None,
    retries: int = 3,
    progress: Progress = None,
    **options: Unpack[FitOptions],
) -> Fleet:
    """The model of all logs, of each robot, and what changed.

    paths
        Files or patterns of them, of this machine or of a store that fsspec knows (``s3://…``,
        ``gs://…``). One file is one log.
    client
        A ``distributed.Client``, the address of a scheduler, or None for processes of this machine.
    by
        Up to two keys: that of the robot, which gets a model of its own, and that of time, by which its
        logs are ordered and a change is dated. Without, one model is all.
    name
        How keys stand in a path, such as ``"{robot}/{week}-*.parquet"``, or a function from a path to a
        dict of them.
    level
        Chance that any robot is accused of a change wrongly.
    store
        Folder for sums of files: a run that was cut off goes on from there. A file is known by its
        content.
    storage_options
        Credentials and endpoints for fsspec.
    retries
        Of a task whose worker fails; a file that a worker dies of is left out.
    options
        Those of :func:`torquewise.fit`. Where logs have no accelerations and no filter is given, some
        logs choose it for all.

    Ctrl-C cancels all tasks. A file that cannot be read or summed up, or whose name does not tell
    its keys, is left out, with its reason, in ``bad``.
    """
    paths = _listed([paths] if isinstance(paths, str) else paths, storage_options or {})
    keys, unnamed = _keys(paths, by, name)
    paths = list(keys)
    with _dask.connected(client) as own, shown(progress) as told:
        plan = Plan({**options}, storage_options or {}, store)
        call = _Rounds(own, plan, retries, told)
        call.choose_filter(paths)
        robots: dict[Any, list[str]] = {}
        for path in paths:
            robots.setdefault(keys[path][0] if by else None, []).append(path)
        whole, count = call.model(robots, "all")
        model, facts, files = whole
        found = Fleet(
            Model.from_json(model),
            facts["verdict"],
            facts["because"],
            sorted([*files, *unnamed], key=lambda file: file.path),
            count,
            plan=call.plan,
        )
        if by:
            good = {file.path for file in files if file.reason is None}
            _by_robot(found, call, robots, keys, good, by, level)
        return found


def _by_robot(
    found: Fleet,
    call: _Rounds,
    robots: dict[Any, list[str]],
    keys: dict[str, tuple[Any, Any]],
    good: set[str],
    by: Sequence[str],
    level: float,
) -> None:
    """Models of single robots, and what changed in their logs beside these."""
    for robot, own in robots.items():
        own = [path for path in own if path in good]
        if not own:
            continue
        try:
            (model, _, _), _ = call.model({robot: own}, str(robot))
        except _engine.TorquewiseError:
            # Its own logs do not tell a model: that of all stands for it.
            model = found.model.to_json()
        found.models[robot] = Model.from_json(model)
    jobs = {
        robot: call.readings([path for path in robots[robot] if path in good], model.to_json())
        for robot, model in found.models.items()
    }
    for robot, readings in jobs.items():
        named = [(keys[own.path][1] or own.path, own) for own in readings]
        found.readings[robot] = sorted(named, key=lambda pair: (pair[0], pair[1].path))
    scales = {robot: _drift.parameters(model) for robot, model in found.models.items()}
    joints = found.model.joints
    key = by[1] if len(by) > 1 else ""
    found.changes = _drift.jumps(found.readings, joints, scales, level, key)


class _Rounds:
    """Rounds over files until there is a model."""

    def __init__(self, client: Any, plan: Plan, retries: int, told: Any):
        self.client, self.plan, self.retries, self._told = client, plan, retries, told
        self._known: dict[str, str] = {}
        # Sums of the first round, in which all ask for the same: futures, with their files.
        self._first: dict[Any, tuple[Any, tuple[File, ...]]] = {}

    def choose_filter(self, paths: Sequence[str]) -> None:
        step = max(1, len(paths) // _PILOTS)
        some = list(paths)[::step][:_PILOTS]
        chosen = _dask.called(self.client, pilot, some, self.plan, retries=self.retries)
        if chosen:
            options = {**self.plan.options, **chosen}
            self.plan = Plan({**options}, self.plan.storage, self.plan.store)

    def model(
        self, robots: dict[Any, list[str]], what: str
    ) -> tuple[tuple[str, dict[str, Any], list[File]], int]:
        """Model, facts and files, and the rounds that it took."""
        request: bytes | None = None
        bad: dict[str, File] = {}
        for number in range(1, MOST_ROUNDS + 1):
            part, seen = self._summed(robots, request, bad, f"{what}, round {number}")
            bad.update({own.path: own for own in seen if own.reason is not None})
            solved = _dask.called(self.client, solve, part, self.plan, retries=self.retries)
            model, request, facts = solved
            if model is not None:
                good = [own for own in seen if own.reason is None]
                files = sorted([*good, *bad.values()], key=lambda own: own.path)
                return (model, facts, files), number
        raise _engine.FitError(f"{what}: no model after {MOST_ROUNDS} rounds")

    def _summed(
        self, robots: dict[Any, list[str]], request: bytes | None, bad: dict[str, File], what: str
    ) -> tuple[Any, list[File]]:
        if request is not None:
            left = {robot: [own for own in all if own not in bad] for robot, all in robots.items()}
            part, files = self._reduced(left, request, what)
            return part, list(files)
        for robot in (own for own in robots if own not in self._first):
            self._first[robot] = self._reduced({robot: robots[robot]}, None, what)
        first = [self._first[robot] for robot in robots]
        part = _dask.joined(self.client, [own for own, _ in first], self.retries)
        return part, [file for _, files in first for file in files]

    def _reduced(
        self, robots: dict[Any, list[str]], request: bytes | None, what: str
    ) -> tuple[Any, tuple[File, ...]]:
        batches = [
            own[first : first + _dask.FILES]
            for own in robots.values()
            for first in range(0, len(own), _dask.FILES)
        ]
        total = sum(map(len, batches))

        def told(files: int) -> None:
            if self._told is not None:
                self._told(what, files, total)

        part = _dask.reduced(
            self.client, batches, self.plan, request, self._known, told, self.retries
        )
        files = _dask.called(self.client, _dask.files_of, part, retries=self.retries)
        self._known.update({own.path: own.checksum for own in files if own.checksum})
        return part, files

    def readings(self, paths: list[str], model: str) -> list[Reading]:
        futures = [
            self.client.submit(
                _drift.read, path, self.plan, model, pure=False, retries=self.retries
            )
            for path in paths
        ]
        try:
            found: list[Reading] = self.client.gather(futures)
            return found
        except BaseException:
            self.client.cancel(futures, force=True)
            raise


def _listed(paths: Sequence[str], storage: dict[str, Any]) -> list[str]:
    """All files that paths and patterns stand for, in alphabetical order, each once."""
    found: set[str] = set()
    for path in map(str, paths):
        if not any(own in path for own in "*?["):
            found.add(path)
        elif "://" in path:
            import fsspec

            system, _, _ = fsspec.get_fs_token_paths(path, storage_options=storage)
            found.update(system.unstrip_protocol(own) for own in system.glob(path))
        else:
            found.update(glob.glob(path, recursive=True))
    if not found:
        raise ValueError(f"no files: {', '.join(map(str, paths))} stand for none")
    return sorted(found)


def _keys(
    paths: Sequence[str], by: Sequence[str], name: Any
) -> tuple[dict[str, tuple[Any, Any]], list[File]]:
    """Robot and time of each path, and files whose name does not tell them."""
    if len(by) > 2:
        raise ValueError("by: at most two keys, of the robot and of time")
    if by and name is None:
        raise ValueError(
            'name: say how the keys stand in a path, such as "{robot}/{week}-*.parquet"'
        )
    if not by:
        return {path: (None, None) for path in paths}, []
    read = name if callable(name) else _reader(name, by)
    found, unnamed = {}, []
    for path in paths:
        try:
            own = read(path)
            found[path] = (own[by[0]], own[by[1]] if len(by) > 1 else None)
        except Exception as error:
            why = f"its name does not tell {error}" if isinstance(error, KeyError) else f"{error}"
            unnamed.append(File(path, reason=why))
    if not found:
        raise ValueError(f"{unnamed[0].path}: {unnamed[0].reason}; nor does any other")
    return found, unnamed


def _reader(pattern: str, by: Sequence[str]) -> Callable[[str], dict[str, str]]:
    parts = re.split(r"(\{\w+\}|\*+)", pattern)
    expression = "".join(
        f"(?P<{own[1:-1]}>[^/]+?)"
        if own.startswith("{")
        else (".*" if own.startswith("*") else re.escape(own))
        for own in parts
    )
    compiled = re.compile(f"(?:.*/)?{expression}$")

    def read(path: str) -> dict[str, str]:
        found = compiled.match(path)
        if found is None:
            raise ValueError(f"it is not called as name={pattern!r} says")
        return found.groupdict()

    return read
