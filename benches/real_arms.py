"""Public logs of real arms: their models beside a regressor that is given the kinematics.

    pip install ./python scipy pin
    python benches/real_arms.py [--data FOLDER] [--delan FOLDER] [--arms FOLDER] [NAME ...]

Prints what it finds of the named sets, or of all whose folder is given, and puts it into
docs/real-arms.md, which says what is measured and where the data come from. What is not run stays on
the page as it stands.
"""

import argparse
import json
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from public_logs import (
    ARMS,
    PlainFriction,
    Regressor,
    band,
    cut,
    geometric,
    joined,
    kinematics,
    rms,
)
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfiltfilt

import torquewise

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "real-arms.md"
RATE = 100.0  # of the torque of the further arms [Hz]
EDGE = 50  # rows left out at each end, where a zero-phase filter rings
FURTHER = ("xmate7p", "lwr_paths", "baxter", "krang", "youbot")


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
        theirs = Regressor(robot, PlainFriction(arm, joints, seen), seen).rmse(judged)
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


def told(model):
    """Terms of the equations that can be told from zero, and laws of friction."""
    model = json.loads(model.to_json())
    terms = model["form"]["energy"]
    sure = [own for own in terms if abs(own["coefficient"]) >= 2 * own["std_error"]]
    return len(sure) + len(model.get("friction", []))


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
        f" {told(run.fit.model)} | {', '.join(laws)} | {'; '.join(beside) or 'none'} |",
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
    """Measured torque, what a model misses of it, and 1 outside gaps, evenly sampled, 3×m×n."""
    found = joined(torquewise.read_log(log, **band(model)).trajectories(conditioned=True))
    raw = joined(torquewise.read_log(log).trajectories())
    t = np.arange(found["t"][0], found["t"][-1] + 1e-9, 1 / RATE)
    tau = CubicSpline(raw["t"], raw["tau"])(t)
    expected = model.torque(found["q"], found["dq"], found["ddq"])
    steps = np.diff(found["t"])
    is_whole = steps[np.searchsorted(found["t"][1:-1], t)] < 2 * np.median(steps)
    missed = tau - CubicSpline(found["t"], expected)(t)
    whole = np.repeat(is_whole[:, None], tau.shape[1], axis=1)
    return np.array([tau, np.where(whole, missed, 0), whole])


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
    tests = [own[:2, own[2, :, 0] > 0.99] for own in below(tracks, 5.0, 4)]
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
        page.replace(
            "Of the torque of xmate7p as it was measured: ", ", ".join(of_norm(tracks)) + " %."
        )
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
        """The row of the same first cell in the table with this header; printed where it has none."""
        name, rest = text[2:].split(" |", 1)
        if any(line.startswith(f"| {name} |") for line in self.lines):
            self.replace(f"| {name} |", rest, self.find(header))
        else:
            print(text)

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
