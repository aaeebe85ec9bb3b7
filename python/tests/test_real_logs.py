"""Logs of real arms: nothing in them is called a mistake, and what was planted in them is found."""

import numpy as np
import pandas as pd
import pytest

import torquewise

ARMS = {
    "ur10": "ur10_panda_unisa/ur10_exciting_trajectory.db3",
    "panda": "ur10_panda_unisa/panda_exciting_trajectory.db3",
    "dfki_double_pendulum": "dfki_double_pendulum/A0_20220812/20220812-061157-PM_measured.csv",
    "staubli_tx40": "staubli_tx40_figaroh/pos_read_data.csv",
}
MISTAKES = (
    "wrong sign",
    "swapped",
    "cut off",
    "is a command",
    "not in one unit",
    "does not follow",
    "gravity does nothing",
)


@pytest.mark.parametrize("arm", ARMS)
def test_no_real_log_is_accused_of_a_mistake(shared, arm):
    fit = torquewise.fit(shared / "data" / ARMS[arm], profile=arm, progress=False)

    said = " ".join([*fit.warnings, *fit.because])
    assert [own for own in MISTAKES if own in said] == []


@pytest.fixture(scope="module")
def pendulum(shared):
    """A real log, its options, and what is left of its held-out torque [%]."""
    path = shared / "data" / ARMS["dfki_double_pendulum"]
    options = {"profile": "dfki_double_pendulum", "progress": False}
    fit = torquewise.fit(path, **options)
    return path, options, fit


@pytest.mark.parametrize(
    ("column", "rows", "value"),
    [("pos1", 5, 1e3), ("vel2", 3, 1e3), ("vel1", 10, 1e3), ("tau1", 30, 2e5)],
)
def test_absurd_values_are_left_out_and_told(pendulum, tmp_path, column, rows, value):
    path, options, clean = pendulum
    table = pd.read_csv(path)
    table.loc[5000 : 4999 + rows, column] = value
    table.to_csv(tmp_path / "absurd.csv", index=False)

    fit = torquewise.fit(tmp_path / "absurd.csv", **options)

    (said,) = [own for own in fit.warnings if "far beyond its neighbours" in own]
    assert f"{rows} rows" in said and f"in row 5001 of {tmp_path / 'absurd.csv'}" in said
    ours, theirs = fit.summary()["held_out_percent"], clean.summary()["held_out_percent"]
    assert ours == pytest.approx(theirs, rel=0.15)


@pytest.mark.parametrize(("sizes", "per_hour"), [([8.0] * 10, 60), (np.linspace(3, 8, 10), 1200)])
def test_pushes_are_found_in_a_real_log_and_other_free_motion_is_quiet(
    sizes, per_hour, pendulum, tmp_path
):
    path, options, _ = pendulum
    table = pd.read_csv(path)
    half, last = len(table) // 2, 3 * len(table) // 4
    pushed = table[last:].reset_index(drop=True)
    parts = {"train": table[:half], "free": table[half:last], "other": pushed}
    for name, part in parts.items():
        part.to_csv(tmp_path / f"{name}.csv", index=False)
    model = torquewise.fit(tmp_path / "train.csv", **options).model

    def contacts(name):
        free = tmp_path / "free.csv"
        return torquewise.contacts(
            model, tmp_path / f"{name}.csv", free=free, false_alarms=per_hour, **options
        )

    quiet = contacts("other")
    begins = np.linspace(2.0, quiet.t[-1] - quiet.t[0] - 2.0, 10) + pushed["time"][0]
    for k, begin in enumerate(begins):
        rows = (pushed["time"] >= begin) & (pushed["time"] < begin + 0.4)
        push = sizes[k] * quiet.external[:, k % 2].std() * np.hanning(rows.sum())
        pushed.loc[rows, f"tau{k % 2 + 1}"] += push if k % 4 < 2 else -push
    pushed.to_csv(tmp_path / "pushed.csv", index=False)
    found = contacts("pushed").contacts

    alarms = max(1.0, 2.0 * per_hour * (quiet.t[-1] - quiet.t[0]) / 3600.0)
    assert len(quiet.contacts) <= alarms and quiet.blind == []
    of_push = [[own for own in found if abs(own["begin"] - begin) < 0.5] for begin in begins]
    assert sum(map(bool, of_push)) >= 9 and len(found) <= 10 + alarms
