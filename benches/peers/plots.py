"""FOLDER/peers.json -> candidates.svg, rows.svg: seconds over the candidates, and over the rows."""

import json
import sys
from pathlib import Path

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt

plt.rcParams["svg.fonttype"] = "none"
TASKS = {"lstsq": "least squares", "stlsq": "STLSQ", "lasso": "LASSO path"}
PEERS = {"lstsq": "lstsq", "pysindy": "stlsq"}


def whole(result):
    """Seconds of a peer with the evaluation of its library."""
    return result["seconds"][0] + result.get("library_seconds", [0])[0]


def candidates(found, axes):
    ours = found["ours"]["library"]["candidates"]
    sizes = sorted(ours, key=int)
    colors = {}
    for color, (task, label) in enumerate(TASKS.items()):
        colors[task] = f"C{color}"
        times = [ours[size]["gram"][0] + ours[size][task][0] for size in sizes]
        axes.loglog(
            [int(size) for size in sizes],
            times,
            "o-",
            color=colors[task],
            label="torquewise, " + label,
        )
    peers = {size: found["peers"].get(f"candidates{size}", {}) for size in sizes}
    peers[sizes[-1]] = found["peers"]["library"]
    for name in peers[sizes[-1]]:
        times = {int(size): peers[size].get(name, {}) for size in sizes}
        times = {size: whole(result) for size, result in times.items() if "seconds" in result}
        color = colors[PEERS.get(name, "lasso")]
        axes.plot(times.keys(), times.values(), "x--", color=color)
        for size in list(times)[-1:]:
            axes.annotate(name + "  ", (size, times[size]), ha="right", va="bottom")
    axes.set_xticks([int(size) for size in sizes], sizes)
    axes.minorticks_off()
    axes.set_xlabel("candidates")
    axes.set_ylabel("from 20 000 rows to weights [s]")


def rows(found, axes):
    ours = sorted(found["ours"]["rows"]["seconds"].items(), key=lambda pair: int(pair[0]))
    peers = (("lstsq", "least squares", "numpy lstsq"), ("pysindy", "STLSQ", "PySINDy"))
    for color, (name, task, label) in enumerate(peers):
        times = {int(rows): own[name][0] for rows, own in ours}
        axes.loglog(
            times.keys(), times.values(), "o-", color=f"C{color}", label="torquewise, " + task
        )
        results = {rows: found["peers"].get(f"rows{rows}", {}).get(name, {}) for rows in times}
        theirs = {rows: own["seconds"][0] for rows, own in results.items() if "seconds" in own}
        axes.plot(theirs.keys(), theirs.values(), "x--", color=f"C{color}", label=label)
    axes.set_xlabel("rows")
    axes.set_ylabel("from rows to weights, 196 candidates [s]")


def main():
    folder = Path(sys.argv[1])
    found = json.loads((folder / "peers.json").read_text())
    tasks = {"candidates": ("library", candidates), "rows": ("rows10000", rows)}
    for name, (task, draw) in tasks.items():
        if task in found["peers"]:
            figure, axes = plt.subplots(figsize=(6.4, 4.2), layout="constrained")
            draw(found, axes)
            axes.legend(loc="upper left")
            figure.savefig(folder / f"{name}.svg", metadata={"Date": None})


if __name__ == "__main__":
    main()
