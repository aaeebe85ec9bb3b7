"""One peer at one task on the rows of `cargo bench --bench peers`: seconds, memory, what it found.

    python peer.py FOLDER TASK PEER

Every peer runs in a process of its own, and prints one JSON object: seconds by the clock and of all
processors, and the peak of its memory in MB.
"""

import json
import resource
import sys
import warnings
from pathlib import Path

import energy
import numpy as np
from trial import GAP, candidates, evaluated, lasso, nrmse, path_gap, rows, sindy, timed

warnings.filterwarnings("ignore")
JOINT = 1  # the joint that the LASSO explains


def library(peer, folder, size="3612"):
    """The library of SINDy, whole or of a lower order."""
    *signals, tau = rows(folder / "rows.f64")
    signals, functions = np.hstack(signals), candidates(folder / f"terms{size}.txt")
    if peer == "pysindy":
        # From the rows to the weights, as ours: the library is evaluated, too.
        model = sindy(functions)
        spent, _ = timed(lambda: model.fit(signals, t=0.01, x_dot=tau))
        return {"seconds": spent, "active": int((model.coefficients() != 0).sum())}
    spent, x = timed(lambda: evaluated(functions, signals))
    found = {"library_seconds": spent}
    if peer == "lstsq":
        found["seconds"], w = timed(lambda: np.linalg.lstsq(x, tau, rcond=None)[0])
        return {**found, "lstsq_rms": np.sqrt(((tau - x @ w) ** 2).mean(axis=0)).tolist()}
    lambdas = np.fromfile(folder / "lambdas.f64")
    size, y = np.sqrt((x**2).mean(axis=0)), tau[:, JOINT].copy()
    if peer == "check":
        ours = np.fromfile(folder / "ours_lstsq.f64").reshape(tau.shape[1], -1).T
        w = np.fromfile(folder / "ours_lasso.f64").reshape(len(lambdas), -1) * size
        rms = np.sqrt(((tau - x @ ours) ** 2).mean(axis=0)).tolist()
        return {"lstsq_rms": rms, "gap": path_gap(x / size, y, w, lambdas)}
    scaled = np.asfortranarray(x / size)
    found["seconds"], w = timed(lambda: lasso(peer, scaled, y, lambdas))
    return {**found, "gap": path_gap(scaled, y, w, lambdas)}


def steps(peer, folder):
    """The paper's method: three regressions in turn, the patterns given."""
    assert peer == "pysindy"
    *signals, tau = rows(folder / "steps.f64")
    signals = np.hstack(signals)
    patterns = np.fromfile(folder / "steps_patterns.f64").astype(int)
    models = [sindy(candidates(folder / f"step{k}.txt")) for k in (1, 2, 3)]

    def reconstruct():
        left = tau.copy()
        for k, model in enumerate(models):
            own = patterns == k
            model.fit(signals[own], t=0.01, x_dot=left[own])
            if (patterns > k).any():
                left[patterns > k] -= model.predict(signals[patterns > k])

    spent, _ = timed(reconstruct)
    *signals, tau = rows(folder / "steps_test.f64")
    found = sum(model.predict(np.hstack(signals)) for model in models)
    active = int(sum((model.coefficients() != 0).sum() for model in models))
    return {"seconds": spent, "active": active, "errors": nrmse(tau, found)}


def energy_library(peer, folder, task, joints):
    """One regression of all joints: least squares, or the path of a LASSO."""
    q, dq, ddq, tau = rows(folder / f"{task}.f64", joints)
    spread = tau.std(axis=0)
    y, terms = energy.stacked(tau, spread), energy.library(folder / f"{task}.json")
    spent, x = timed(lambda: energy.columns(terms, q, dq, ddq))
    energy.divide(x, spread)
    found = {"library_seconds": spent, "candidates": len(terms)}
    if peer == "lstsq":
        found["seconds"], w = timed(lambda: np.linalg.lstsq(x, y, rcond=None)[0])
        weights = w[None]
    else:
        size = np.sqrt((x**2).mean(axis=0))
        x /= size
        if joints == 3:
            lambdas, tol = np.fromfile(folder / f"{task}_lambdas.f64"), GAP
        else:
            most = np.abs(x.T @ y).max() / len(y)
            lambdas, tol = np.geomspace(most, 1e-4 * most, 30), 1e-4
        found["seconds"], w = timed(lambda: lasso(peer, x, y, lambdas, tol))
        found["gap"] = path_gap(x, y, w, lambdas)
        weights = w / size
    q, dq, ddq, tau = rows(folder / f"{task}_test.f64", joints)
    some = np.flatnonzero((weights != 0).any(axis=0))
    x = energy.columns([terms[place] for place in some], q, dq, ddq)
    tests = [nrmse(tau, (x @ w[some]).reshape(joints, -1).T) for w in weights]
    # In favour of the peer: of its penalties, the one that does best in the test.
    best = int(np.argmin([np.log(errors).sum() for errors in tests]))
    return {**found, "active": int((weights[best] != 0).sum()), "errors": tests[best]}


def many(peer, folder, repeats):
    """Time over rows, 196 candidates: the same 10 000 rows again and again."""
    *signals, tau = rows(folder / "many.f64")
    functions = candidates(folder / "many.txt")
    signals = np.tile(np.hstack(signals), (repeats, 1))
    tau = np.tile(tau, (repeats, 1))
    if peer == "pysindy":
        model = sindy(functions)
        return {"seconds": timed(lambda: model.fit(signals, t=0.01, x_dot=tau))[0]}
    solve = lambda: np.linalg.lstsq(evaluated(functions, signals), tau, rcond=None)
    return {"seconds": timed(solve)[0]}


def run(task, peer, folder):
    if task == "library":
        return library(peer, folder)
    if task.startswith("candidates"):
        return library(peer, folder, task.removeprefix("candidates"))
    if task == "steps":
        return steps(peer, folder)
    if task.startswith("energy"):
        return energy_library(peer, folder, task, int(task[-1]))
    return many(peer, folder, int(task.removeprefix("rows")) // 10_000)


if __name__ == "__main__":
    found = run(sys.argv[2], sys.argv[3], Path(sys.argv[1]))
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(json.dumps({**found, "memory_mb": memory}))
