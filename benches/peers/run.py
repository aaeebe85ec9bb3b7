"""torquewise beside its peers: the same rows, candidates, machine and run.

    python3 benches/peers/run.py [FOLDER] [PEER ...]

Makes a virtual environment in FOLDER (default target/peers), lets `cargo bench --bench peers` write
the rows and its own times, then runs every peer in a process of its own, one after the other, and
writes FOLDER/peers.json, FOLDER/peers.md and FOLDER/candidates.svg, of which docs/images/peers.svg is
a copy. Times are of the clock and of all processors; on a shared machine only the latter can be
compared.
"""

import json
import subprocess
import sys
import venv
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
PEERS = ["lstsq", "pysindy", "celer", "skglm", "sklearn", "lars"]
SECONDS = 3600  # longer than this no peer is waited for


def environment(folder):
    python = folder / "venv" / "bin" / "python"
    if not python.exists():
        venv.create(folder / "venv", with_pip=True)
    wanted = ["-q", "-r", str(HERE / "requirements.txt")]
    subprocess.run([python, "-m", "pip", "install", *wanted], check=True)
    return python


def ours(folder):
    command = ["cargo", "bench", "-p", "torquewise-identify", "--bench", "peers", "--", str(folder)]
    subprocess.run(command, cwd=ROOT, check=True)
    return json.loads((folder / "ours.json").read_text())


def peer(python, folder, name):
    command = [str(python), str(HERE / "peer.py"), str(folder), name]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS)
    except subprocess.TimeoutExpired:
        return {"failed": f"took more than {SECONDS} s"}
    lines = done.stdout.strip().splitlines()
    return json.loads(lines[-1]) if done.returncode == 0 and lines else {"failed": done.stderr[-300:]}


def pair(numbers, digits):
    return ", ".join(f"{x:.{digits}f}" for x in numbers)


def table(found):
    own = max(found["ours"]["candidates"].items(), key=lambda pair: int(pair[0]))[1]
    tasks = {"lstsq": "lstsq", "pysindy": "stlsq"}
    # By the clock, and of all processors.
    lines = ["| peer | its seconds | evaluating the library | ours | ratio | with evaluation "
             "| memory [MB] | gap |", "|---|---|---|---|---|---|---|---|"]
    for name, result in found["peers"].items():
        if "seconds" not in result:
            lines.append(f"| {name} | {result.get('failed', 'failed')} | | | | | | |")
            continue
        task = tasks.get(name, "lasso")
        mine = [own["gram"][k] + own[task][k] for k in (0, 1)]
        spent, evaluated = result["seconds"], result.get("library_seconds", [0.0, 0.0])
        gap = f"{result['gap']:.1e}" if "gap" in result else ""
        alone = [part / own for part, own in zip(spent, mine)]
        whole = [(part + more) / own for part, more, own in zip(spent, evaluated, mine)]
        apart = "library_seconds" in result
        cells = [pair(spent, 1), pair(evaluated, 1) if apart else "included", pair(mine, 2)]
        cells += [pair(alone, 0) if apart else "", pair(whole, 0)]
        lines.append(f"| {name} | {' | '.join(cells)} | {result['memory_mb']:.0f} | {gap} |")
    return "\n".join(lines) + "\n"


PLOT = """
import json, sys
import matplotlib
matplotlib.use("svg")
import matplotlib.pyplot as plt
found = json.load(open(sys.argv[1]))
sizes = sorted(found["ours"]["candidates"].items(), key=lambda pair: int(pair[0]))
p = [int(size) for size, _ in sizes]
tasks = {"lstsq": "least squares", "stlsq": "STLSQ", "lasso": "LASSO path"}
peers = {"lstsq": ["lstsq"], "stlsq": ["pysindy"]}
plt.rcParams["svg.fonttype"] = "none"
figure, axes = plt.subplots(figsize=(6.4, 4.2), layout="constrained")
for color, (task, label) in enumerate(tasks.items()):
    ours = [own["gram"][0] + own[task][0] for _, own in sizes]
    axes.loglog(p, ours, "o-", color=f"C{color}", label="torquewise, " + label)
    for name, result in found["peers"].items():
        if "seconds" in result and name in peers.get(task, set(found["peers"]) - {"lstsq", "pysindy"}):
            whole = result["seconds"][0] + result.get("library_seconds", [0])[0]
            axes.plot(p[-1], whole, "x", color=f"C{color}")
            axes.annotate(name + " ", (p[-1], whole), ha="right", va="center")
axes.set_xticks(p, [str(size) for size in p])
axes.minorticks_off()
axes.set_xlabel("candidates")
axes.set_ylabel("from 20 000 rows to weights [s]")
axes.legend(loc="upper left")
figure.savefig(sys.argv[2], metadata={"Date": None})
"""


def main():
    words = sys.argv[1:]
    folder = Path(words[0] if words else ROOT / "target" / "peers").resolve()
    folder.mkdir(parents=True, exist_ok=True)
    python = environment(folder)
    found = {"ours": ours(folder), "check": peer(python, folder, "check"), "peers": {}}
    for name in words[1:] or PEERS:
        found["peers"][name] = peer(python, folder, name)
        print(name, found["peers"][name], flush=True)
        (folder / "peers.json").write_text(json.dumps(found, indent=1))
    (folder / "peers.md").write_text(table(found))
    print(table(found))
    plot = [str(folder / "peers.json"), str(folder / "candidates.svg")]
    subprocess.run([str(python), "-c", PLOT, *plot], check=True)


if __name__ == "__main__":
    main()
