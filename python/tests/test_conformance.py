"""Small logs and the model each must give: by the package, by the command line, and as exported C."""

import ctypes
import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import torquewise

FOLDER = Path(__file__).parents[2] / "tests/conformance"
CASES = sorted(FOLDER.glob("*.json"))


def percent(found, truth):
    return 100 * np.sqrt(((found - truth) ** 2).mean(axis=0) / (truth**2).mean(axis=0))


@pytest.fixture(params=CASES, ids=lambda path: path.stem, scope="module")
def case(request):
    own = json.loads(request.param.read_text())
    log = FOLDER / own["log"]
    own["path"], own["model"] = log, torquewise.fit(log, progress=False, **own["fit"]).model
    own["states"] = [np.array(own[key]) for key in ("q", "dq", "ddq")]
    return own


def test_the_set_is_whole():
    assert [own.stem for own in CASES] == ["chain", "energy", "one_shot", "product"]


def test_the_model_is_the_arm(case):
    model, truth = case["model"], np.array(case["tau"])

    assert (percent(model.torque(*case["states"]), truth) < case["within_percent"]).all()
    assert model.complexity == case.get("terms", model.complexity)


def test_the_command_line_gives_the_same(case, tmp_path):
    flags = [
        word
        for name, value in case["fit"].items()
        for word in (f"--{name.replace('n_', '').replace('_', '-')}", str(value))
    ]
    command = [sys.executable, "-m", "torquewise", "fit", case["path"], "-o", "model.json", *flags]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)

    assert done.returncode in (0, 3), done.stderr
    assert torquewise.Model.load(tmp_path / "model.json") == case["model"]


def test_exported_c_gives_the_same(case, tmp_path):
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler")
    case["model"].export(tmp_path / "arm.c", force=True)
    sources = sorted(tmp_path.glob("*.c"))
    library = tmp_path / "arm.so"
    subprocess.run(
        [compiler, "-O1", "-shared", "-fPIC", "-o", library, *sources, "-lm"], check=True
    )
    call = ctypes.CDLL(str(library)).arm_torque
    rows = np.stack(case["states"], axis=1)
    found = np.zeros((len(rows), rows.shape[2]))
    pointer = np.ctypeslib.ndpointer(dtype=np.float64, flags="C")
    call.argtypes, call.restype = [pointer] * 4, None
    for state, tau in zip(rows, found):
        call(*(np.ascontiguousarray(own) for own in state), tau)

    assert np.allclose(found, case["model"].torque(*case["states"]), rtol=1e-9, atol=1e-9)
