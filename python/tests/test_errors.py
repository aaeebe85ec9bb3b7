"""Each mistake is an exception that says what to do."""

import numpy as np
import pytest

import torquewise


def test_a_file_that_is_not_there():
    with pytest.raises(FileNotFoundError, match="missing.csv"):
        torquewise.fit("missing.csv")


def test_a_log_without_positions():
    with pytest.raises(torquewise.LogError, match="no column"):
        torquewise.read_log({"t": np.arange(9.0), "x": np.arange(9.0)})


def test_a_log_without_torque():
    t = np.arange(900) * 0.01
    with pytest.raises(torquewise.LogError, match="tau"):
        torquewise.fit(t=t, q=np.sin(t)[:, None])


def test_columns_of_different_lengths():
    with pytest.raises(ValueError, match="one length"):
        torquewise.read_log({"t": np.arange(9.0), "q": np.zeros((8, 2))})


def test_numbers_that_are_not_finite_name_their_row(train):
    q = train["q"].copy()
    q[1234, 1] = np.nan
    with pytest.raises(torquewise.LogError, match="row 1235.*q2"):
        torquewise.fit({**train, "q": q}, progress=False)


def test_an_option_that_is_none(train):
    for value in ("chain", train["q"]):
        with pytest.raises(torquewise.UsageError, match="libary is no option"):
            torquewise.fit(train, libary=value)


def test_a_word_that_is_not_known(train):
    with pytest.raises(ValueError, match="expected one of energy, product, chain"):
        torquewise.fit(train, library="chian")


def test_options_that_contradict_each_other(train):
    with pytest.raises(torquewise.UsageError, match="threshold is not used"):
        torquewise.fit(train, library="chain", threshold=0.1)


def test_a_value_of_the_wrong_kind(train):
    with pytest.raises(ValueError, match="seed"):
        torquewise.fit(train, seed="x")


def test_arrays_that_do_not_fit_the_model(model):
    with pytest.raises(torquewise.ModelError, match="2"):
        model.torque([0.0] * 3, [0.0] * 3, [0.0] * 3)
    with pytest.raises(ValueError, match="one column for each joint"):
        model.torque(np.zeros((5, 3)), np.zeros((5, 3)), np.zeros((5, 3)))
    with pytest.raises(ValueError, match="as many states"):
        model.torque(np.zeros((5, 2)), np.zeros((4, 2)), np.zeros((5, 2)))
    with pytest.raises(ValueError, match="numbers of one or several states"):
        model.gravity("abc")


def test_a_file_that_is_no_model(tmp_path):
    (tmp_path / "model.json").write_text("{}")
    with pytest.raises(torquewise.ModelError):
        torquewise.Model.load(tmp_path / "model.json")


def test_another_arm(model):
    log = torquewise.simulate("puma560-3", seconds=5, rate=100)
    with pytest.raises(torquewise.ModelError, match="joint"):
        model.evaluate(log)


def test_what_is_no_log():
    with pytest.raises(TypeError, match="no log"):
        torquewise.fit(3)


def test_columns_that_are_not_understood_get_a_profile(tmp_path):
    t = np.arange(200) * 0.01
    rows = np.column_stack([t, np.sin(t), np.cos(t)])
    path = tmp_path / "robot.csv"
    np.savetxt(path, rows, delimiter=",", header="time,pos_1,torque_1", comments="")
    with pytest.raises(torquewise.ColumnError, match=r"columns = .*pos_"):
        torquewise.inspect(path)
    with pytest.raises(torquewise.ColumnError, match="has no column") as refused:
        torquewise.fit(path)
    assert "columns =" not in str(refused.value)


def test_all_exceptions_are_of_one_family():
    for own in (
        torquewise.LogError,
        torquewise.FitError,
        torquewise.ModelError,
        torquewise.UsageError,
    ):
        assert issubclass(own, torquewise.TorquewiseError) and issubclass(own, ValueError)
    assert issubclass(torquewise.ColumnError, torquewise.LogError)
    assert issubclass(torquewise.Interrupted, KeyboardInterrupt)


def test_nothing_is_written_where_writing_fails(tmp_path, model):
    with pytest.raises(OSError):
        model.export(tmp_path / "missing" / "arm.c")
    assert not list(tmp_path.iterdir())


def test_a_keyword_that_is_nearly_one_is_named(train):
    with pytest.raises(torquewise.UsageError, match="frictions is no option .* mean friction"):
        torquewise.fit(train, frictions="auto")
