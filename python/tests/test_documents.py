"""Guides and notebooks run as they stand, and the pages are built from them."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import torquewise

ROOT = Path(__file__).parents[2]
EXAMPLES = [str(own) for own in sorted((ROOT / "python/examples").glob("*.py"))]
NOTEBOOKS = sorted((ROOT / "python/examples").glob("*.ipynb"))


def blocks(name):
    return re.findall(r"^```python\n(.*?)^```", (ROOT / name).read_text(), re.S | re.M)


@pytest.mark.parametrize("name", ["docs/python.md", "README.md", "python/README.md"])
def test_the_programs_of_a_guide_run(name, tmp_path, monkeypatch):
    for module in ("jax", "sklearn"):
        pytest.importorskip(module)
    monkeypatch.chdir(tmp_path)
    for log, seed, motion in (("train.csv", 1, "moves"), ("test.csv", 2, "sines")):
        torquewise.simulate("planar-2", seconds=60, rate=100, seed=seed, motion=motion, path=log)
    found, space = blocks(name), {}

    assert found
    for program in found:
        exec(compile(program, name, "exec"), space)


def is_close(shown, found):
    """Whether two words are the same, or numbers that agree to 1 %."""
    try:
        return float(found) == pytest.approx(float(shown), rel=0.01)
    except ValueError:
        return found == shown


def run_command(words, folder):
    line = [sys.executable, "-m", "torquewise", *words.split()]
    done = subprocess.run(line, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, words + done.stderr
    return done.stdout.split()


def test_the_commands_for_a_real_log_run_and_print_what_the_guide_shows(shared, tmp_path):
    name = "ur10_exciting_trajectory.db3"
    (tmp_path / name).symlink_to((shared / "data/ur10_panda_unisa" / name).resolve())
    section = (ROOT / "README.md").read_text().split("## A real log")[1]
    commands = re.findall(r"^torquewise ([^#\n]*)", section, re.M)
    guide = (ROOT / "docs/your-robot.md").read_text()
    expected = re.search(r"^```text\n(\d+ rows, .*?)^```", guide, re.S | re.M)[1].split()

    printed = [run_command(command, tmp_path) for command in commands]

    assert [command.split()[0] for command in commands] == ["inspect", "fit", "export"]
    assert all(map(is_close, expected, printed[1])) and len(printed[1]) > len(expected)
    assert (tmp_path / "ur10.urdf").exists()


def test_the_tables_of_the_guide_on_control_are_what_its_commands_print(tmp_path):
    guide = (ROOT / "docs/control.md").read_text()
    lines = "".join(re.findall(r"^```console\n(.*?)^```", guide, re.S | re.M))
    for line in re.split(r"^\$ ", lines, flags=re.M)[1:]:
        command, output = line.split("\n", 1)
        program, words = command.split(" ", 1)
        if program == "cat":
            (tmp_path / words).write_text(output)
            continue
        printed = run_command(words, tmp_path)
        if "…" not in output:
            differing = [pair for pair in zip(output.split(), printed) if not is_close(*pair)]
            assert len(output.split()) == len(printed) and not differing, command


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(path, tmp_path):
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    for module in {"2_bag_to_urdf": ["rosbags"], "3_for_pysindy_users": ["pysindy", "sklearn"]}.get(
        path.stem, []
    ):
        pytest.importorskip(module)
    notebook = nbformat.read(path, as_version=4)

    nbclient.NotebookClient(
        notebook, timeout=600, resources={"metadata": {"path": tmp_path}}
    ).execute()

    kinds = {
        own.output_type
        for cell in notebook.cells
        if cell.cell_type == "code"
        for own in cell.outputs
    }
    assert "error" not in kinds and len(NOTEBOOKS) == 4
    kept = nbformat.read(path, as_version=4)
    assert not any(cell.get("outputs") for cell in kept.cells), "keep notebooks without outputs"


@pytest.mark.parametrize(
    "command",
    [
        ["ruff", "check", "--config", "python/pyproject.toml", "python", "examples"],
        ["ruff", "format", "--check", "--config", "python/pyproject.toml", "python", "examples"],
    ],
    ids=" ".join,
)
def test_the_package_is_clean(command, tmp_path):
    pytest.importorskip(command[0])
    environment = {
        **os.environ,
        "RUFF_CACHE_DIR": str(tmp_path),
    }
    done = subprocess.run(
        [sys.executable, "-m", *command], cwd=ROOT, capture_output=True, text=True, env=environment
    )

    assert done.returncode == 0, done.stdout + done.stderr


def test_types_are_right_and_an_option_that_is_none_is_wrong(tmp_path):
    pytest.importorskip("mypy")
    program = tmp_path / "program.py"
    program.write_text(
        "import torquewise\n"
        'fit = torquewise.fit("log.csv", library="chain", seed=1, filter=8.0)\n'
        'torquewise.fit("log.csv", librari="chain")\n'
        'torquewise.fit("log.csv", library="chian")\n'
        'torquewise.Summary.of("log.csv", sed=1)\n'
        'fit.evaluate("log.csv", filte=8.0)\n'
        'fit.model.export("arm.c", precision="single")\n'
        'torquewise.excite("planar-2", max_speed=1.0)\n'
        'torquewise.OneShot(select="best")\n'
    )
    environment = {
        **os.environ,
        "MYPY_CACHE_DIR": str(tmp_path / "cache"),
        "MYPYPATH": str(ROOT / "python/package"),
    }
    checked = ["python/package/torquewise", *EXAMPLES, str(program)]
    command = [sys.executable, "-m", "mypy", "--config-file", "python/pyproject.toml", *checked]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, env=environment)

    wrong = re.findall(r"^(.*\.py):(\d+): error", done.stdout, re.M)
    assert [line for _, line in wrong] == [*"3456789"], done.stdout + done.stderr
    assert {Path(file).name for file, _ in wrong} == {"program.py"}


def test_the_pages_are_built(tmp_path):
    pytest.importorskip("mkdocs")
    command = [
        sys.executable,
        "-m",
        "mkdocs",
        "build",
        "--strict",
        "--quiet",
        "--site-dir",
        tmp_path / "site",
    ]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)

    assert done.returncode == 0, done.stderr
    assert (tmp_path / "site/python/index.html").exists()


def test_the_stub_names_what_the_engine_has():
    import ast

    tree = ast.parse((Path(torquewise.__file__).parent / "_core.pyi").read_text())
    core = sys.modules["torquewise._core"]
    stub = {own.name: own for own in tree.body if isinstance(own, (ast.ClassDef, ast.FunctionDef))}
    missing = {name for name in dir(core) if not name.startswith("_")} ^ {*stub}

    assert not missing
    for name, own in stub.items():
        if isinstance(own, ast.ClassDef) and not issubclass(getattr(core, name), BaseException):
            methods = {inner.name for inner in own.body if isinstance(inner, ast.FunctionDef)} - {
                "__new__"
            }
            real = {key for key in vars(getattr(core, name)) if not key.startswith("__")}
            assert methods == real, name


def test_the_engine_keeps_to_the_stable_interface():
    pytest.importorskip("abi3audit")
    engine = sys.modules["torquewise._core"].__file__
    done = subprocess.run(
        [sys.executable, "-m", "abi3audit", "--strict", "--assume-minimum-abi3", "3.10", engine],
        capture_output=True,
        text=True,
    )

    assert done.returncode == 0, done.stdout + done.stderr


def test_a_cold_import_is_short():
    """Beside an import of NumPy, which it needs: what comes on top."""
    environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": ""}

    def microseconds(module):
        found = []
        for _ in range(5):
            command = [sys.executable, "-X", "importtime", "-c", f"import numpy, {module}"]
            done = subprocess.run(
                command, capture_output=True, text=True, check=True, env=environment
            )
            lines = [
                line.split("|")
                for line in done.stderr.splitlines()
                if line.startswith("import time:")
            ]
            found.append(sum(int(line[1]) for line in lines[1:] if line[2].strip() == module))
        return min(found)

    assert 0 < microseconds("torquewise") < 100_000
