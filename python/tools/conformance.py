"""Writes the conformance set, tests/conformance: small logs of simulated arms, and the model each must give.

A case is NAME.json: the log, the options of the fit, how many terms the model has, and the true torque of
the arm at states that the log does not hold. Whatever reads logs and fits models – Rust, the command
line, Python, exported code – must come within `within_percent` of its RMS.
"""

import json
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

import torquewise

FOLDER = Path(__file__).parents[2] / "tests/conformance"
FRICTION = "[joint1]\ncoulomb = 0.8\nviscous = 0.5\n[joint2]\ncoulomb = 0.3\nviscous = 0.2\n"


def write_log(name: str, signals: tuple[str, ...], rows: dict[str, Any]) -> None:
    n = rows["q"].shape[1]
    header = ["t", *(f"{key}{k}" for key in signals for k in range(1, n + 1))]
    table = np.column_stack([rows["t"], *(rows[key] for key in signals)])
    np.savetxt(
        FOLDER / name, table, fmt="%.7g", delimiter=",", header=",".join(header), comments=""
    )


def write_case(
    name: str, log: str, fit: dict[str, Any], within_percent: float, truth: dict[str, Any]
) -> None:
    some = slice(7, None, len(truth["t"]) // 12)
    states = {key: np.round(truth[key][some], 6).tolist() for key in ("q", "dq", "ddq", "tau")}
    model = torquewise.fit(FOLDER / log, progress=False, **fit).model
    # How many friction terms of a chain are worth keeping is no truth of the arm.
    terms = {} if fit.get("library") == "chain" else {"terms": model.complexity}
    case = {"log": log, "fit": fit, **terms, "within_percent": within_percent}
    (FOLDER / f"{name}.json").write_text(json.dumps({**case, **states}, indent=1) + "\n")


def main() -> None:
    FOLDER.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        friction = Path(folder) / "friction.toml"
        friction.write_text(FRICTION)
        arm: Any = {"arm": "planar-2", "friction": friction}
        smooth = torquewise.simulate("planar-2", seconds=30, rate=50, seed=1)
        rough = torquewise.simulate(**arm, seconds=40, rate=100, seed=2)
        sines: Any = {"motion": "sines", "seconds": 10, "rate": 100, "seed": 3}
        truth, rough_truth = (
            torquewise.simulate("planar-2", **sines),
            torquewise.simulate(**arm, **sines),
        )
    write_log("smooth.csv", ("q", "dq", "ddq", "tau"), smooth)
    write_log("rough.csv", ("q", "tau"), rough)
    write_case("energy", "smooth.csv", {"library": "energy", "n_bootstrap": 0}, 0.01, truth)
    write_case("product", "smooth.csv", {"library": "product", "trig_order": 2}, 0.01, truth)
    write_case("one_shot", "smooth.csv", {"method": "sindy", "trig_order": 2}, 0.01, truth)
    write_case("chain", "rough.csv", {"library": "chain", "friction": "linear"}, 1.0, rough_truth)


if __name__ == "__main__":
    main()
