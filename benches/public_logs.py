"""Public logs of real arms whose kinematics are known: where they are, and how they are cut.

What `real_arms.py` and `peers/arms.py` have in common.
"""

import json
import math
import re
from dataclasses import dataclass

import numpy as np
import pinocchio

TESTED = 0.3  # part of the time that is tested on
MOST_ROWS = 4_000  # that the regressor is fitted on
RIGHT = math.pi / 2


@dataclass
class Arm:
    """A public log of a real arm, and the kinematics that the regressor is given."""

    log: str
    urdf: str = ""  # a file
    moving: tuple = ()  # what the names of its moving joints begin with
    dh: tuple = ()  # or rows of (a, alpha, d, offset)
    roll: float = 0.0  # of the base of those
    block: float = 0.0  # every third block of so many seconds is tested on; 0 for whole parts
    limit: float = 1.25  # how much worse than the regressor a joint may be
    counted: int = 6  # joints that count; the torque of the others is mostly quantisation
    shafts: tuple = ()  # joints that turn a shaft together, known to the regressor
    balanced: tuple = ()  # joints that a spring is known to balance, told to both


KR300 = (
    (0.35, RIGHT, -0.675, 0.0),
    (1.15, 0.0, -0.189, 0.0),
    (0.041, -RIGHT, 0.189, RIGHT),
    (0.0, RIGHT, -1.0, 0.0),
    (0.0, -RIGHT, 0.0, 0.0),
    (0.0, math.pi, -0.24, 0.0),
)
# Hanging down at q = 0: x of the links points down once the base is rolled by a quarter turn.
PENDULUM = ((0.3, 0.0, 0.0, -RIGHT), (0.2, 0.0, 0.0, 0.0))
ARMS = {  # name on the page, profile
    ("UR10", "ur10"): Arm(
        "ur10_panda_unisa/ur10_exciting_trajectory.db3",
        "ur10_panda_unisa/ur10_from_example-robot-data.urdf", ("shoulder", "elbow", "wrist"),
    ),
    ("Panda", "panda"): Arm(
        "ur10_panda_unisa/panda_exciting_trajectory.db3",
        "../robots/panda.urdf", ("panda_joint",), block=2.0, limit=1.5, counted=7,
    ),
    ("DFKI double pendulum", "dfki_double_pendulum"): Arm(
        "dfki_double_pendulum/A0_20220812/20220812-061157-PM_measured.csv",
        dh=PENDULUM, roll=RIGHT, limit=1.0, counted=2,
    ),
    ("Stäubli TX40", "staubli_tx40"): Arm(
        "staubli_tx40_figaroh/pos_read_data.csv",
        "staubli_tx40_figaroh/tx40_mdh_modified.urdf", ("joint",), block=0.5, shafts=((4, 5),),
    ),
    ("KUKA KR300", "kuka_kr300"): Arm(  # the spring is hydraulic, as its maker says
        "kuka_kr300_weigand/A/data.mat", dh=KR300, roll=math.pi, balanced=("axis_2",),
    ),
    ("TIAGo arm", "tiago_arm"): Arm(
        "tiago_arm_figaroh/tiago_position.csv",
        "tiago_arm_figaroh/tiago_48_schunk.urdf", ("arm_",), counted=4,
    ),
}  # fmt: skip


def joined(trajectories):
    return {key: np.concatenate([own[key] for own in trajectories]) for key in trajectories[0]}


def rms(x):
    return np.sqrt((x**2).mean(axis=0))


def geometric(values):
    return np.exp(np.log(values).mean())


def band(model):
    """The options by which a log is filtered as that of the model was."""
    found = json.loads(model.to_json())["training"]["filter"]
    return {"filter": found["cutoff_hz"], "delay": found["delay"]}


def cut(arm, log, way):
    """Trajectories to train and to test on, cut before anything is conditioned."""
    rows = joined(log.trajectories())
    seconds = rows["t"] - rows["t"][0]
    if arm.block:
        return parted(log, (seconds / arm.block + way) % 3 >= 2)
    part, first = seconds / seconds[-1], (1 - TESTED) * (1.0, 0.0, 0.5)[way]
    return parted(log, (first <= part) & (part <= first + TESTED))


def cut_by_region(arm, log):
    """The same, where configurations are tested on that are not trained on.

    Those farthest along the first principal component of the positions, each joint by its spread.
    Shorter visits than a block, or a second, are left out.
    """
    rows = joined(log.trajectories())
    q = (rows["q"] - rows["q"].mean(axis=0)) / rows["q"].std(axis=0)
    along = q @ np.linalg.svd(q, full_matrices=False)[2][0]
    return parted(log, along > np.quantile(along, 1 - TESTED), arm.block or 1.0)


def parted(log, tested, shortest=0.0):
    """Trajectories of the rows that are not tested on, and of those that are."""
    derived = log.inspect().missing
    rows = joined(log.trajectories())
    found = {False: [], True: []}
    for own in np.split(np.arange(len(tested)), np.flatnonzero(np.diff(tested)) + 1):
        signals = {key: rows[key][own] for key in rows if key not in derived}
        if signals["t"][-1] - signals["t"][0] >= shortest:
            found[bool(tested[own[0]])].append(signals | {"joints": log.joints})
    return found[False], found[True]


def urdf_of_dh(arm, joints):
    """URDF turns and moves before a joint, Denavit and Hartenberg after it."""
    rpy, xyz = (arm.roll, 0.0, 0.0), (0.0, 0.0, 0.0)
    bodies = ['<link name="link0"/>']
    for k, (name, (a, alpha, d, offset)) in enumerate(zip(joints, arm.dh)):
        origin = f'rpy="{rpy[0]} {rpy[1]} {rpy[2]}" xyz="{xyz[0]} {xyz[1]} {xyz[2]}"'
        bodies.append(
            f'<link name="link{k + 1}"/><joint name="{name}" type="revolute"><origin {origin}/>'
            f'<parent link="link{k}"/><child link="link{k + 1}"/><axis xyz="0 0 1"/>'
            '<limit lower="-9" upper="9" effort="1" velocity="1"/></joint>'
        )
        rpy, xyz = (alpha, 0.0, offset), (a * math.cos(offset), a * math.sin(offset), d)
    return f'<robot name="arm">{"".join(bodies)}</robot>'


def kinematics(arm, data, file, joints):
    """Writes the arm as a URDF without masses; its joints that are held, and all for Pinocchio."""
    text = urdf_of_dh(arm, joints) if arm.dh else (data / arm.urdf).read_text()
    text = re.sub(r"<inertial.*?</inertial>", "", text, flags=re.DOTALL)
    file.write_text(text)
    robot = pinocchio.buildModelFromUrdf(str(file))
    held = [own for own in list(robot.names)[1:] if arm.urdf and not own.startswith(arm.moving)]
    places = [robot.getJointId(name) for name in held]
    return held, pinocchio.buildReducedModel(robot, places, pinocchio.neutral(robot))


def springs(joints, q):
    """Columns of springs that balance some joints, m×n×4 each."""
    for joint in joints:
        waves = [wave(k * q[:, joint]) for k in (1, 2) for wave in (np.sin, np.cos)]
        yield (np.arange(q.shape[1]) == joint)[:, None] * np.stack(waves, -1)[:, None]


class PlainFriction:
    """Columns of offset, viscous and dry friction, rotors, and springs that are known of."""

    def __init__(self, arm, joints, motion):
        self.balanced = [joints.index(name) for name in arm.balanced]
        n = len(joints)
        self.shafts = np.vstack([np.eye(n), *(np.isin(range(n), pair) for pair in arm.shafts)])
        peak = np.abs(motion["dq"]).max(axis=0)
        self.widths = [0.01 * peak[shaft != 0].min() for shaft in self.shafts]

    def __call__(self, motion):
        q, dq, ddq = (motion[key] for key in ("q", "dq", "ddq"))
        columns = []
        for shaft, width in zip(self.shafts, self.widths):
            v = dq @ shaft
            laws = np.stack([np.ones_like(v), v, np.tanh(v / width), ddq @ shaft], axis=-1)
            columns.append(shaft[:, None] * laws[:, None])
        return np.concatenate([*columns, *springs(self.balanced, q)], axis=-1)


class Regressor:
    """Rigid bodies at known places, and drives: a function of a motion, columns m×n×p."""

    def __init__(self, robot, drives, motion):
        self.robot, self.data, self.drives = robot, robot.createData(), drives
        m = len(motion["t"])
        picked = np.arange(min(m, MOST_ROWS)) * m // min(m, MOST_ROWS)
        columns, tau = self.columns(motion, picked), motion["tau"][picked]
        weights = 1 / tau.std(axis=0)
        for _ in range(3):  # weighings of the joints by their residual
            rows = (weights[:, None] * columns).reshape(-1, columns.shape[-1])
            scales = np.linalg.norm(rows, axis=0)
            scales[scales == 0] = 1
            # Base parameters only: singular values below a part of the largest are zero.
            found = np.linalg.lstsq(rows / scales, (weights * tau).ravel(), rcond=1e-8)[0]
            self.coefficients = found / scales
            weights = 1 / rms(tau - columns @ self.coefficients)

    def bodies(self, q, dq, ddq):
        """Columns of the bodies at a state, n×10n."""
        return pinocchio.computeJointTorqueRegressor(self.robot, self.data, q, dq, ddq)

    def columns(self, motion, rows=slice(None)):
        """Columns of rows, all by default, and joints, m×n×p; drives remember the rows before."""
        states = zip(*(motion[key][rows] for key in ("q", "dq", "ddq")))
        bodies = np.array([self.bodies(*state).copy() for state in states])
        return np.concatenate([bodies, self.drives(motion)[rows]], axis=-1)

    def torque(self, motion):
        return self.columns(motion) @ self.coefficients

    def rmse(self, motion):
        return rms(motion["tau"] - self.torque(motion))
