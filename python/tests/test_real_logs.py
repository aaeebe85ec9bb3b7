"""Logs of real arms: nothing in them is called a mistake, and what was planted in them is found."""

import numpy as np
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
    assert fit.verdict in ("good", "usable"), fit.because
