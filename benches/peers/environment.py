"""The Python environment of the peers, and how each is run in a process of its own."""

import json
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
    if done.returncode != 0 or not done.stdout.strip():
        return {"failed": done.stderr.strip().splitlines()[-1][:300] if done.stderr.strip() else "failed"}
    return json.loads(done.stdout.strip().splitlines()[-1])
