"""Nanoseconds per call: exported C, the model interpreted, Pinocchio's RNEA, in one run.

    python3 benches/per_call.py MODEL[=URDF] ...

A model is timed beside the URDF behind its `=`, else beside as many revolute joints. The program is
`torquewise` on the path or what TORQUEWISE names; the model is interpreted where its Python package can
be imported. For Pinocchio, PINOCCHIO_FLAGS holds what the C++ compiler needs to find it, with `P` the
folder `site-packages/cmeel.prefix` of `pip install pin cmeel-eigen cmeel-urdfdom-headers`:
`-I$P/include -I$P/include/urdfdom -I$P/include/eigen3 -I$P/include/urdfdom_headers -L$P/lib
-lpinocchio_parsers -lpinocchio_default -Wl,-rpath,$P/lib`. Processor time, medians of 201 rounds, the
least in brackets.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent / "per_call"
ROUNDS, ROWS = 201, 1000


def run(*command, folder=None):
    words = [str(word) for word in command]
    return subprocess.run(words, cwd=folder, check=True, stdout=subprocess.PIPE, text=True).stdout


def shown(name, median, least):
    print(f"  {name:12}{float(median):8.0f} ns  ({float(least):.0f})")


def interpreted(file, joints):
    try:
        import numpy as np

        import torquewise
    except ImportError:
        return
    model = torquewise.Model.load(file)
    states = np.random.default_rng(0).uniform(-1.0, 1.0, (3, ROWS, joints))
    times = []
    for _ in range(ROUNDS):
        start = time.process_time_ns()
        model.torque(*states)
        times.append((time.process_time_ns() - start) / ROWS)
    shown("interpreted", sorted(times)[ROUNDS // 2], min(times))


def main(models):
    program = os.environ.get("TORQUEWISE", "torquewise")
    flags = os.environ.get("PINOCCHIO_FLAGS", "").split()
    with tempfile.TemporaryDirectory() as folder:
        for source in ("timing.c", "pinocchio.cpp"):
            shutil.copy(HERE / source, folder)
        if flags:
            optimised = ["c++", "-std=c++17", "-O3", "-DNDEBUG", "-w", "pinocchio.cpp"]
            run(*optimised, *flags, "-o", "pinocchio", folder=folder)
        for word in models:
            file, _, urdf = word.partition("=")
            joints = len(json.loads(Path(file).read_text())["joints"])
            print(f"\n{file}: {joints} joints")
            print(
                run(program, "export", file, "--to", "c", "--name", "arm", "-o", f"{folder}/arm.c")
            )
            run("cc", "-std=c99", "-O2", "timing.c", "arm.c", "-o", "timing", "-lm", folder=folder)
            for line in run("./timing", folder=folder).splitlines():
                shown(*line.split())
            interpreted(file, joints)
            if flags:
                _, *times = run(
                    "./pinocchio", Path(urdf).resolve() if urdf else joints, folder=folder
                ).split()
                shown("RNEA", *times)


if __name__ == "__main__":
    main(sys.argv[1:] or sys.exit(__doc__))
