"""torquewise beside its peers on public logs of real arms: the same rows, all but PySINDy with the URDF.

    TORQUEWISE_SHARED=FOLDER python3 benches/peers/arms.py [--folder FOLDER] [--wheel FILE] [ARM[:PEER] ...]

FOLDER/data and FOLDER/robots (default ../shared) hold the logs and robots that `public_logs.py` names.
Makes a virtual environment in target/peers with pinned versions and torquewise, from a wheel or built
here, runs every peer in a process of its own, one after the other, and writes arms.json and arms.md.
What is run again takes the place of what was found before.
"""

import argparse
import json
import math
import os
import re
from pathlib import Path

from environment import ROOT, environment, run_apart

ARMS = ["UR10", "Panda", "DFKI double pendulum", "Stäubli TX40", "KUKA KR300", "TIAGo arm"]
COUNTED = {"TIAGo arm": 4}  # joints; the torque of the others is mostly quantisation
PEERS = [
    "torquewise", "torquewise, URDF", "the MJCF of it, in MuJoCo", "torquewise, URDF, refined",
    "regressor, plain friction", "regressor, our friction", "FIGAROH", "FIGAROH, physical", "PySINDy",
    "mujoco.sysid",
]  # fmt: skip
CUTS = ["time", "region"]
# Simulations are judged on the parts of the time alone.
ONE_CUT = {
    "the MJCF of it, in MuJoCo",
    "torquewise, URDF, refined",
    "FIGAROH, physical",
    "mujoco.sysid",
}
SECONDS = 600  # longer than this no peer is waited for


def run(python, folder, shared, wanted):
    results = folder / "arms.json"
    found = json.loads(results.read_text()) if results.exists() else {}
    for arm, names in wanted.items():
        for cut in CUTS:
            own = folder / "arms" / re.sub(r"\W+", "-", arm) / cut
            own.mkdir(parents=True, exist_ok=True)
            if "torquewise" in names:
                told = run_apart(python, "arm_data.py", [own, shared, arm, cut], SECONDS)
                print(arm, cut, told, flush=True)
            for name in names:
                if cut == "time" or name not in ONE_CUT:
                    result = run_apart(python, "arm_peer.py", [own, name], SECONDS)
                    found.setdefault(arm, {}).setdefault(name, {})[cut] = result
                    print(arm, cut, name, result, flush=True)
                    results.write_text(json.dumps(found, indent=1))
    return found


def mean(values):
    """Geometric mean; infinite where one is unknown, as a simulation that ran away."""
    if any(x is None for x in values):
        return math.inf
    return math.exp(sum(map(math.log, values)) / len(values))


def torque_cell(arm, results):
    """Mean and worst joint [%], in parts of the time and in regions."""
    cells = []
    for cut in CUTS:
        own = results.get(cut, {})
        if "errors" in own:
            errors = [100 * x for x in own["errors"][: COUNTED.get(arm)]]
            cells.append(f"{digits(mean(errors))} ({digits(max(errors))})")
        elif own:
            cells.append(own["failed"].split(";")[0].replace("|", " ")[:60])
    return ", ".join(cells)


def motion_cell(arm, results):
    """Drift over that of an arm that keeps its velocity, processor time [s], peak memory [MB]."""
    own = results.get("time", {})
    cells = []
    if own.get("drift"):
        value = mean(own["drift"][: COUNTED.get(arm)])
        cells.append(f"{value:.2f}" if value < 10 else "away")
    if "seconds" in own:
        cells += ["–"] * (not cells) + [digits(own["seconds"][1]), f"{own['memory_mb']:.0f}"]
    return ", ".join(cells)


def digits(x):
    """Two digits, none behind the point from ten on."""
    return f"{x:.0f}" if x >= 9.95 else f"{x:.1f}" if x >= 0.995 else f"{x:.2f}"


TABLES = {
    "Held-out torque, NRMSE [%], geometric mean of the joints (worst joint): of 30 % of the time, then of"
    " 30 % of the configurations": torque_cell,
    "Drift after 0.5 s over that of an arm that keeps its velocity, geometric mean of the joints; processor"
    " time of the fit [s]; peak memory [MB]": motion_cell,
}


def page(found):
    arms = [arm for arm in ARMS if arm in found]
    parts = []
    for title, cell in TABLES.items():
        lines = [f"| | {' | '.join(arms)} |", "|---" * (1 + len(arms)) + "|"]
        for name in PEERS:
            cells = [cell(arm, found[arm].get(name, {})) for arm in arms]
            if any(cells):
                lines.append(f"| {name} | {' | '.join(cells)} |")
        parts.append(f"{title}\n\n" + "\n".join(lines) + "\n")
    return "\n".join(parts)


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--folder", type=Path, default=ROOT / "target" / "peers")
    parser.add_argument("--wheel", type=Path, help="wheel of the Python package; built without")
    parser.add_argument("wanted", nargs="*", metavar="ARM[:PEER]", help="all without")
    given = parser.parse_args()
    wanted = {}
    for word in given.wanted or ARMS:
        arm, _, peer = word.partition(":")
        if arm not in ARMS or (peer and peer not in PEERS):
            parser.error(f"no {word}: there are {'; '.join(ARMS)}, each with {'; '.join(PEERS)}")
        wanted.setdefault(arm, []).extend([peer] if peer else PEERS)
    return given, wanted


def main():
    given, wanted = arguments()
    shared = Path(os.environ.get("TORQUEWISE_SHARED", ROOT.parent / "shared")).resolve()
    if not (shared / "data").is_dir():
        raise SystemExit(
            f"{shared}/data: no such folder, name the one above it in TORQUEWISE_SHARED"
        )
    folder = given.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    python = environment(folder, given.wheel or ROOT / "python")
    text = page(run(python, folder, shared, wanted))
    (folder / "arms.md").write_text(text)
    print(text)


if __name__ == "__main__":
    main()
