"""One peer on the rows of `cargo bench --bench peers`: seconds, memory and weights.

    python peer.py FOLDER PEER [CANDIDATES]

Every peer runs in a process of its own, and prints one JSON object: seconds by the clock and of all
processors, and the peak of its memory in MB.
"""

import json
import re
import resource
import sys
import time
import warnings
from pathlib import Path

import numpy as np

warnings.filterwarnings("ignore")
JOINTS = 3
JOINT = 1  # the joint that the LASSO explains
GAP = 1e-5  # of the mean square of the torque
FACTOR = re.compile(r"Factor \{ multiples: \[([^\]]*)\], function: (\w+), power: (\d+) \}")


def rows(folder):
    values = np.fromfile(folder / "rows.f64").reshape(4 * JOINTS, -1).T
    q, dq, ddq, tau = np.split(values, 4, axis=1)
    return q, np.hstack([dq, ddq]), tau


def library(folder, q, x):
    """The candidates that torquewise was offered, column by column."""
    columns = []
    for line in (folder / "terms.txt").read_text().splitlines():
        column = np.ones(len(q))
        for multiples, function, power in FACTOR.findall(line):
            angle = q @ np.array([int(k) for k in multiples.split(",")])
            column *= getattr(np, function.lower())(angle) ** int(power)
        powers = re.search(r" dq: \[([^\]]*)\], ddq: \[([^\]]*)\]", line).groups()
        for j, power in enumerate(int(k) for part in powers for k in part.split(",")):
            column *= x[:, j] ** power
        columns.append(column)
    return np.asfortranarray(np.column_stack(columns))


def gap(x, y, w, alpha):
    """Duality gap of ½/m ‖y − X w‖² + α ‖w‖₁."""
    m = len(y)
    rest = y - x @ w
    scale = min(1.0, alpha * m / max(np.abs(x.T @ rest).max(), 1e-300))
    primal = rest @ rest / (2 * m) + alpha * np.abs(w).sum()
    dual = (y @ y - (y - scale * rest) @ (y - scale * rest)) / (2 * m)
    return primal - dual


def path_gap(x, y, weights, lambdas):
    return max(gap(x, y, w, a) for w, a in zip(weights, lambdas)) / (y @ y / len(y))


def run(peer, folder):
    q, rates, tau = rows(folder)
    x = library(folder, q, rates)
    if peer == "check":
        ours = np.fromfile(folder / "ours_lstsq.f64").reshape(JOINTS, -1).T
        lambdas = np.fromfile(folder / "lambdas.f64")
        size = np.sqrt((x**2).mean(axis=0))
        weights = np.fromfile(folder / "ours_lasso.f64").reshape(len(lambdas), -1) * size
        found = {"lstsq_rms": np.sqrt(((tau - x @ ours) ** 2).mean(axis=0)).tolist()}
        found["gap"] = path_gap(x / size, tau[:, JOINT], weights, lambdas)
        return {}, found
    found, work = {}, None
    if peer == "pysindy":
        import pysindy

        optimizer = pysindy.STLSQ(threshold=0.1, alpha=0.05)
        work = lambda: optimizer.fit(x, tau)
        after = lambda _: {"active": int((optimizer.coef_ != 0).sum())}
    elif peer == "lstsq":
        work = lambda: np.linalg.lstsq(x, tau, rcond=None)[0]
        after = lambda w: {"lstsq_rms": np.sqrt(((tau - x @ w) ** 2).mean(axis=0)).tolist()}
    else:
        lambdas = np.fromfile(folder / "lambdas.f64")
        scaled = np.asfortranarray(x / np.sqrt((x**2).mean(axis=0)))
        y = tau[:, JOINT].copy()
        work = lambda: lasso(peer, scaled, y, lambdas)
        after = lambda w: {"gap": path_gap(scaled, y, w, lambdas)}
    clock, processors = time.perf_counter(), time.process_time()
    done = work()
    spent = [time.perf_counter() - clock, time.process_time() - processors]
    return {"seconds": spent}, {**found, **after(done)}


def lasso(peer, x, y, lambdas):
    """Weights at each penalty, penalties × columns."""
    # Looser stops end above the gap asked for, so each is set to reach it.
    if peer == "celer":
        from celer import celer_path

        return celer_path(x, y, pb="lasso", alphas=lambdas, tol=GAP, max_iter=200)[1].T
    if peer == "sklearn":
        from sklearn.linear_model import lasso_path

        found = lasso_path(x, y, alphas=lambdas, precompute=True, tol=GAP, max_iter=100_000)
        return found[1].T
    if peer == "lars":
        from sklearn.linear_model import lars_path_gram

        gram, cross = x.T @ x, x.T @ y
        alphas, _, weights = lars_path_gram(
            cross, gram, n_samples=len(y), method="lasso", alpha_min=lambdas[-1], max_iter=5_000
        )
        places = [np.interp(a, alphas[::-1], np.arange(len(alphas))[::-1]) for a in lambdas]
        low = np.floor(places).astype(int)
        high = np.minimum(low + 1, len(alphas) - 1)
        part = np.array(places) - low
        return (weights[:, low] * (1 - part) + weights[:, high] * part).T
    if peer == "skglm":
        from skglm import Lasso

        model = Lasso(fit_intercept=False, warm_start=True)
        weights = []
        for alpha in lambdas:
            model.alpha = alpha
            model.tol = 1e-2 * alpha
            weights.append(model.fit(x, y).coef_.copy())
        return np.array(weights)
    raise SystemExit(f"no peer {peer}")


if __name__ == "__main__":
    times, found = run(sys.argv[2], Path(sys.argv[1]))
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(json.dumps({**times, "memory_mb": memory, **found}))
