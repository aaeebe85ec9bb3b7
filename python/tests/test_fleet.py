"""Many logs on workers: the same model, bad files, killed workers, and what changed."""

import json
import os
import pickle
import signal
import threading
import time
from datetime import date

import numpy as np
import pytest

import torquewise

distributed = pytest.importorskip("distributed")
pytest.importorskip("scipy")

from torquewise import fleet  # noqa: E402
from torquewise.fleet import _drift  # noqa: E402

OPTIONS = {"library": "chain", "friction": "linear"}
FRICTION = ((4.0, 3.0), (5.0, 4.0), (2.0, 1.5))


def make(path, seed, factor=1.0, seconds=30.0, rate=100):
    """A log of an arm whose third joint has more viscous friction by a factor."""
    friction = path.parent / "friction.toml"
    friction.write_text(
        "".join(
            f"[joint{k}]\ncoulomb = {dry}\nviscous = {viscous * (factor if k == 3 else 1)}\n"
            for k, (dry, viscous) in enumerate(FRICTION, 1)
        )
    )
    options = {"seconds": seconds, "rate": rate, "seed": seed, "case": 2}
    torquewise.simulate("puma560-3", friction=friction, path=path, **options)
    return str(path)


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    """Three robots, 14 weeks; the third joint of one turns harder from the eighth on."""
    folder = tmp_path_factory.mktemp("fleet")
    paths = []
    for robot in range(3):
        (folder / f"robot{robot}").mkdir()
        for week in range(14):
            factor = 1.2 if robot == 1 and week >= 7 else 1.0
            path = folder / f"robot{robot}" / f"week{week:02}.parquet"
            paths.append(make(path, 100 * robot + week, factor))
    return paths


@pytest.fixture(scope="module")
def cluster():
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=50
    ) as own:
        yield own


@pytest.fixture(scope="module")
def client(cluster):
    with distributed.Client(cluster) as own:
        yield own


@pytest.fixture(scope="module")
def one(logs):
    """The model of one process."""
    return torquewise.fit(logs[:14], progress=False, **OPTIONS).model


def test_workers_find_the_model_of_one_process_in_any_order(client, logs, one):
    told = []
    found = fleet.fit(
        list(reversed(logs[:14])), client, progress=lambda *own: told.append(own), **OPTIONS
    )

    assert found.model == one and found.rounds >= 2
    assert found.rows == 14 * 3000 and not found.bad
    assert sum(files for _, files, _ in told) == 14 * found.rounds


def test_a_pattern_of_a_store_stands_for_its_files(client, logs, one):
    folder = os.path.dirname(logs[0])

    assert fleet.fit(f"file://{folder}/*.parquet", client, **OPTIONS).model == one


def test_bad_files_are_named_and_the_rest_is_as_before(client, logs, one, tmp_path):
    contents = [b"", b"PAR1", open(logs[0], "rb").read()[:4000], b"\0" * 999]
    bad = [tmp_path / f"bad{k}.parquet" for k in range(4)]
    for path, content in zip(bad, contents):
        path.write_bytes(content)
    missing = str(tmp_path / "missing.parquet")

    found = fleet.fit([*logs[:14], *map(str, bad), missing], client, **OPTIONS)

    assert found.model == one
    assert [own.path for own in found.bad] == [*map(str, bad), missing]
    assert all(own.reason for own in found.bad) and "missing.parquet" not in found.bad[-1].reason


def test_files_whose_name_tells_no_robot_are_left_out(client, logs):
    options = {"by": ["robot"], "name": "{robot}/week0{week}.parquet", **OPTIONS}
    found = fleet.fit(logs[6:12], client, **options)

    assert [own.path for own in found.bad] == logs[10:12]
    assert all("is not called as" in own.reason for own in found.bad)
    assert found.model == torquewise.fit(logs[6:10], progress=False, **OPTIONS).model

    known = fleet.fit(
        logs[:2], client, by=["robot"], name=lambda path: {"robot": "a"} if "00" in path else {}
    )
    assert "does not tell 'robot'" in known.bad[0].reason


@pytest.mark.parametrize("size", [4.8e301, 1e12])
@pytest.mark.parametrize("signal", ["q", "dq", "ddq", "tau"])
def test_numbers_of_no_arm_are_the_fault_of_their_file(signal, size, logs, tmp_path):
    own = torquewise.simulate("puma560-3", seconds=20, rate=100, seed=5)
    own[signal][900:910, 1] = size
    bad = str(tmp_path / "bad.parquet")
    torquewise.write_log(bad, own)

    part = fleet.summarise([logs[0], bad, logs[1]], fleet.Plan(OPTIONS), None, {})

    assert [file.path for file in part.bad] == [bad] and part.sums is not None
    assert len(part.bad[0].reason) < 300


def test_a_damaged_file_does_not_stop_a_fleet(client, logs, one, tmp_path):
    """Bytes in the midst of a Parquet file are others, which its format may not notice."""
    noise, bad = np.random.default_rng(0), []
    content = open(logs[0], "rb").read()
    for number in range(3):
        damaged = bytearray(content)
        place = int(len(content) * (0.2 + 0.25 * number))
        damaged[place : place + 200] = noise.bytes(200)
        path = tmp_path / f"damaged{number}.parquet"
        path.write_bytes(damaged)
        bad.append(str(path))

    found = fleet.fit([*logs[:14], *bad], client, **OPTIONS)

    assert [own.path for own in found.bad] == bad and found.model == one


def test_a_damaged_pilot_does_not_stop_a_fleet(client, tmp_path):
    paths = []
    for seed in range(3):
        own = torquewise.simulate("planar-2", seconds=30, rate=200, seed=seed)
        if seed == 1:
            own["q"][3000:3020] = 4.8e301
        signals = {f"{key}{k + 1}": own[key][:, k] for key in ("q", "tau") for k in range(2)}
        paths.append(str(tmp_path / f"log{seed}.csv"))
        table = np.column_stack([own["t"], *signals.values()])
        np.savetxt(paths[-1], table, delimiter=",", header=",".join(["t", *signals]), comments="")

    found = fleet.fit(paths, client, friction="none")

    assert [file.path for file in found.bad] == [paths[1]]


def test_a_file_that_changes_during_a_run_is_left_out(logs, tmp_path):
    path = make(tmp_path / "log.parquet", 1)
    plan = fleet.Plan(OPTIONS)
    first = fleet.summarise([path], plan, None, {})
    (own,) = first.good
    make(tmp_path / "log.parquet", 2)

    second = fleet.summarise([path], plan, None, {own.path: own.checksum})

    assert second.sums is None and "changed since" in second.bad[0].reason


def test_copies_are_named(tmp_path):
    paths = [make(tmp_path / f"{name}.parquet", 1) for name in "ab"]
    parts = [fleet.summarise([path], fleet.Plan(OPTIONS), None, {}) for path in paths]

    with pytest.raises(torquewise.FitError, match="b.parquet is a copy of .*a.parquet"):
        fleet.merge(*parts)


def test_a_killed_worker_changes_nothing(cluster, client, logs, one):
    done = threading.Event()
    killed = []

    def kill():
        while not done.wait(0.8) and len(killed) < 3:
            pid = next((own.pid for own in cluster.workers.values() if own.pid), None)
            if pid is not None:
                os.kill(pid, signal.SIGKILL)
                killed.append(pid)

    thread = threading.Thread(target=kill)
    thread.start()
    found = fleet.fit(logs[:14], client, **OPTIONS)
    done.set()
    thread.join()

    assert killed and found.model == one and not found.bad


def test_a_run_goes_on_from_the_sums_it_has(client, logs, one, tmp_path):
    store = str(tmp_path / "sums")
    first = fleet.fit(logs[:14], client, store=store, **OPTIONS)
    kept = {path: path.stat().st_mtime_ns for path in (tmp_path / "sums").iterdir()}
    damaged = next(iter(kept))
    damaged.write_bytes(b"no sums")

    second = fleet.fit(logs[:14], client, store=store, **OPTIONS)

    assert first.model == second.model == one
    assert len(kept) == 14 * first.rounds
    again = {path: path.stat().st_mtime_ns for path in (tmp_path / "sums").iterdir()}
    assert {own for own in kept if kept[own] != again[own]} == {damaged}


def test_a_change_is_found_and_nobody_else_is_accused(client, logs, tmp_path):
    found = fleet.fit(
        logs, client, by=["robot", "week"], name="{robot}/week{week}.parquet", **OPTIONS
    )

    (change,) = found.changes
    assert (change.robot, change.joint, change.parameter) == ("robot1", "joint3", "viscous")
    assert (change.since, change.when) == ("07", "week 07")
    assert change.percent == pytest.approx(20.0, abs=4.0)
    assert "viscous friction +" in str(change) and "since week 07" in repr(found)
    assert sorted(found.models) == ["robot0", "robot1", "robot2"]
    mine = torquewise.fit(logs[:14], progress=False, **OPTIONS).model
    assert found.models["robot0"] == mine

    found.save(tmp_path / "out")
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {"model.json", "models", "files.csv", "drift.parquet", "fleet.html"}
    page = (tmp_path / "out/fleet.html").read_text()
    for shown in ("robot1", "viscous", "<svg", "week 07", torquewise.__version__, "library="):
        assert shown in page
    assert f"{date.today():%Y-%m-%d}" in page
    assert found.table().num_rows == 42 * 3 * 4


def test_without_a_change_the_level_is_kept():
    """A thousand fleets of noise: at 5 % no more are accused than that allows."""
    noise = np.random.default_rng(0)
    accused = 0
    for _ in range(300):
        logs = [
            (k, _drift.Reading("", noise.standard_normal((1, 4)), np.ones((1, 4)), np.ones(1)))
            for k in range(16)
        ]
        accused += bool(_drift.jumps({"robot": logs}, ["joint"], {}, 0.05))

    assert accused <= 300 * 0.05 + 3 * np.sqrt(300 * 0.05)


def test_logs_without_accelerations_are_filtered_alike(client, tmp_path):
    paths = []
    for seed in range(3):
        own = torquewise.simulate("planar-2", seconds=60, rate=200, seed=seed, case=1)
        path = tmp_path / f"log{seed}.npz"
        np.savez(path, t=own["t"], q=own["q"], tau=own["tau"])
        paths.append(str(path))
    profile = tmp_path / "profile.toml"
    profile.write_text('t = { column = "t" }\nq = { columns = "q" }\ntau = { columns = "tau" }\n')

    found = fleet.fit(paths, client, profile=str(profile), friction="none")

    own = {key: found.plan.options[key] for key in ("filter", "delay", "profile")}
    assert own["filter"] > 0
    one = torquewise.fit(paths, progress=False, friction="none", **own).model
    # Noise of filtered logs is measured file by file, not in all together.
    state = [np.random.default_rng(0).uniform(-1, 1, (9, 2)) for _ in range(3)]
    assert np.allclose(found.model.torque(*state), one.torque(*state), rtol=1e-4, atol=1e-3)
    filters = [json.loads(model.to_json())["training"]["filter"] for model in (found.model, one)]
    assert filters[0] == filters[1] and filters[0]["cutoff_hz"] == own["filter"]


def test_a_cancelled_run_leaves_no_tasks(client, logs):
    def stop(*_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fleet.fit(logs, client, progress=stop, **OPTIONS)
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline and any(client.processing().values()):
        time.sleep(0.2)
    assert not any(client.processing().values())


def test_a_file_that_kills_workers_is_isolated(client, logs, one, tmp_path, monkeypatch):
    from torquewise.fleet import _dask

    poison = str(tmp_path / "poison.parquet")
    (tmp_path / "poison.parquet").write_bytes(b"x")
    monkeypatch.setattr(_dask, "summarise", dying)

    found = fleet.fit([*logs[:14], poison], client, retries=0, **OPTIONS)

    assert found.model == one
    assert [own.path for own in found.bad] == [poison] and "died" in found.bad[0].reason


def dying(paths, plan, request, known):
    if any("poison" in path for path in paths):
        os.kill(os.getpid(), signal.SIGKILL)
    return fleet.summarise(paths, plan, request, known)


def test_parts_are_picklable_and_keys_are_checked(logs):
    part = fleet.summarise(logs[:1], fleet.Plan(OPTIONS), None, {})
    assert pickle.loads(pickle.dumps(part)) == part and json.dumps(part.files[0].path)
    with pytest.raises(ValueError, match="at most two"):
        fleet.fit(logs, by=["a", "b", "c"])
    with pytest.raises(ValueError, match="name: say how"):
        fleet.fit(logs, by=["robot"])
    with pytest.raises(ValueError, match="is not called as"):
        fleet.fit(logs, by=["robot"], name="{robot}.csv")
    with pytest.raises(ValueError, match="stand for none"):
        fleet.fit("nothing*.parquet")
