"""Estimators follow scikit-learn; the words are those of PyOneShot."""

import pickle
import warnings

import numpy as np
import pytest

import torquewise
from torquewise import Chain, OneShot, Stepwise

pytest.importorskip("sklearn")

from sklearn.base import clone, is_regressor
from sklearn.exceptions import NotFittedError
from sklearn.model_selection import GridSearchCV, GroupKFold, cross_val_score
from sklearn.pipeline import make_pipeline
from sklearn.utils.estimator_checks import estimator_checks_generator


def table(log):
    return np.hstack([log["q"], log["dq"], log["ddq"]]), log["tau"]


@pytest.mark.parametrize("kind", [Stepwise, Chain, OneShot])
def test_all_ways_to_give_a_motion_are_one(kind, train, test):
    options = {} if kind is not Stepwise else {"n_bootstrap": 0}
    signals = [train[key] for key in ("q", "dq", "ddq", "tau")]
    by_signals = kind(**options).fit(*signals)
    by_table = kind(**options).fit(*table(train))
    by_motions = kind(**options).fit([{**train, "t": np.arange(6000) / 100.0}])

    assert by_signals.model_ == by_table.model_ == by_motions.model_
    rows, truth = table(test)
    assert np.array_equal(by_table.predict(rows), by_table.predict(test))
    assert by_table.predict(rows).shape == truth.shape
    # The baseline keeps the terms beyond its threshold, and is worse for it.
    assert by_table.score(rows, truth) > 0.9
    assert by_table.score(rows, truth) == pytest.approx(by_table.score(test))
    assert by_table.score(*(test[key] for key in ("q", "dq", "ddq", "tau"))) > 0.9


def test_trajectories_are_told_apart_by_groups(train):
    halves = [
        {key: train[key][own] for key in ("t", "q", "dq", "ddq", "tau")}
        for own in (slice(3000), slice(3000, None))
    ]
    groups = np.repeat([0, 1], 3000)
    by_list = Stepwise(n_bootstrap=0).fit(halves)
    by_groups = Stepwise(n_bootstrap=0).fit(*table(train), t=train["t"], groups=groups)

    assert by_list.model_ == by_groups.model_


def test_parameters_are_read_set_and_cloned():
    own = OneShot(threshold=0.05, rate=200.0)

    assert own.get_params() == {
        "threshold": 0.05,
        "trig_order": None,
        "select": None,
        "seed": 0,
        "rate": 200.0,
        "kinds": None,
    }
    assert clone(own).get_params() == own.get_params()
    assert own.set_params(threshold=0.2).threshold == 0.2
    assert repr(own) == "OneShot(rate=200.0, threshold=0.2)"
    with pytest.raises(ValueError, match="Invalid parameter"):
        own.set_params(treshold=1)


def test_grouped_folds_choose_a_threshold(train):
    rows, truth = table(train)
    groups = np.arange(6000) // 1000
    search = GridSearchCV(
        OneShot(trig_order=2), {"threshold": [0.01, 10.0]}, cv=GroupKFold(3), error_score="raise"
    )
    search.fit(rows, truth, groups=groups)

    assert search.best_params_ == {"threshold": 0.01}
    assert (
        cross_val_score(OneShot(trig_order=2), rows, truth, cv=GroupKFold(3), groups=groups).min()
        > 0.5
    )


def test_it_ends_a_pipeline(train):
    from sklearn.preprocessing import FunctionTransformer

    own = make_pipeline(FunctionTransformer(), Stepwise(n_bootstrap=0)).fit(*table(train))

    assert is_regressor(own) and own.score(*table(train)) > 0.999


def test_a_fitted_one_is_pickled(train, test):
    own = Stepwise(n_bootstrap=0).fit(*table(train))
    again = pickle.loads(pickle.dumps(own))

    assert np.array_equal(again.predict(test), own.predict(test))
    assert again.equations() == own.equations() and again.complexity == own.complexity


def test_the_words_of_pysindy(train, capsys):
    own = Stepwise(n_bootstrap=0).fit(*table(train))

    assert own.coefficients().shape == (2, len(own.get_feature_names()))
    own.print()
    assert "tau2 = " in capsys.readouterr().out


def test_one_that_is_not_fitted_says_so():
    with pytest.raises(NotFittedError):
        Stepwise().predict(np.zeros((3, 6)))


def test_what_does_not_fit_is_refused(train):
    with pytest.raises(ValueError, match="three columns for each"):
        Stepwise().fit(np.zeros((9, 5)), np.zeros((9, 2)))
    with pytest.raises(TypeError, match="fit takes"):
        Stepwise().fit(1, 2, 3)


# Most checks of scikit-learn draw X with ten, two or one columns, of any rows. Ours have q, dq and ddq
# of each joint, three columns for each of y, and a motion in them: such X is refused, which the check
# takes for a failure. What these check is tested above and below on motions.
NOT_A_MOTION = {
    "check_dict_unchanged",
    "check_dont_overwrite_parameters",
    "check_dtype_object",
    "check_estimators_dtypes",
    "check_estimators_empty_data_messages",
    "check_estimators_fit_returns_self",
    "check_estimators_nan_inf",
    "check_estimators_overwrite_params",
    "check_estimators_pickle",
    "check_f_contiguous_array_estimator",
    "check_fit2d_1feature",
    "check_fit2d_1sample",
    "check_fit2d_predict1d",
    "check_fit_check_is_fitted",
    "check_fit_idempotent",
    "check_fit_score_takes_y",
    "check_methods_sample_order_invariance",
    "check_methods_subset_invariance",
    "check_n_features_in",
    "check_n_features_in_after_fitting",
    "check_pipeline_consistency",
    "check_positive_only_tag_during_fit",
    "check_readonly_memmap_input",
    "check_regressor_data_not_an_array",
    "check_regressor_multioutput",
    "check_regressors_int",
    "check_regressors_no_decision_function",
    "check_regressors_train",
    "check_supervised_y_2d",
}


def _checks():
    for estimator in (Stepwise(), Chain(), OneShot()):
        for own, check in estimator_checks_generator(estimator, legacy=True):
            name = check.func.__name__
            marks = pytest.mark.xfail(strict=True, reason="X of other columns than q, dq, ddq")
            yield pytest.param(
                own,
                check,
                id=f"{type(own).__name__}-{name}",
                marks=marks if name in NOT_A_MOTION else (),
            )


@pytest.mark.parametrize("estimator, check", list(_checks()))
def test_checks_of_scikit_learn(estimator, check):
    check(estimator)


def test_what_the_others_check_holds_for_motions(train, tmp_path):
    rows, truth = table(train)
    np.save(tmp_path / "rows.npy", rows)
    own = Stepwise(n_bootstrap=0)
    before = dict(own.get_params())
    assert own.fit(rows, truth) is own and own.get_params() == before
    model, state = own.model_, dict(own.__dict__)

    # Reading does not change it, rows are on their own, and a second fit is the first.
    found = own.predict(rows)
    assert own.__dict__ == state and own.n_features_in_ == 6
    order = np.random.default_rng(0).permutation(len(rows))
    assert np.array_equal(own.predict(rows[order]), found[order])
    assert np.array_equal(own.predict(rows[:7]), found[:7])
    assert own.fit(rows, truth).model_ == model

    # Any order in memory, type, or file that is only read.
    mapped = np.load(tmp_path / "rows.npy", mmap_mode="r")
    for other in (np.asfortranarray(rows), rows.astype(object), mapped, rows.tolist()):
        assert Stepwise(n_bootstrap=0).fit(other, truth).model_ == model
    bad = rows.copy()
    bad[3, 2] = np.nan
    for call in (lambda: Stepwise().fit(bad, truth), lambda: own.predict(bad)):
        with pytest.raises(ValueError, match="NaN"):
            call()
    with pytest.raises(ValueError, match="1D"):
        own.predict(rows[0])


def test_the_estimators_are_those_of_the_functions(train):
    assert (
        Stepwise().fit(train).model_
        == torquewise.fit(train, library="energy", filter="none", progress=False).model
    )


def test_they_are_estimators_of_scikit_learn():
    from sklearn.base import BaseEstimator, RegressorMixin

    for kind in (Stepwise, Chain, OneShot):
        assert issubclass(kind, BaseEstimator) and issubclass(kind, RegressorMixin)


def test_columns_of_a_frame_are_known_by_name(train):
    import pandas as pd

    rows, truth = table(train)
    names = [f"{key}{k}" for key in ("q", "dq", "ddq") for k in (1, 2)]
    frame = pd.DataFrame(rows, columns=names)
    mixed = frame[["q1", "dq1", "ddq1", "q2", "dq2", "ddq2"]]

    own = Stepwise(n_bootstrap=0).fit(mixed, truth)

    assert own.model_ == Stepwise(n_bootstrap=0).fit(rows, truth).model_
    assert list(own.feature_names_in_) == list(mixed)
    assert np.array_equal(own.predict(mixed), own.model_.torque(*np.split(rows, 3, axis=1)))
    assert np.array_equal(own.predict(mixed.to_numpy()), own.predict(mixed))
    with pytest.raises(ValueError, match="feature names should match"):
        own.predict(frame)
    with pytest.raises(ValueError, match="expected q1 … qn"):
        Stepwise().fit(frame.rename(columns={"ddq2": "ddq3"}), truth)


def test_weights_of_rows_are_refused_with_the_reason(train):
    rows, truth = table(train)

    with pytest.raises(TypeError, match="fit takes no sample_weight: all rows count"):
        Stepwise().fit(rows, truth, sample_weight=np.ones(len(rows)))


def test_without_scikit_learn_they_have_its_conventions(train, tmp_path):
    import subprocess
    import sys

    torquewise.write_log(tmp_path / "log.csv", train)
    program = """
import sys
sys.modules["sklearn"] = None
import torquewise
own = torquewise.Stepwise(n_bootstrap=0)
assert own.get_params()["n_bootstrap"] == 0 and own.set_params(seed=1) is own
print(own, own.fit(sys.argv[1]).score(torquewise.read_log(sys.argv[1]).trajectories()) > 0.99)
try:
    own.set_params(sed=1)
except ValueError as error:
    print(error)
"""
    command = [sys.executable, "-c", program, str(tmp_path / "log.csv")]
    done = subprocess.run(command, capture_output=True, text=True)

    assert done.stdout.startswith(
        "Stepwise(n_bootstrap=0, seed=1) True\nInvalid parameter 'sed'"
    ), done.stdout + done.stderr


def test_rows_out_of_their_order_are_told(train):
    rows = np.concatenate([train[key] for key in ("q", "dq", "ddq")], axis=1)
    order = np.random.default_rng(0).permutation(len(rows))

    with pytest.warns(UserWarning, match="order of time"):
        Stepwise().fit(rows[order], train["tau"][order])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Stepwise().fit(rows, train["tau"])
