import os
from pathlib import Path

import pytest

import torquewise

os.environ.setdefault("MPLBACKEND", "agg")


@pytest.fixture(scope="session")
def train():
    return torquewise.simulate("planar-2", seconds=60, rate=100, seed=1)


@pytest.fixture(scope="session")
def test():
    return torquewise.simulate("planar-2", motion="sines", seconds=10, rate=100, seed=2)


@pytest.fixture(scope="session")
def fit(train):
    return torquewise.fit(train, progress=False)


@pytest.fixture(scope="session")
def model(fit):
    return fit.model


@pytest.fixture(scope="session")
def chain():
    """A model of a chain with friction that remembers nothing, from clean rows."""
    log = torquewise.simulate("puma560-3", seconds=60, rate=100, seed=1)
    return torquewise.fit(log, library="chain", friction="linear", progress=False).model


@pytest.fixture(scope="session")
def shared():
    """Data that is not part of the repository; tests that need it are skipped without."""
    root = Path(__file__).parents[2]
    folder = Path(os.environ.get("TORQUEWISE_SHARED", root / "../shared"))
    if not folder.is_dir():
        message = f"no {folder}: set TORQUEWISE_SHARED"
        if os.environ.get("TORQUEWISE_SHARED_REQUIRED"):
            pytest.fail(message)
        pytest.skip(message)
    return folder
