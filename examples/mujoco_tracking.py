#!/usr/bin/env python3
"""The whole way on a plant that torquewise knows nothing of: MuJoCo.

Builds an arm from a URDF, adds rotors, dry and viscous friction, and moves it by velocity
controllers along motions that `torquewise excite` plans. From the recorded positions and torques
`torquewise fit` learns a model, `torquewise export` writes it as C, and the compiled C drives the
arm along a periodic motion: PID, controller 1 (gravity and friction) and controller 2 (all), with
the same gains.

    pip install mujoco numpy
    cargo build --release
    python examples/mujoco_tracking.py --torquewise target/release/torquewise

Needs a C compiler called cc. Everything is seeded: the same numbers on every run.
"""

import argparse
import ctypes
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import mujoco
import numpy as np

RATE = 1000  # of the controllers [Hz]
SUBSTEPS = 4  # of MuJoCo to a tick
ENCODER = 2 * np.pi / 2**20  # step [rad]
CUTOFF = 100.0  # of the measured velocity [Hz]
VELOCITY_BANDWIDTH = 60.0  # of the drives while recording [rad/s]
BANDWIDTH = 15.0  # of the tracking feedback [rad/s]
PERIOD = 8.0  # of the motion that is tracked [s]
REVERSAL = 0.002  # of friction, as sharp as a desired velocity without noise allows [rad/s]
# Rotor inertia [kg m^2], dry friction [N m], viscous friction [N m s/rad]: one joint each, repeated.
ARMATURE = [0.5, 0.6, 0.2]
DRY = [4.0, 5.0, 2.0]
VISCOUS = [3.0, 4.0, 1.5]


def run(*words):
    """What a program says, or the end of this one."""
    words = [str(word) for word in words]
    done = subprocess.run(words, capture_output=True, text=True)
    # torquewise exits with 3 where it is done but has warnings.
    if done.returncode not in (0, 3):
        sys.exit(f"{' '.join(words)}\n{done.stderr}")
    return done.stdout


class Arm:
    """A MuJoCo arm with encoders and drives, one call per tick."""

    def __init__(self, urdf):
        self.model = mujoco.MjModel.from_xml_path(str(urdf))
        n = self.model.nv
        if self.model.nq != n or self.model.njnt != n:
            sys.exit(f"{urdf}: every joint must be revolute")
        self.model.opt.timestep = 1 / RATE / SUBSTEPS
        self.model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        # Dry friction is a constraint: these make it stiff and well solved.
        self.model.opt.iterations = 200
        self.model.opt.tolerance = 1e-12
        self.model.dof_solref[:] = [0.002, 1.0]
        self.model.dof_armature[:] = np.resize(ARMATURE, n)
        self.model.dof_frictionloss[:] = np.resize(DRY, n)
        self.model.dof_damping[:] = np.resize(VISCOUS, n)
        self.data = mujoco.MjData(self.model)
        self.n = n
        self.names = [self.model.joint(i).name for i in range(n)]

    def start(self, q, dq):
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:], self.data.qvel[:] = q, dq
        mujoco.mj_forward(self.model, self.data)

    def measured(self):
        return np.round(self.data.qpos / ENCODER) * ENCODER

    def tick(self, tau):
        self.data.qfrc_applied[:] = tau
        mujoco.mj_step(self.model, self.data, SUBSTEPS)

    def inertia(self):
        """Diagonal of the true mass matrix where the arm is, rotors among it."""
        column = np.zeros(self.n)
        diagonal = np.zeros(self.n)
        for joint, unit in enumerate(np.eye(self.n)):
            mujoco.mj_mulM(self.model, self.data, column, unit)
            diagonal[joint] = column[joint]
        return diagonal


class Slope:
    """Differences of a signal through a first-order low-pass."""

    def __init__(self, first):
        self.share = 1 - np.exp(-2 * np.pi * CUTOFF / RATE)
        self.last, self.slope = None, np.array(first, dtype=float)

    def __call__(self, x):
        if self.last is not None:
            self.slope = self.slope + self.share * ((x - self.last) * RATE - self.slope)
        self.last = x
        return self.slope


def record(arm, plan, log):
    """Follows the velocities of a plan and writes positions and torques as a log."""
    # The first line names the joints, the second the columns.
    table = np.genfromtxt(plan, delimiter=",", skip_header=1, names=True)
    column = lambda signal: np.stack([table[f"{signal}{i + 1}"] for i in range(arm.n)], 1)
    q_ref, dq_ref = column("q"), column("dq")
    arm.start(q_ref[0], dq_ref[0])
    inertia, integral, slope = arm.inertia(), np.zeros(arm.n), Slope(dq_ref[0])
    q, tau, before = np.zeros_like(q_ref), np.zeros_like(q_ref), None
    w = VELOCITY_BANDWIDTH
    for row, wanted in enumerate(dq_ref):
        q[row] = arm.measured()
        missing = wanted - slope(q[row])
        integral += missing / RATE
        command = inertia * (2 * w * missing + w * w * integral)
        # A torque is held from tick to tick: about a tick it is the mean of both.
        tau[row] = command if before is None else (before + command) / 2
        before = command
        arm.tick(command)
    header = ["# joints: " + ",".join(arm.names)]
    header.append(",".join(["t"] + [f"{s}{i + 1}" for s in ("q", "tau") for i in range(arm.n)]))
    rows = np.column_stack([np.arange(len(q)) / RATE, q, tau])
    np.savetxt(log, rows, delimiter=",", header="\n".join(header), comments="")


class Exported:
    """A model that was exported as C, compiled and loaded."""

    def __init__(self, source, name, n):
        library = source.with_suffix(".so")
        run("cc", "-O2", "-std=c99", "-shared", "-fPIC", source, "-o", library, "-lm")
        self.library, self.name, self.n = ctypes.CDLL(str(library)), name, n

    def __call__(self, quantity, *signals, size=None):
        vector = ctypes.c_double * self.n
        result = (ctypes.c_double * (size or self.n))()
        signals = [vector(*signal) for signal in signals]
        getattr(self.library, f"{self.name}_{quantity}")(*signals, result)
        return np.array(result)


def periodic(arm, seed):
    """q, dq and ddq of two periods at each tick, at rest after each period."""
    random, w = np.random.default_rng(seed), 2 * np.pi / PERIOD
    t = np.arange(2 * int(PERIOD * RATE) + 1) / RATE
    ranges = arm.model.jnt_range
    states = np.zeros((3, len(t), arm.n))
    for joint in range(arm.n):
        middle, half = ranges[joint].mean(), 0.8 * np.ptp(ranges[joint]) / 2
        shape = np.zeros((3, len(t)))
        for k in (1, 2):
            size = random.choice([-1, 1]) * random.uniform(0.3, 1) / k**2
            slow, fast = k * w, (k + 1) * w
            shape[0] += size * (np.sin(slow * t) - k / (k + 1) * np.sin(fast * t))
            shape[1] += size * slow * (np.cos(slow * t) - np.cos(fast * t))
            shape[2] += size * slow * (fast * np.sin(fast * t) - slow * np.sin(slow * t))
        # At most 1 rad/s and 2 rad/s^2.
        shape *= min(bound / np.abs(x).max() for bound, x in zip((half, 1.0, 2.0), shape))
        states[:, :, joint] = shape
        states[0, :, joint] += middle
    return states


def track(arm, states, gains, forward):
    """RMS of the position error of each joint in the second period [rad]."""
    q_ref, dq_ref, ddq_ref = states
    arm.start(q_ref[0], dq_ref[0])
    kp, ki, kd = gains
    integral, slope = np.zeros(arm.n), Slope(np.zeros(arm.n))
    errors = np.zeros_like(q_ref)
    for row in range(len(q_ref)):
        error = q_ref[row] - arm.measured()
        integral += error / RATE
        errors[row] = q_ref[row] - arm.data.qpos
        feedback = kp * error + ki * integral + kd * slope(error)
        arm.tick(feedback + forward(q_ref[row], dq_ref[row], ddq_ref[row]))
    return np.sqrt((errors[len(errors) // 2 :] ** 2).mean(0))


def learn(arguments, arm, folder):
    """Plans, records, fits and exports; returns the compiled model."""
    seconds = arguments.seconds
    plan = ["--standstill", seconds[0], "--uniform", seconds[1], "--variable", seconds[2]]
    limits = ["--max-velocity", 1.5, "--max-acceleration", 4, "--speed-scale", 1]
    program = arguments.torquewise
    excite = [program, "excite", arguments.urdf, "-o", folder / "plan", "--slow-sweeps"]
    run(*excite, "--dwell", 1, "--rate", RATE, *plan, *limits)
    logs = []
    for name in ("standstill", "uniform", "variable"):
        logs.append(folder / f"{name}.csv")
        record(arm, folder / "plan" / f"{name}.csv", logs[-1])
    model = folder / "model.json"
    options = ["--friction", arguments.friction]
    print(run(program, "fit", *logs, "-o", model, *options), file=sys.stderr)
    source = folder / "arm.c"
    sharp = ["--reversal", REVERSAL]
    run(program, "export", model, "--to", "c", "--name", "arm", *sharp, "-o", source)
    return Exported(source, "arm", arm.n)


def main():
    here = Path(__file__).parent
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--urdf", type=Path, default=here / "three-joint.urdf")
    parser.add_argument("--torquewise", default="torquewise", help="the program")
    parser.add_argument("--friction", default="auto", help="friction that is looked for")
    parser.add_argument("--seconds", type=float, nargs=3, default=[120, 120, 60])
    parser.add_argument("--seed", type=int, default=1, help="of the motion that is tracked")
    parser.add_argument("--keep", type=Path, help="folder for logs, model and code")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        arm = Arm(arguments.urdf)
        model = learn(arguments, arm, folder)
        states = periodic(arm, arguments.seed)
        diagonal = [
            np.diag(model("inertia", q, size=arm.n**2).reshape(arm.n, arm.n))
            for q in states[0][::80]
        ]
        inertia, w = np.mean(diagonal, 0), BANDWIDTH
        gains = 3 * inertia * w**2, inertia * w**3, 3 * inertia * w
        laws = {
            "pid": lambda q, dq, ddq: np.zeros(arm.n),
            "controller1": lambda q, dq, ddq: model("gravity", q) + model("friction", q, dq),
            "controller2": lambda q, dq, ddq: model("torque", q, dq, ddq),
        }
        found = {name: track(arm, states, gains, law).tolist() for name, law in laws.items()}
    print(json.dumps({name: {"rms_error_rad": rms} for name, rms in found.items()}, indent=1))
    for name in ("controller1", "controller2"):
        shares = np.array(found[name]) / np.array(found["pid"])
        print(f"{name} beside pid: {np.round(shares, 4).tolist()}", file=sys.stderr)


if __name__ == "__main__":
    main()
