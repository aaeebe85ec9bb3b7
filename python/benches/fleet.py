"""A fleet of simulated robots, fitted by one process and by workers, with workers killed.

    pip install './python[dask]' psutil
    python python/benches/fleet.py

20 robots of three joints, 50 logs of 10 000 rows each; friction differs from robot to robot, and that
of one joint of one robot grows by a fifth in the middle. Prints what docs/fleet.md holds.
"""

import argparse
import random
import resource
import signal
import tempfile
import threading
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import psutil
from distributed import Client

import torquewise
from torquewise import fleet
from torquewise.fleet import _dask

OPTIONS = {"library": "chain", "friction": "linear"}
COULOMB, VISCOUS = (4.0, 5.0, 2.0), (3.0, 4.0, 1.5)
DRIFTS = ("robot17", 2, 1.2)  # robot, joint from 0, factor


def make(task):
    """One log of one robot."""
    folder, robot, log, logs, seconds = task
    path = folder / f"robot{robot:02}" / f"week{log // 2 + 1:02}-{log % 2}.parquet"
    if path.exists():
        return str(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    own = random.Random(robot)
    text = []
    for joint, (coulomb, viscous) in enumerate(zip(COULOMB, VISCOUS)):
        coulomb, viscous = (x * own.uniform(0.9, 1.1) for x in (coulomb, viscous))
        if (f"robot{robot:02}", joint) == DRIFTS[:2] and log >= logs // 2:
            viscous *= DRIFTS[2]
        text.append(f"[joint{joint + 1}]\ncoulomb = {coulomb}\nviscous = {viscous}\n")
    with tempfile.NamedTemporaryFile("w", suffix=".toml") as friction:
        friction.write("".join(text))
        friction.flush()
        seed = 1000 * robot + log
        options = {"seconds": seconds, "rate": 100, "seed": seed, "case": 2}
        torquewise.simulate("puma560-3", friction=friction.name, path=path, **options)
    return str(path)


class Watch(threading.Thread):
    """Memory and processor time of the workers; kills one now and then."""

    def __init__(self, cluster, kills=0, seed=0):
        super().__init__(daemon=True)
        self.cluster, self.kills, self.random = cluster, kills, random.Random(seed)
        self.killed, self.peak, self.cpu, self.done = 0, 0, {}, threading.Event()

    def run(self):
        begin, wait = time.monotonic(), self.random.uniform(3, 6)
        while not self.done.wait(0.1):
            for pid in self.pids():
                try:
                    process = psutil.Process(pid)
                    self.peak = max(self.peak, process.memory_info().rss)
                    times = process.cpu_times()
                    self.cpu[pid] = times.user + times.system
                except psutil.NoSuchProcess:
                    continue
            if self.killed < self.kills and time.monotonic() - begin > wait:
                pids = self.pids()
                if pids:
                    psutil.Process(self.random.choice(pids)).send_signal(signal.SIGKILL)
                    self.killed += 1
                begin, wait = time.monotonic(), self.random.uniform(3, 6)

    def pids(self):
        return [own.pid for own in self.cluster.workers.values() if own.pid]


def run(paths, workers, kills=0, **options):
    with _dask.processes(workers) as cluster, Client(cluster) as client:
        watch = Watch(cluster, kills)
        idle = sum(psutil.Process(pid).cpu_times().user for pid in watch.pids())
        own = resource.getrusage(resource.RUSAGE_SELF)
        before = own.ru_utime + own.ru_stime
        watch.start()
        begin = time.monotonic()
        found = fleet.fit(paths, client, **OPTIONS, **options)
        seconds = time.monotonic() - begin
        watch.done.set()
        watch.join()
        own = resource.getrusage(resource.RUSAGE_SELF)
        driver = own.ru_utime + own.ru_stime - before
    cpu = sum(watch.cpu.values()) - idle
    print(
        f"{workers} workers, {watch.killed} killed: {seconds:.0f} s, workers {cpu:.0f} s of processor, "
        f"driver {driver:.1f} s ({100 * driver / (cpu + driver):.1f} %), peak of a worker "
        f"{watch.peak / 1e6:.0f} MB, {found.rounds} rounds, {len(found.bad)} files left out",
        flush=True,
    )
    return found


def tree(paths, workers):
    """What the last round costs where each of so many workers has a task of eight files."""
    plan = fleet.Plan(options=OPTIONS)
    found = fleet.merge(*(fleet.summarise([path], plan, None, {}) for path in paths))
    known = {file.path: file.checksum for file in found.files}
    request = fleet.solve(found, plan)[1]
    begin = time.process_time()
    parts = [fleet.summarise([path], plan, request, known) for path in paths]
    task, begin = (time.process_time() - begin) * _dask.FILES / len(paths), time.process_time()
    fleet.merge(*parts[: _dask.FAN_IN])
    merge = time.process_time() - begin
    waiting, merges, levels = workers, 0, 0
    while waiting > 1:
        waiting = -(-waiting // _dask.FAN_IN)
        merges, levels = merges + waiting, levels + 1
    print(
        f"simulated, {workers} workers: a task {task:.2f} s of processor, then {levels} levels of "
        f"merges of {merge:.3f} s each; merges are {100 * merges * merge / (workers * task):.1f} % of "
        f"all; {len(parts[0].sums) / 1e6:.1f} MB from each worker",
        flush=True,
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--robots", type=int, default=20)
    parser.add_argument("--logs", type=int, default=50, help="of each robot")
    parser.add_argument("--seconds", type=float, default=100.0, help="of each log")
    parser.add_argument(
        "--folder", type=Path, default=Path(tempfile.gettempdir()) / "torquewise-fleet"
    )
    parser.add_argument("--workers", type=int, nargs="*", default=[1, 2, 4])
    parser.add_argument("--simulated", type=int, nargs="*", default=[8, 64, 1024])
    parser.add_argument("--kills", type=int, default=5)
    arguments = parser.parse_args()
    tasks = [
        (arguments.folder, robot, log, arguments.logs, arguments.seconds)
        for robot in range(1, arguments.robots + 1)
        for log in range(arguments.logs)
    ]
    with ProcessPoolExecutor() as pool:
        paths = sorted(pool.map(make, tasks, chunksize=8))
    size = sum(Path(path).stat().st_size for path in paths)
    print(f"{len(paths)} logs, {size / 1e6:.0f} MB", flush=True)

    for workers in arguments.simulated:
        tree(paths[:16], workers)

    own = resource.getrusage(resource.RUSAGE_SELF)
    before = own.ru_utime + own.ru_stime
    begin = time.monotonic()
    one = torquewise.fit(paths, progress=False, **OPTIONS)
    own = resource.getrusage(resource.RUSAGE_SELF)
    cpu = own.ru_utime + own.ru_stime - before
    print(f"one process: {time.monotonic() - begin:.0f} s, {cpu:.0f} s of processor", flush=True)

    for workers in arguments.workers:
        assert run(paths, workers).model == one.model
    assert run(paths, 2, kills=arguments.kills).model == one.model

    bad = [arguments.folder / f"bad{k}.parquet" for k in range(10)]
    for k, path in enumerate(bad):
        content = Path(paths[k]).read_bytes()
        path.write_bytes([b"", b"PAR1", content[: len(content) // 2], b"\x00" * 4096][k % 4])
    found = run([*paths, *map(str, bad)], 2)
    assert found.model == one.model and [own.path for own in found.bad] == sorted(map(str, bad))
    for own in found.bad[:4]:
        print(f"  {Path(own.path).name}: {own.reason}")

    found = run(paths, 2, by=["robot", "week"], name="{robot}/{week}-*.parquet")
    print(found)


if __name__ == "__main__":
    main()
