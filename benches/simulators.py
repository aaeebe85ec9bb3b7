"""Exported robots in Pinocchio and MuJoCo beside the models that they were written from.

    python3 benches/simulators.py [--folder FOLDER] [--binary BINARY]

Makes a virtual environment in FOLDER (default target/simulators), learns chains from simulated logs
with viscous friction and prints, for each arm, as Markdown:

- *Pinocchio*: the largest difference of the torque of the URDF between Pinocchio and ours, over the
  spread of the torque;
- *MuJoCo*: the same of the MJCF between MuJoCo's inverse dynamics and the model, rotors and friction
  counted in;
- *rollout*: how far apart the two are after 0.5 s, from the same state under the same torque, MuJoCo by
  its Runge-Kutta method with steps of 0.05 ms, ours by `evaluate --rollout` on rows at 2 kHz;
- *dry*: the same of an arm with dry friction, which MuJoCo makes a soft constraint.
"""

import argparse
import csv
import json
import subprocess
import sys
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
ARMS = {
    "puma560-3": "rrr", "generic-6": "rrrrrr", "generic-7": "rrrrrrr",
    "gantry-3": "ppp", "scara-4": "rrpr", "surgical-6": "rrprrr",
}  # fmt: skip
PACKAGES = ["numpy", "mujoco==4.0.0", "pin==4.1.0"]
RATE, SUBSTEPS, WINDOWS, WINDOW = 2_000, 10, 10, 0.5


def rerun_inside(folder):
    """Runs this script by the Python of its own environment, which it makes first."""
    python = folder / "venv" / "bin" / "python"
    if Path(sys.prefix) == folder / "venv":
        return
    if not python.exists():
        venv.create(folder / "venv", with_pip=True)
    subprocess.run([python, "-m", "pip", "install", "-q", *PACKAGES], check=True)
    sys.exit(subprocess.run([python, __file__, *sys.argv[1:]], check=False).returncode)


class Arm:
    """An arm, learned from a log with a friction of its own."""

    def __init__(self, run, folder, name, coulomb):
        self.run, self.kinds = run, ARMS[name]
        self.stem = folder / f"{name}{'-dry' if coulomb else ''}"
        bare, log, friction = self.file("bare.csv"), self.file("csv"), self.file("toml")
        run("simulate", name, "-o", bare, "--seconds", 1, "--rate", 100)
        lines = [f"{joint} = {{ coulomb = {coulomb}, viscous = 0.4 }}" for joint in read(bare)[0]]
        friction.write_text("\n".join(lines))
        run("simulate", name, "-o", log, "--seconds", 40, "--rate", 250, "--friction", friction)
        run("fit", log, "-o", self.file("json"), "--library", "chain", "--kinds", self.kinds)
        for to, ending in ("urdf", "urdf"), ("mjcf", "xml"):
            run("export", self.file("json"), "--to", to, "-o", self.file(ending))

    def file(self, ending):
        return Path(f"{self.stem}.{ending}")

    def states(self, source, rate, seconds):
        """A motion of the arm: names of its joints, time, and q, dq, ddq and torque."""
        log = self.file("states.csv")
        motion = ["--motion", "sines", "--rate", rate, "--seconds", seconds]
        self.run("simulate", source, "-o", log, *motion)
        return read(log)


def read(path):
    """Names, then the columns of q, dq, ddq and tau, each m by n, and time."""
    import numpy as np

    with path.open() as file:
        lines = file.read().splitlines()
    header = [line for line in lines if line.startswith("#")]
    rows = [line for line in lines if not line.startswith("#")]
    values = np.array([row.split(",") for row in rows[1:]], dtype=float)
    names = rows[0].split(",")
    n = sum(name.startswith("tau") for name in names)
    joints = header[0].removeprefix("# joints:").strip().split(",") if header else None
    parts = [values[:, 1 + k * n : 1 + (k + 1) * n] for k in range(4)]
    return joints or [f"joint{k + 1}" for k in range(n)], values[:, 0], *parts


def apart(a, b):
    """The largest difference over the spread of its joint."""
    return float((abs(a - b).max(axis=0) / b.std(axis=0)).max())


def pinocchio(arm):
    import numpy as np
    import pinocchio as pin

    _, _, q, dq, ddq, tau = arm.states(arm.file("urdf"), 250, 4)
    model = pin.buildModelFromUrdf(str(arm.file("urdf")))
    data = model.createData()
    return apart(np.array([pin.rnea(model, data, *row) for row in zip(q, dq, ddq)]), tau)


def mujoco_inverse(arm):
    import mujoco
    import numpy as np

    _, _, q, dq, ddq, tau = arm.states(arm.file("json"), 250, 4)
    model = mujoco.MjModel.from_xml_path(str(arm.file("xml")))
    data = mujoco.MjData(model)

    def torque(q, dq, ddq):
        data.qpos[:], data.qvel[:], data.qacc[:] = q, dq, ddq
        mujoco.mj_inverse(model, data)
        return data.qfrc_inverse.copy()

    return apart(np.array([torque(*row) for row in zip(q, dq, ddq)]), tau)


def rollout(arm):
    """Lets MuJoCo move the arm in windows of a log, and asks how far ours drifts from that."""
    import mujoco

    steps, apart = int(WINDOW * RATE), 1 + WINDOW
    names, t, q, dq, _, tau = arm.states(arm.file("json"), RATE, WINDOWS * apart)
    model = mujoco.MjModel.from_xml_path(str(arm.file("xml")))
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    model.opt.timestep = 1 / RATE / SUBSTEPS
    files = []
    for window in range(WINDOWS):
        first, data = int(window * apart * RATE), mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = q[first], dq[first]
        files.append(arm.file(f"window{window}.csv"))
        with files[-1].open("w", newline="") as file:
            out = csv.writer(file)
            file.write(f"# joints: {','.join(names)}\n")
            joints = range(1, model.nq + 1)
            out.writerow(["t", *(f"{x}{k}" for x in ("q", "dq", "tau") for k in joints)])
            for row in range(first, first + steps + 1):
                out.writerow([t[row], *data.qpos, *data.qvel, *tau[row]])
                for step in range(SUBSTEPS):
                    part = (step + 0.5) / SUBSTEPS
                    after = tau[min(row + 1, len(tau) - 1)]
                    data.ctrl[:] = (1 - part) * tau[row] + part * after
                    mujoco.mj_step(model, data)
    found = arm.run("evaluate", arm.file("json"), *files, "--rollout", WINDOW, "--json")
    drift = json.loads(found)["rollout"][0]
    assert drift["ran_away"] == 0, drift
    return max(drift["rms_drift_rad"])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--folder", type=Path, default=ROOT / "target" / "simulators")
    parser.add_argument("--binary", type=Path, default=ROOT / "target" / "release" / "torquewise")
    options = parser.parse_args()
    folder = options.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    rerun_inside(folder)

    def run(*arguments):
        command = [options.binary, *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode not in (0, 3):
            sys.exit(f"{' '.join(map(str, command))}\n{done.stderr}")
        return done.stdout

    print("| arm | Pinocchio | MuJoCo | rollout [rad, m] | dry [rad, m] |")
    print("|---|---|---|---|---|")
    for name in ARMS:
        arm, dry = Arm(run, folder, name, 0.0), Arm(run, folder, name, 0.1)
        found = pinocchio(arm), mujoco_inverse(arm), rollout(arm), rollout(dry)
        print(f"| {name} | {' | '.join(f'{x:.1e}' for x in found)} |", flush=True)


if __name__ == "__main__":
    main()
