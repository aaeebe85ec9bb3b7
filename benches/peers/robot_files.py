"""Friction that a robot file can hold: drift in MuJoCo of models fitted with all laws and with these.

    python3 benches/peers/robot_files.py [--folder FOLDER] [--wheel WHEEL]

prints, for each public log, as Markdown: drift after half a second over that of an arm that keeps its
velocity, geometric mean of the joints, windows of the training log from their measured state under the
measured torque; of the model itself, of its MJCF in MuJoCo, and of the MJCF of `--friction linear`.
"""

import argparse
import os
import subprocess
import sys
from pathlib import Path

from environment import ROOT, environment

sys.path.insert(0, str(ROOT / "benches"))


def mean(ratios):
    """Geometric, of the joints; some arms run away."""
    import numpy as np

    mean = np.exp(np.mean(np.log([np.nan if x is None else x for x in ratios])))
    return f"{mean:.2f}" if mean < 100 else "away"


def in_mujoco(model, trajectories):
    import mujoco
    from arm_mujoco import simulated
    from forward import drift

    arm = mujoco.MjModel.from_xml_string(model.to_mjcf())
    arm.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    arm.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    arm.actuator_ctrllimited[:] = 0
    return mean(drift(trajectories, simulated(arm)))


def row(shared, profile, arm):
    from public_logs import band

    import torquewise

    profile = ROOT / "profiles" / f"{profile}.toml"
    log = torquewise.read_log(shared / "data" / arm.log, profile=profile, repair=True)
    derived, joints = log.inspect().missing, {"joints": log.joints}
    measured = lambda own: {key: own[key] for key in own if key not in derived}
    log = [measured(own) | joints for own in log.trajectories()]
    options = {"library": "chain", "counterbalance": list(arm.balanced), "progress": False}
    whole = torquewise.fit(log, **options).model
    plain = torquewise.fit(log, friction="linear", **options, **band(whole)).model
    own = whole.rollout(log, horizons=[0.5], **band(whole))
    rows = torquewise.read_log(log, **band(whole)).trajectories(conditioned=True)
    drift = float("inf") if own.ran_away[0] else mean(own.drift[0] / own.hold[0])
    return drift, in_mujoco(whole, rows), in_mujoco(plain, rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--folder", type=Path, default=ROOT / "target" / "peers")
    parser.add_argument("--wheel", type=Path, help="wheel of the Python package; built without")
    parser.add_argument("--shared", type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if not given.shared:
        shared = Path(os.environ.get("TORQUEWISE_SHARED", ROOT.parent / "shared")).resolve()
        python = environment(given.folder.resolve(), given.wheel or ROOT / "python")
        sys.exit(subprocess.run([python, __file__, "--shared", shared], check=False).returncode)
    from public_logs import ARMS

    print("| arm | all laws, ours | all laws, MuJoCo | linear, MuJoCo |\n|---|---|---|---|")
    for (name, profile), arm in ARMS.items():
        print(f"| {name} |", " | ".join(row(given.shared, profile, arm)), "|", flush=True)


if __name__ == "__main__":
    main()
