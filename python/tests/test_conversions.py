"""What is taken for a log, and that all forms of one log give one model."""

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import torquewise


def columns(log):
    found = {"t": log["t"]}
    for key in ("q", "dq", "ddq", "tau"):
        for k in range(log[key].shape[1]):
            found[f"{key}{k + 1}"] = log[key][:, k].copy()
    return found


@pytest.mark.parametrize("make", [dict, pd.DataFrame, pl.DataFrame, pa.table])
def test_a_table_of_any_package_gives_the_model_of_the_arrays(make, train, model):
    table = make(columns(train))

    assert torquewise.fit(table, progress=False).model == model


def test_a_table_in_parts_is_read_across_them(train, model):
    whole = pa.table(columns(train))
    parts = pa.concat_tables([whole.slice(0, 1500), whole.slice(1500, 7), whole.slice(1507)])

    assert parts.column("q1").num_chunks == 3
    assert torquewise.fit(parts, progress=False).model == model


def test_any_object_with_arrows_interface_is_a_table(train, model):
    class Carrier:
        def __init__(self, table):
            self.table = table

        def __arrow_c_stream__(self, requested_schema=None):
            return self.table.__arrow_c_stream__(requested_schema)

    assert torquewise.fit(Carrier(pa.table(columns(train))), progress=False).model == model


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_a_written_log_gives_the_same_model(ending, tmp_path, train, model):
    torquewise.write_log(tmp_path / f"log.{ending}", train)

    assert torquewise.fit(tmp_path / f"log.{ending}", progress=False).model == model


def test_arrays_by_keyword_and_a_rate_are_a_log(train, model):
    own = torquewise.fit(
        q=train["q"], dq=train["dq"], ddq=train["ddq"], tau=train["tau"], rate=100.0, progress=False
    )

    q, dq, ddq = (train[key][:50] for key in ("q", "dq", "ddq"))
    assert np.allclose(own.model.torque(q, dq, ddq), model.torque(q, dq, ddq), atol=1e-6)


def test_strides_and_order_in_memory_do_not_matter(train, model):
    fortran = {key: np.asfortranarray(train[key]) for key in ("q", "dq", "ddq", "tau")}
    wide = {key: np.hstack([train[key], train[key]])[:, :2] for key in fortran}

    for own in (fortran, wide):
        assert torquewise.fit(own, t=None, progress=False, rate=100).model.joints == model.joints
        assert torquewise.fit({**own, "t": train["t"]}, progress=False).model == model


def test_single_precision_and_whole_numbers_are_converted():
    log = torquewise.read_log(
        q=np.zeros((9, 2), dtype=np.float32), t=np.arange(9), tau=np.ones((9, 2))
    )

    (own,) = log.trajectories()
    assert own["q"].dtype == np.float64 and own["t"][-1] == 8.0


def test_a_log_is_conditioned_as_a_fit_saw_it(train):
    log = torquewise.read_log({key: own for key, own in train.items() if key != "ddq"})
    fit = torquewise.fit(log, progress=False)

    (own,) = log.trajectories(conditioned=True, model=fit.model)
    assert len(own["t"]) == fit.summary()["rows"]


def test_several_logs_are_trajectories(train, test):
    log = torquewise.read_log([train, test])

    assert [len(own["t"]) for own in log.trajectories()] == [6000, 1000]


def test_times_of_frames_are_seconds(train, model):
    times = pd.Timestamp("2026-03-01", tz="Europe/Berlin") + pd.to_timedelta(train["t"], unit="s")
    signals = {key: own for key, own in columns(train).items() if key != "t"}
    frame = pd.DataFrame(signals)

    for table in (
        frame.set_index(pd.DatetimeIndex(times)),
        frame.set_index(pd.TimedeltaIndex(times - times[0])),
        frame.set_index(pd.Index(train["t"], name="t")),
        frame.assign(t=times),
        pl.DataFrame({"t": pl.Series(times.tz_localize(None)), **signals}),
        pa.table({"t": pa.array(times.tz_localize(None)), **signals}),
    ):
        (own,) = torquewise.read_log(table).trajectories()
        assert np.allclose(own["t"], train["t"], rtol=0, atol=1e-6)
        assert np.array_equal(own["tau"], train["tau"])


@pytest.mark.parametrize("make", [dict, pd.DataFrame, pl.DataFrame, pa.table])
def test_columns_that_are_no_numbers_are_named_or_left_out(make):
    rows = {"t": np.arange(9.0), "q1": np.zeros(9), "mode": ["auto"] * 9}
    assert torquewise.read_log(make(rows)).joints == ["joint1"]

    for values in ([True] * 9, ["0.5"] * 9):
        with pytest.raises(torquewise.LogError, match="column q1 holds .* not numbers"):
            torquewise.read_log(make({**rows, "q1": np.array(values)}))


def test_signals_of_objects_or_many_dimensions_are_named():
    t = np.arange(9.0)
    with pytest.raises(torquewise.LogError, match="column q holds object"):
        torquewise.read_log(t=t, q=np.zeros((9, 2)).astype(object))
    with pytest.raises(ValueError, match=r"dq is of shape \(9, 2, 1\)"):
        torquewise.read_log(t=t, q=np.zeros((9, 2)), dq=np.zeros((9, 2, 1)))
    with pytest.raises(ValueError, match="t is of shape"):
        torquewise.read_log(t=t[:, None], q=np.zeros((9, 2)))


def test_masked_values_have_no_number(train):
    q = np.ma.array(train["q"])
    assert torquewise.read_log({**train, "q": q}).trajectories()
    q[1234, 1] = np.ma.masked

    with pytest.raises(torquewise.LogError, match="row 1235.*q2"):
        torquewise.read_log({**train, "q": q}).trajectories()
    (own,) = torquewise.read_log({**train, "q": q}, repair=True).trajectories()
    assert len(own["t"]) == len(train["t"]) - 1


def test_options_that_would_be_ignored_are_refused(train, tmp_path):
    with pytest.raises(torquewise.UsageError, match="rate and t"):
        torquewise.read_log(train, rate=50)
    torquewise.write_log(tmp_path / "log.csv", train)
    with pytest.raises(torquewise.UsageError, match="rate: not for files"):
        torquewise.read_log(tmp_path / "log.csv", rate=50)
    with pytest.raises(torquewise.UsageError, match="filter: not for an opened log"):
        torquewise.fit(torquewise.read_log(train), filter="none")


def test_joint_names_are_kept(train):
    assert torquewise.read_log(train, joints=["hip", "knee"]).joints == ["hip", "knee"]


def test_trajectories_come_back_as_they_were(train):
    (own,) = torquewise.read_log(train).trajectories()

    for key in ("t", "q", "dq", "ddq", "tau"):
        assert np.array_equal(own[key], train[key])


def test_lists_are_states(model):
    assert np.allclose(model.torque([0.1, 0.2], [0, 0], [0, 0]), model.gravity([0.1, 0.2]))


def test_a_log_is_not_copied():
    import tracemalloc

    rows = 400_000
    t = np.arange(rows) * 0.01
    q = np.sin(np.outer(t, [0.3, 0.5]))
    tracemalloc.start()
    log = torquewise.read_log(t=t, q=q)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()

    assert peak < q.nbytes / 10
    assert log.joints == ["joint1", "joint2"]


def test_a_bit_turned_within_a_page_of_parquet_is_noticed(tmp_path):
    own = torquewise.simulate("planar-2", seconds=30, rate=100)
    columns = {f"{key}{k + 1}": own[key][:, k] for key in ("q", "tau") for k in range(2)}
    path = tmp_path / "log.parquet"
    table = pa.table({"t": own["t"], **columns})
    pq.write_table(table, path, compression="none", use_dictionary=False, write_page_checksum=True)
    torquewise.read_log(path)
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)

    with pytest.raises(torquewise.LogError, match="log.parquet"):
        torquewise.Summary.of(path, library="chain")
