"""What is taken for a log, and that all forms of one log give one model."""

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
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


def test_several_logs_are_trajectories(train, test):
    log = torquewise.read_log([train, test])

    assert [len(own["t"]) for own in log.trajectories()] == [6000, 1000]


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
