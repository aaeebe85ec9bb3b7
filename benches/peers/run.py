"""torquewise beside its peers: the same rows, candidates, machine and run.

    python3 benches/peers/run.py [--folder FOLDER] [TASK[:PEER] ...]

Makes a virtual environment in FOLDER (default target/peers), lets `cargo bench --bench peers` write
the rows and its own times, then runs every peer in a process of its own, one after the other, and
writes FOLDER/peers.json, FOLDER/peers.md and plots, of which docs/images holds copies. Times are of
the clock and of all processors; on a shared machine only the latter can be compared. What is run
again takes the place of what was found before.
"""

import argparse
import json
import subprocess
from pathlib import Path

from environment import HERE, ROOT, environment, run_apart

SIZES = ["candidates196", "candidates700", "candidates1764"]
ROWS = ["rows10000", "rows100000", "rows1000000"]  # ten times more do not fit a peer's memory
TASKS = {
    "library": ["lstsq", "pysindy", "celer", "skglm", "sklearn", "lars"],
    "steps": ["pysindy"],
} | {task: ["lstsq", "pysindy"] for task in SIZES + ROWS}
TITLES = {
    "library": "the whole library of SINDy, 20 000 rows",
    "steps": "the three steps of the paper, 20 000 rows",
}
SECONDS = 3600  # longer than this no peer is waited for


def ours(folder, tasks):
    command = ["cargo", "bench", "-p", "torquewise-identify", "--bench", "peers", "--", str(folder)]
    owner = {**dict.fromkeys(SIZES, "library"), **dict.fromkeys(ROWS, "rows")}
    own = dict.fromkeys(owner.get(task, task) for task in tasks)
    subprocess.run([*command, *own], cwd=ROOT, check=True)
    return json.loads((folder / "ours.json").read_text())


def peer(python, folder, task, name):
    return run_apart(python, "peer.py", [folder, task, name], SECONDS)


def own_seconds(own, task, name):
    """Our seconds at what a peer does at a task."""
    if task == "steps":
        return own[task]["fit"]
    own = own[task]
    if task == "library":
        own = max(own["candidates"].items(), key=lambda pair: int(pair[0]))[1]
    after = {"lstsq": "lstsq", "pysindy": "stlsq"}.get(name, "lasso")
    return [a + b for a, b in zip(own["gram"], own[after])]


def pair(numbers, digits):
    return ", ".join(f"{x:.{digits}f}" for x in numbers)


def whole(result):
    """Seconds of a peer with the evaluation of its library."""
    evaluated = result.get("library_seconds", [0.0, 0.0])
    return [part + more for part, more in zip(result.get("seconds", []), evaluated)]


def percent(errors):
    return " ".join(f"{x:.2g}" for x in errors)


def table(found, task):
    own = found["ours"].get(task, {})
    lines = [
        "| peer | its seconds | evaluating the library | ours | ratio | with evaluation "
        "| memory [MB] | gap | terms | errors [%] | best |",
        "|---" * 11 + "|",
    ]
    for name, result in found["peers"].get(task, {}).items():
        if "seconds" not in result:
            lines.append(f"| {name} | {result.get('failed', 'failed')} |" + " |" * 9)
            continue
        mine = own_seconds(found["ours"], task, name)
        spent, evaluated = result["seconds"], result.get("library_seconds", [])
        alone = [part / own for part, own in zip(spent, mine)]
        all_in = [part / own for part, own in zip(whole(result), mine)]
        apart = "library_seconds" in result
        cells = [name, pair(spent, 2), pair(evaluated, 2) if apart else "included", pair(mine, 3)]
        cells += [pair(alone, 0) if apart else "", pair(all_in, 0), f"{result['memory_mb']:.0f}"]
        cells += [f"{result['gap']:.1e}" if "gap" in result else "", str(result.get("active", ""))]
        cells += [percent(result.get("errors", [])), result.get("best", "")]
        lines.append(f"| {' | '.join(cells)} |")
    if "errors" in own:
        cells = ["torquewise, a whole fit", "", "", pair(own["fit"], 3), "", "", "", ""]
        lines.append(f"| {' | '.join(cells)} | {own['active']} | {percent(own['errors'])} | |")
    return "\n".join(lines) + "\n"


def page(found):
    tasks = [task for task in TITLES if task in found["peers"]]
    parts = [f"{TITLES[task]}\n\n{table(found, task)}" for task in tasks]
    if any(size in found["peers"] for size in SIZES):
        lines = ["| candidates | least squares | lstsq | STLSQ | PySINDy |", "|---" * 5 + "|"]
        sizes = found["ours"]["library"]["candidates"].items()
        for size, own in sorted(sizes, key=lambda pair: int(pair[0])):
            peers = found["peers"].get(f"candidates{size}", found["peers"].get("library", {}))
            cells = [str(size)]
            for mine, name in (("lstsq", "lstsq"), ("stlsq", "pysindy")):
                cells.append(pair([a + b for a, b in zip(own["gram"], own[mine])], 3))
                cells.append(pair(whole(peers.get(name, {})), 2))
            lines.append(f"| {' | '.join(cells)} |")
        parts.append("20 000 rows, seconds over candidates\n\n" + "\n".join(lines) + "\n")
    if any(rows in found["peers"] for rows in ROWS):
        lines = ["| rows | least squares | lstsq | STLSQ | PySINDy |", "|---" * 5 + "|"]
        for rows, own in sorted(found["ours"]["rows"]["seconds"].items(), key=lambda p: int(p[0])):
            cells, peers = [f"{int(rows):.0e}"], found["peers"].get(f"rows{rows}", {})
            for name, mine in own.items():
                cells += [pair(mine, 3), pair(peers.get(name, {}).get("seconds", []), 2)]
            lines.append(f"| {' | '.join(cells)} |")
        parts.append("196 candidates, seconds over rows\n\n" + "\n".join(lines) + "\n")
    return "\n".join(parts)


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--folder", type=Path, default=ROOT / "target" / "peers")
    parser.add_argument("tasks", nargs="*", metavar="TASK[:PEER]", default=list(TASKS))
    words, groups = parser.parse_args(), {"rows": ROWS, "candidates": SIZES}
    wanted = {}
    for word in words.tasks:
        group, _, name = word.partition(":")
        for task in groups.get(group, [group]):
            if task not in TASKS or (name and name not in TASKS[task]):
                parser.error(f"no task {word}: there are {', '.join(TASKS)}, rows, candidates")
            wanted.setdefault(task, []).extend([name] if name else TASKS[task])
    return words.folder.resolve(), wanted


def versions(python):
    listed = subprocess.run(
        [python, "-m", "pip", "list", "--format=json"], capture_output=True, check=True, text=True
    )
    needed = (HERE / "requirements.txt").read_text()
    found = {package["name"]: package["version"] for package in json.loads(listed.stdout)}
    return {name: version for name, version in found.items() if name.lower() + "==" in needed}


def main():
    folder, wanted = arguments()
    folder.mkdir(parents=True, exist_ok=True)
    python, results = environment(folder), folder / "peers.json"
    found = json.loads(results.read_text()) if results.exists() else {"ours": {}, "peers": {}}
    found["versions"] = versions(python)
    found["ours"].update(ours(folder, wanted))
    if "library" in wanted:
        found["check"] = peer(python, folder, "library", "check")
    for task, names in wanted.items():
        for name in names:
            result = peer(python, folder, task, name)
            found["peers"].setdefault(task, {})[name] = result
            print(task, name, result, flush=True)
            results.write_text(json.dumps(found, indent=1))
    (folder / "peers.md").write_text(page(found))
    print(page(found))
    subprocess.run([str(python), str(HERE / "plots.py"), str(folder)], check=True)


if __name__ == "__main__":
    main()
