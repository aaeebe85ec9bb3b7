"""The Python environment of the peers, and how each is run in a process of its own."""

import json
import re
import subprocess
import venv
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent


def environment(folder, *more):
    """Python of a virtual environment with what is pinned, and more that pip is told of."""
    python = folder / "venv" / "bin" / "python"
    if not python.exists():
        venv.create(folder / "venv", with_pip=True)
    wanted = ["-q", "-r", str(HERE / "requirements.txt"), *map(str, more)]
    subprocess.run([python, "-m", "pip", "install", *wanted], check=True)
    return python


def run_apart(python, script, arguments, seconds):
    """The JSON object that a script prints last, or why there is none; stopped after some time."""
    command = [python, HERE / script, *arguments]
    try:
        done = subprocess.run(
            [str(own) for own in command], capture_output=True, text=True, timeout=seconds
        )
    except subprocess.TimeoutExpired:
        return {"failed": f"took more than {seconds} s"}
    lines = done.stdout.strip().splitlines()
    return json.loads(lines[-1]) if done.returncode == 0 and lines else {"failed": why(done.stderr)}


def why(told):
    """The message of an exception, or the last line."""
    lines = told.strip().splitlines() or ["failed"]
    start = [k for k, line in enumerate(lines) if re.match(r"[\w.]+Error: ", line)]
    return " ".join(lines[start[-1] if start else -1 :])[:300]
