"""Rounds of a fleet on Dask: only sums travel, and they are merged on the workers."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from ._core import File, Part, Plan, merge, summarise

#: Files of one task, parts of one merge.
FILES = 8
FAN_IN = 8

#: How many sums may be lost to dying workers before a run is given up.
_LOSSES = 100

#: Of the C library's allocator. By Dask's own setting each block of rows is returned to the system
#: as soon as it is done with, which takes a third of the processor time.
_ALLOCATOR = {"MALLOC_TRIM_THRESHOLD_": 256 << 20, "MALLOC_MMAP_THRESHOLD_": 32 << 20}


@contextmanager
def connected(client: Any) -> Iterator[Any]:
    """A client: as given, of an address, or of processes of this machine while this lasts."""
    try:
        from distributed import Client
    except ImportError:
        raise ImportError("fleets are fitted by Dask: pip install 'torquewise[dask]'") from None
    if client is None:
        with processes() as cluster, Client(cluster) as own:
            yield own
    elif isinstance(client, str):
        with Client(client) as own:
            yield own
    else:
        yield client


@contextmanager
def processes(number: int | None = None) -> Iterator[Any]:
    """A cluster of processes of this machine, one thread each; one for each processor, or `number`."""
    import dask
    from distributed import LocalCluster

    with (
        dask.config.set({"distributed.nanny.pre-spawn-environ": _ALLOCATOR}),
        LocalCluster(
            n_workers=number,
            threads_per_worker=1,
            processes=True,
            dashboard_address=None,
            env={"RAYON_NUM_THREADS": "1"},
        ) as cluster,
    ):
        yield cluster


def reduced(
    client: Any,
    batches: Sequence[Sequence[str]],
    plan: Plan,
    request: bytes | None,
    known: dict[str, str],
    told: Callable[[int], None],
    retries: int,
) -> Any:
    """A future of the :class:`Part` of all batches, by a tree of merges on the workers."""
    waiting = list(reversed(batches))
    suspects: list[str] = []
    alone: set[str] = set()
    running: dict[Any, Sequence[str]] = {}
    # What each sum stands for: done again where a dying worker takes it along.
    merging: dict[Any, list[Sequence[str]]] = {}
    ready: dict[Any, list[Sequence[str]]] = {}
    seen: set[str] = set()
    lost = 0
    room = 2 * max(1, len(client.scheduler_info()["workers"]))

    def submit(batch: Sequence[str]) -> None:
        own = {path: known[path] for path in batch if path in known}
        future = client.submit(
            summarise, tuple(batch), plan, request, own, pure=False, retries=retries
        )
        running[future] = batch

    def join(some: list[Any]) -> None:
        future = client.submit(merge, *some, pure=False, priority=10, retries=retries)
        merging[future] = [batch for own in some for batch in ready.pop(own)]

    def done(batch: Sequence[str]) -> None:
        told(len(set(batch) - seen))
        seen.update(batch)

    try:
        while waiting or suspects or running or merging or len(ready) != 1:
            while waiting and len(running) < room:
                submit(waiting.pop())
            if suspects and not (waiting or running or merging):
                # Alone, so that nothing else is blamed for a worker that dies.
                alone.add(suspects[-1])
                submit([suspects.pop()])
            is_last = not (waiting or suspects or running or merging)
            while len(ready) >= FAN_IN or (len(ready) > 1 and is_last):
                join(list(ready)[:FAN_IN])
                is_last = False
            if not (running or merging):
                return client.submit(Part, None, (), pure=False)
            for future in _finished([*running, *merging]):
                if future in merging:
                    batches = merging.pop(future)
                    if future.status == "finished":
                        ready[future] = batches
                    else:
                        lost += 1
                        if lost > _LOSSES or not _is_of_a_dead_worker(future):
                            raise future.exception()
                        waiting.extend(batches)
                    continue
                batch = running.pop(future)
                if future.status == "finished":
                    done(batch)
                    ready[future] = [batch]
                elif batch[0] in alone:
                    done(batch)
                    ready[_left_out(client, future, batch[0])] = [batch]
                else:
                    suspects.extend(batch)
        return next(iter(ready))
    except BaseException:
        client.cancel([*running, *merging, *ready], force=True)
        raise


def joined(client: Any, parts: Sequence[Any], retries: int) -> Any:
    """A future of several as one, merged on the workers; those merged stay as they are."""
    parts = list(parts)
    while len(parts) > 1:
        groups = [parts[first : first + FAN_IN] for first in range(0, len(parts), FAN_IN)]
        parts = [
            own[0] if len(own) == 1 else client.submit(merge, *own, pure=False, retries=retries)
            for own in groups
        ]
    return parts[0]


def files_of(part: Part) -> tuple[File, ...]:
    """What became of the files of a part."""
    return part.files


def _finished(futures: list[Any]) -> list[Any]:
    from distributed import wait

    return list(wait(futures, return_when="FIRST_COMPLETED").done)


def _is_of_a_dead_worker(future: Any) -> bool:
    from distributed import KilledWorker

    return future.status == "error" and isinstance(future.exception(), KilledWorker)


def _left_out(client: Any, future: Any, path: str) -> Any:
    """A file whose worker dies or fails where nothing else runs."""
    reason = f"its worker died or failed: {future.exception()!r}"
    return client.submit(Part, None, (File(path, reason=reason),), pure=False)


def called(client: Any, function: Callable[..., Any], *arguments: Any, retries: int = 3) -> Any:
    """What a function returns on a worker."""
    future = client.submit(function, *arguments, pure=False, retries=retries)
    try:
        return future.result()
    except BaseException:
        client.cancel([future], force=True)
        raise
