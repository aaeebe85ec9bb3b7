#!/usr/bin/env python3
"""The whole way on a plant that torquewise knows nothing of: MuJoCo.

Builds an arm from a URDF, adds rotors, dry and viscous friction, and moves it by velocity
controllers along motions that `torquewise.excite` plans. From the recorded positions and torques
`torquewise.fit` learns a model, which drives the arm along a periodic motion: PID, controller 1
(gravity and friction) and controller 2 (all), with the same gains.

    pip install ./python mujoco
    python examples/mujoco_tracking.py

Everything is seeded: the same numbers on every run.
"""

import argparse
import json
import sys
from pathlib import Path

import mujoco
import numpy as np

import torquewise

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


def record(arm, plan):
    """Follows the velocities of a plan; positions and torques as a log."""
    q_ref, dq_ref = plan["q"], plan["dq"]
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
    return {"t": np.arange(len(q)) / RATE, "q": q, "tau": tau, "joints": arm.names}


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


def learn(arguments, arm):
    """Plans, records and fits."""
    plans = torquewise.excite(
        arguments.urdf,
        seconds=arguments.seconds,
        slow_sweeps=True,
        dwell=1.0,
        rate=float(RATE),
        max_velocity=1.5,
        max_acceleration=4.0,
        speed_scale=1.0,
    )
    fit = torquewise.fit([record(arm, plan) for plan in plans], friction=arguments.friction)
    print(f"{fit.verdict}: {'; '.join(fit.because)}", *fit.warnings, sep="\n", file=sys.stderr)
    if arguments.keep:
        arguments.keep.mkdir(parents=True, exist_ok=True)
        fit.save(arguments.keep / "model.json")
    return fit.model.with_reversal(REVERSAL)


def main():
    here = Path(__file__).parent
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--urdf", type=Path, default=here / "three-joint.urdf")
    parser.add_argument("--friction", default="auto", help="friction that is looked for")
    parser.add_argument("--seconds", type=float, nargs=3, default=[120, 120, 60])
    parser.add_argument("--seed", type=int, default=1, help="of the motion that is tracked")
    parser.add_argument("--keep", type=Path, help="folder for the model")
    arguments = parser.parse_args()
    arm = Arm(arguments.urdf)
    model = learn(arguments, arm)
    states = periodic(arm, arguments.seed)
    inertia = np.mean([np.diag(mass) for mass in model.mass_matrix(states[0][::80])], axis=0)
    w = BANDWIDTH
    gains = 3 * inertia * w**2, inertia * w**3, 3 * inertia * w
    laws = {
        "pid": lambda q, dq, ddq: np.zeros(arm.n),
        "controller1": lambda q, dq, ddq: model.gravity(q) + model.friction(q, dq),
        "controller2": model.torque,
    }
    found = {name: track(arm, states, gains, law).tolist() for name, law in laws.items()}
    print(json.dumps({name: {"rms_error_rad": rms} for name, rms in found.items()}, indent=1))
    for name in ("controller1", "controller2"):
        shares = np.array(found[name]) / np.array(found["pid"])
        print(f"{name} beside pid: {np.round(shares, 4).tolist()}", file=sys.stderr)


if __name__ == "__main__":
    main()
