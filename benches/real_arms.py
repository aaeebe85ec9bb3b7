"""Public logs of real arms: their models beside a regressor that is given the kinematics.

    pip install ./python scipy pin
    python benches/real_arms.py [--data FOLDER] [--delan FOLDER] [--arms FOLDER] [NAME ...]

Prints what it finds of the named sets, or of all whose folder is given, and puts it into
docs/real-arms.md, which says what is measured and where the data come from. What is not run stays on
the page as it stands.
"""

import argparse
import json
import math
import re
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio
import torquewise
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfiltfilt

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "real-arms.md"
TESTED = 0.3  # part of the time that is tested on
MOST_ROWS = 4_000  # that the regressor is fitted on
RATE = 100.0  # of the torque of the further arms [Hz]
EDGE = 50  # rows left out at each end, where a zero-phase filter rings
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
FURTHER = ("xmate7p", "lwr_paths", "baxter", "krang", "youbot")


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
    derived = log.inspect().missing
    rows = joined(log.trajectories())
    seconds = rows["t"] - rows["t"][0]
    if arm.block:
        tested = (seconds / arm.block + way) % 3 >= 2
    else:
        part, first = seconds / seconds[-1], (1 - TESTED) * (1.0, 0.0, 0.5)[way]
        tested = (first <= part) & (part <= first + TESTED)
    found = {False: [], True: []}
    for own in np.split(np.arange(len(tested)), np.flatnonzero(np.diff(tested)) + 1):
        signals = {key: rows[key][own] for key in rows if key not in derived}
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


class Regressor:
    """Rigid bodies at known places, rotors, and offset, viscous and dry friction of each joint."""

    def __init__(self, robot, arm, joints, motion):
        self.robot, self.data = robot, robot.createData()
        self.balanced = [joints.index(name) for name in arm.balanced]
        n, m = len(joints), len(motion["t"])
        self.shafts = np.vstack([np.eye(n), *(np.isin(range(n), pair) for pair in arm.shafts)])
        peak = np.abs(motion["dq"]).max(axis=0)
        self.widths = [0.01 * peak[shaft != 0].min() for shaft in self.shafts]
        picked = np.arange(min(m, MOST_ROWS)) * m // min(m, MOST_ROWS)
        motion = {key: motion[key][picked] for key in motion}
        columns, tau = self.columns(motion), motion["tau"]
        weights = 1 / tau.std(axis=0)
        for _ in range(3):  # weighings of the joints by their residual
            rows = (weights[:, None] * columns).reshape(-1, columns.shape[-1])
            scales = np.linalg.norm(rows, axis=0)
            scales[scales == 0] = 1
            # Base parameters only: singular values below a part of the largest are zero.
            found = np.linalg.lstsq(rows / scales, (weights * tau).ravel(), rcond=1e-8)[0]
            self.coefficients = found / scales
            weights = 1 / self.rmse(motion)

    def columns(self, motion):
        """Columns of all rows and joints, m×n×p."""
        q, dq, ddq = (motion[key] for key in ("q", "dq", "ddq"))
        of = lambda *state: pinocchio.computeJointTorqueRegressor(self.robot, self.data, *state)
        columns = [np.array([of(*state).copy() for state in zip(q, dq, ddq)])]
        for shaft, width in zip(self.shafts, self.widths):
            v = dq @ shaft
            laws = np.stack([np.ones_like(v), v, np.tanh(v / width), ddq @ shaft], axis=-1)
            columns.append(shaft[:, None] * laws[:, None])
        for joint in self.balanced:
            waves = [wave(k * q[:, joint]) for k in (1, 2) for wave in (np.sin, np.cos)]
            columns.append((np.arange(q.shape[1]) == joint)[:, None] * np.stack(waves, -1)[:, None])
        return np.concatenate(columns, axis=-1)

    def rmse(self, motion):
        return rms(motion["tau"] - self.columns(motion) @ self.coefficients)


@dataclass
class Run:
    """One way to cut a log."""

    fit: torquewise.Fit
    told: torquewise.Fit  # with the URDF
    rows: tuple
    raw: int
    rmse: np.ndarray  # ours, with the URDF, the regressor's; 3×n
    nrmse: np.ndarray

    @classmethod
    def of(cls, arm, data, log, way):
        train, test = cut(arm, log, way)
        options = {"library": "chain", "counterbalance": list(arm.balanced)}
        fit = torquewise.fit(train, **options)
        same, joints = band(fit.model), fit.model.joints
        with tempfile.TemporaryDirectory() as folder:
            urdf = Path(folder) / "arm.urdf"
            held, robot = kinematics(arm, data, urdf, joints)
            told = torquewise.fit(train, urdf=urdf, lock=held, **same, **options)
        seen, judged = (
            joined(torquewise.read_log(part, **same).trajectories(conditioned=True))
            for part in (train, test)
        )
        theirs = Regressor(robot, arm, joints, seen).rmse(judged)
        ours = [own.evaluate(test) for own in (fit, told)]
        rmse = np.array([*(own.rmse for own in ours), theirs])
        nrmse = [np.array(own.nrmse_percent) / 100 for own in ours]
        nrmse = np.array([*nrmse, theirs / judged["tau"].std(axis=0)])
        raw = sum(len(part["t"]) for part in train)
        return cls(fit, told, (len(seen["t"]), len(judged["t"])), raw, rmse, nrmse)


def write_arm(page, name, arm, runs):
    """The rows of an arm in all tables."""
    fit, rows = runs[0].fit, runs[0].rows
    rmse, nrmse = (np.array([getattr(own, key) for own in runs]) for key in ("rmse", "nrmse"))
    ratios = nrmse.mean(axis=0) / nrmse.mean(axis=0)[2]
    means = [f"{geometric(own):.2f} | {own.max():.2f} |" for own in ratios[:2, : arm.counted]]
    seconds = [np.mean([getattr(own, key).seconds for own in runs]) for key in ("fit", "told")]
    cutoffs = ", ".join(f"{band(own.fit.model)['filter']:.1f}" for own in runs)
    page.row(
        "| set | joints | rows |",
        f"| {name} | {nrmse.shape[-1]} | {rows[0]} + {rows[1]} | {cutoffs} | {means[0]}"
        f" {arm.limit:.2f} | {seconds[0]:.0f} | {means[1]} {seconds[1]:.0f} |",
    )
    for j, joint in enumerate(fit.model.joints):
        ours, _, theirs = (f"{x.mean():.3f} ± {x.std(ddof=1):.3f}" for x in nrmse[:, :, j].T)
        remark = "" if j < arm.counted else " (not counted)"
        page.row(
            "| arm and joint |",
            f"| {name}: {joint} | {rmse[:, 0, j].mean():.3f} | {rmse[:, 2, j].mean():.3f} | {ours} |"
            f" {theirs} | {ratios[0, j]:.2f}{remark} | {ratios[1, j]:.2f} |",
        )
    write_choices(page, name, runs[0])


def write_choices(page, name, run):
    """The row of what was chosen on held-out rows of the training log."""
    found, same = run.fit.summary(), band(run.fit.model)
    chosen = {own["what"]: own["chosen"] for own in found["choices"]}
    laws = [chosen.get(f"friction of {joint}", "none") for joint in run.fit.model.joints]
    beside = [
        f"{what}: {way}"
        for what, way in chosen.items()
        if what.startswith(("shaft", "counterbalance")) and way != "none"
    ]
    page.row(
        "| arm | rows, raw",
        f"| {name} | {run.raw} → {found['rows']} | {same['filter']:.2f} | {1e3 * same['delay']:.1f} |"
        f" {run.fit.model.complexity} | {', '.join(laws)} | {'; '.join(beside) or 'none'} |"
        f" {chosen['strength of the physical prior']} |",
    )
    print(*run.fit.warnings, sep="\n")


def write_parts(page, folder):
    """A simulated arm whose parts of the torque are known."""
    archives = [dict(np.load(file)) for file in sorted(folder.glob("*.npz"))]
    logs = [{key: own[key] for key in ("t", "q", "dq", "ddq", "tau")} for own in archives]
    derived = [{key: own[key] for key in own if key != "ddq"} for own in logs]
    models = torquewise.fit(logs).model, torquewise.fit(derived, library="chain").model
    truth, errors = joined(archives), []
    for model in models:
        found = joined([model.parts(own["q"], own["dq"], own["ddq"]) for own in logs])
        found = {"m": found["inertia"], "c": found["coriolis"], "g": found["gravity"]}
        errors.append([100 * rms(found[key] - truth[key]) / rms(truth[key]) for key in found])
    lines = [
        f"A simulated two-link arm, {len(truth['t'])} rows in {len(logs)} trajectories at 25 Hz; the"
        " true parts of the torque are given apart from it. RMS error of each part, in percent of"
        f" the RMS of the part, with q̈ as given ({models[0].complexity} terms) and derived from the"
        f" velocity ({models[1].complexity} terms):\n",
        "| part | joint | ddq given [%] | ddq derived [%] |",
        "|---|---|---|---|",
    ]
    for k, part in enumerate(("inertia", "Coriolis", "gravity")):
        for j, (given, derived) in enumerate(zip(errors[0][k], errors[1][k])):
            lines.append(f"| {part} | {j + 1} | {given:.2e} | {derived:.2f} |".replace("e-0", "e-"))
    page.section("DeLaN characters", lines)


def track(model, log):
    """Measured torque and what a model misses of it, evenly sampled, 2×m×n."""
    found = joined(torquewise.read_log(log, **band(model)).trajectories(conditioned=True))
    raw = joined(torquewise.read_log(log).trajectories())
    t = np.arange(found["t"][0], found["t"][-1] + 1e-9, 1 / RATE)
    tau = CubicSpline(raw["t"], raw["tau"])(t)
    expected = model.torque(found["q"], found["dq"], found["ddq"])
    return np.array([tau, tau - CubicSpline(found["t"], expected)(t)])


def below(tracks, cutoff, order):
    """Torque and error through the same zero-phase low-pass filter, whatever that of the model."""
    low = butter(order, cutoff, fs=RATE, output="sos")
    return [sosfiltfilt(low, own, axis=1)[:, EDGE:-EDGE] for own in tracks]


def write_further(page, name, folder):
    """An arm whose kinematics nobody gives: its rows in the tables of the last section."""
    train, test = (sorted(folder.glob(f"{name}_{part}*.csv")) for part in ("train", "test"))
    if not train or not test:
        raise SystemExit(f"{folder}: no log {name}_train*.csv or {name}_test*.csv: write it there")
    fit = torquewise.fit(train, library="chain")
    tracks = [track(fit.model, log) for log in test]
    tests = below(tracks, 5.0, 4)
    deviation = np.concatenate(tests, axis=1)[0].std(axis=0)
    if len(tests) == 1:
        half = tests[0].shape[1] // 2
        tests = [tests[0][:, :half], tests[0][:, half : 2 * half]]
    errors = 100 * np.array([rms(missed) / deviation for _, missed in tests])
    cells = [spread(column) for column in errors.T] + [""] * (7 - errors.shape[1])
    page.row(
        "| arm | cut-off [Hz] |",
        f"| {name} | {band(fit.model)['filter']:.1f} | {fit.seconds:.0f} | {' | '.join(cells)} |"
        f" {spread(np.array([geometric(row) for row in errors]))} |",
    )
    page.replace(f"- {name}: ", f"{fit.verdict}: {'; '.join(fit.because)}")
    norm = np.linalg.norm
    of_norm = lambda tracks: [f"{100 * norm(own[1]) / norm(own[0]):.2f}" for own in tracks]
    ours = ""
    if name == "xmate7p":  # the filter of its notebooks
        ours = ", ".join(of_norm(below(tracks, 2.5, 3)))
        page.replace("Of the torque of xmate7p as it was measured: ", ", ".join(of_norm(tracks)) + " %.")
    if name == "youbot":  # 10 Hz where its notebooks take 1 000 rows per second, of 100
        missed = [own[1] for own in below(tracks, 1.0, 2)]
        each = ", ".join(f"{(own**2).mean():.2f}" for own in missed)
        ours = f"{(np.concatenate(missed) ** 2).mean():.2f} ({each})"
        ours += ", unusable" if fit.verdict == "unusable" else ""
    if ours:
        page.published(name, ours)


def spread(values):
    """Mean ± standard deviation, three digits."""
    digits = sum(values.mean() < bound for bound in (100, 10))
    return f"{values.mean():.{digits}f} ± {values.std(ddof=1):.{digits}f}"


class Page:
    """The page, of which lines and sections are replaced."""

    def __init__(self):
        self.lines = PAGE.read_text().splitlines()

    def find(self, begin, after=0):
        places = range(after, len(self.lines))
        return next(k for k in places if self.lines[k].startswith(begin))

    def replace(self, begin, rest, after=0):
        """The rest of the first line that begins so."""
        self.lines[self.find(begin, after)] = begin + rest
        print(begin + rest)

    def row(self, header, text):
        """The row of the same first cell in the table with this header."""
        name, rest = text[2:].split(" |", 1)
        self.replace(f"| {name} |", rest, self.find(header))

    def published(self, name, ours):
        """The last cell of all rows of an arm in the table of what others have published."""
        for k in range(self.find("| arm | by | given |"), len(self.lines)):
            if self.lines[k].startswith(f"| {name} |"):
                self.lines[k] = "|".join([*self.lines[k].split("|")[:-2], f" {ours} |"])
                print(self.lines[k])

    def section(self, title, lines):
        begin = self.find(f"## {title}") + 1
        end = self.find("## ", begin)
        self.lines[begin:end] = ["", *"\n".join(lines).split("\n"), ""]
        print(f"## {title}\n", *lines, sep="\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, help="folder of the logs with known kinematics")
    parser.add_argument("--delan", type=Path, help="folder that examples/delan_to_npz.py wrote")
    parser.add_argument("--arms", type=Path, help="folder of the further arms")
    parser.add_argument("names", nargs="*", metavar="NAME", help="sets to run; all without")
    given = parser.parse_args()
    wanted = lambda name: not given.names or any(own in name for own in given.names)
    page = Page()
    for (name, profile), arm in ARMS.items():
        if given.data and wanted(name):
            profile = ROOT / "profiles" / f"{profile}.toml"
            log = torquewise.read_log(given.data / arm.log, profile=profile, repair=True)
            write_arm(page, name, arm, [Run.of(arm, given.data, log, way) for way in range(3)])
    if given.delan and wanted("DeLaN characters"):
        write_parts(page, given.delan)
    for name in FURTHER:
        if given.arms and wanted(name):
            write_further(page, name, given.arms)
    PAGE.write_text("\n".join(page.lines) + "\n")


if __name__ == "__main__":
    main()
