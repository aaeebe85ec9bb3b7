"""What a worker does, whatever engine calls it: files to sums, sums to one, sums to a model.

All of it is picklable and says what went wrong instead of raising: a bad file does not stop a fleet.
"""

from __future__ import annotations

import hashlib
import json
import pickle
import shutil
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from .. import _core
from .._fit import Fit
from .._log import read_log
from .._model import Model
from .._options import OF_LOG
from .._sums import Summary

#: Bytes of a file that are read at once.
_BLOCK = 1 << 20
#: Rounds that a chain may ask for.
MOST_ROUNDS = 8


@dataclass(frozen=True)
class Plan:
    """What is fitted to all files, and how they are read."""

    options: dict[str, Any] = field(default_factory=dict)
    """Of :func:`torquewise.fit`, those of :func:`torquewise.read_log` among them."""
    storage: dict[str, Any] = field(default_factory=dict)
    """For fsspec: credentials, endpoints."""
    store: str | None = None
    """Folder for sums, from which a later run goes on."""

    def of_log(self) -> dict[str, Any]:
        return {key: own for key, own in self.options.items() if key in OF_LOG}

    def of_fit(self) -> dict[str, Any]:
        return {key: own for key, own in self.options.items() if key not in OF_LOG}


@dataclass(frozen=True)
class File:
    """A file, and what became of it."""

    path: str
    checksum: str | None = None
    rows: int = 0
    reason: str | None = None
    """Why it was left out, if it was."""


@dataclass(frozen=True)
class Part:
    """Sums of some files; none if all of them were left out."""

    sums: bytes | None
    files: tuple[File, ...]

    @property
    def good(self) -> list[File]:
        """Files that were summed up."""
        return [own for own in self.files if own.reason is None]

    @property
    def bad(self) -> list[File]:
        """Files that were left out."""
        return [own for own in self.files if own.reason is not None]


@contextmanager
def local(path: str, plan: Plan) -> Iterator[str]:
    """A path that can be read here: the file itself, or a copy of it while this lasts."""
    if "://" not in path:
        yield path
        return
    import fsspec

    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / path.rsplit("/", 1)[-1]
        with fsspec.open(path, "rb", **plan.storage) as source, open(copy, "wb") as target:
            shutil.copyfileobj(source, target, _BLOCK)
        yield str(copy)


def checksum(path: str) -> str:
    """Of the content of a file, or of the files in the folder of a bag."""
    digest = hashlib.blake2b(digest_size=16)
    own = Path(path)
    for file in sorted(own.iterdir()) if own.is_dir() else [own]:
        with open(file, "rb") as source:
            while block := source.read(_BLOCK):
                digest.update(block)
    return digest.hexdigest()


def summarise(
    paths: Sequence[str], plan: Plan, request: bytes | None, known: dict[str, str]
) -> Part:
    """Sums up files, one after the other.

    request: what `solve` asked for, if it did. known: checksums of an earlier round; a file that has
    changed since is left out.
    """
    request_own = None if request is None else _core.Request.from_bytes(request)
    sums, files = None, []
    for path in paths:
        try:
            with local(path, plan) as here:
                found = checksum(here)
                if known.get(path, found) != found:
                    raise _core.LogError("it has changed since the run began")
                kept = _kept(plan, request, found)
                own = _loaded(kept)
                if own is None:
                    options = {**plan.of_log(), **plan.of_fit()}
                    own = Summary.of(here, request=request_own, progress=False, **options)
                    _keep(kept, own)
            sums = own if sums is None else sums.merge(own)
            files.append(File(path, found, own.rows))
        except MemoryError:
            raise
        except Exception as error:
            files.append(File(path, reason=_reason(error, path)))
    return Part(None if sums is None else sums.to_bytes(), tuple(files))


def merge(*parts: Part) -> Part:
    """Parts as one, the same bits in any order."""
    sums = None
    for own in parts:
        if own.sums is not None:
            one = Summary.from_bytes(own.sums)
            try:
                sums = one if sums is None else sums.merge(one)
            except ValueError as error:
                if copies := _copies(parts):
                    raise _core.FitError(f"{copies}: {error}") from error
                raise
    files = sorted((file for own in parts for file in own.files), key=lambda file: file.path)
    return Part(None if sums is None else sums.to_bytes(), tuple(files))


def _copies(parts: Sequence[Part]) -> str:
    """Files of the same content, two for each that is there twice."""
    first: dict[str | None, str] = {}
    files = [file for own in parts for file in own.good]
    pairs = [(first.setdefault(file.checksum, file.path), file.path) for file in files]
    return ", ".join(f"{path} is a copy of {one}" for one, path in pairs if one != path)


def solve(part: Part, plan: Plan) -> tuple[str | None, bytes | None, dict[str, Any]]:
    """The model as JSON with what is known of it, or the request of another round."""
    if part.sums is None:
        raise _core.FitError("no file of the fleet can be used: see why of each")
    keys: tuple[str, ...] = (
        "friction",
        "kinds",
        "counterbalance",
        "refine",
        "noise_correction",
        "seed",
        "urdf",
        "lock",
    )
    keys += ("gravity", "select", "threshold", "n_bootstrap")
    options = {key: own for key, own in plan.of_fit().items() if key in keys}
    found = Summary.from_bytes(part.sums).solve(progress=False, **options)
    if isinstance(found, Fit):
        facts = {"verdict": found.verdict, "because": found.because, "warnings": found.warnings}
        return found.model.to_json(), None, {**facts, "summary": found.summary()}
    return None, found.to_bytes(), {}


def rounds(
    summed: Callable[[bytes | None, dict[str, str]], Part], plan: Plan
) -> tuple[Model, Part]:
    """The model of a fleet on any engine, and the files of the last round.

    summed: what the engine does: :func:`summarise` of all files, given request and checksums as here,
    and :func:`merge` of what that returns.
    """
    request: bytes | None = None
    known: dict[str, str] = {}
    left_out: dict[str, File] = {}
    for _ in range(MOST_ROUNDS):
        part = summed(request, known)
        known.update({own.path: own.checksum for own in part.good if own.checksum})
        left_out.update({own.path: own for own in part.bad})
        model, request, _ = solve(part, plan)
        if model is not None:
            files = sorted([*part.good, *left_out.values()], key=lambda own: own.path)
            return Model.from_json(model), Part(part.sums, tuple(files))
    raise _core.FitError(f"no model after {MOST_ROUNDS} rounds")


def pilot(paths: Sequence[str], plan: Plan) -> dict[str, Any]:
    """The filter of logs without accelerations, as a fit of some of them chooses it."""
    good = []
    for path in paths:
        try:
            with local(path, plan) as here:
                log = read_log(here, **{**plan.of_log(), "filter": "none", "delay": None})
                # Fails where its numbers are those of a damaged file.
                Summary.of(log, library="chain", progress=False)
            good.append(path)
        except Exception:
            continue
    if not good:
        return {}
    with tempfile.TemporaryDirectory() as folder:
        copies = []
        for number, path in enumerate(good):
            with local(path, plan) as here:
                if "://" in path:
                    copy = Path(folder) / f"{number}{Path(path).suffix}"
                    shutil.copyfile(here, copy)
                    here = str(copy)
                copies.append(here)
        log = read_log(copies, **plan.of_log())
        if not log.is_filtered or plan.options.get("filter", "auto") != "auto":
            return {}
        found = _core.fit(log, plan.of_fit(), None)
        filter = json.loads(found.model.to_json())["training"].get("filter")
    return {} if filter is None else {"filter": filter["cutoff_hz"], "delay": filter["delay"]}


def _reason(error: Exception, path: str) -> str:
    return " ".join(f"{type(error).__name__}: {error}".replace(path, "it").split())


def _kept(plan: Plan, request: bytes | None, found: str) -> str | None:
    """Where the sums of a file are kept: under its content, what is fitted, and the round."""
    if plan.store is None:
        return None
    digest = hashlib.blake2b(digest_size=16)
    digest.update(pickle.dumps((sorted(plan.options.items()), request, _core.__version__)))
    return f"{plan.store}/{found}-{digest.hexdigest()}.moments"


def _loaded(kept: str | None) -> Summary | None:
    if kept is None or not Path(kept).exists():
        return None
    try:
        return Summary.from_bytes(Path(kept).read_bytes())
    except _core.LogError:
        # Damaged: it is made again.
        return None


def _keep(kept: str | None, sums: Summary) -> None:
    if kept is not None:
        Path(kept).parent.mkdir(parents=True, exist_ok=True)
        _core.write_whole(kept, sums.to_bytes())
