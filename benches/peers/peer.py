"""One peer on the rows of `cargo bench --bench peers`: seconds, memory and weights.

    python peer.py FOLDER PEER

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


def candidate(line):
    """A candidate that torquewise was offered, as a function of the columns of q, dq and ddq."""
    factors = [
        ([int(k) for k in multiples.split(",")], getattr(np, function.lower()), int(power))
        for multiples, function, power in FACTOR.findall(line)
    ]
    powers = re.search(r" dq: \[([^\]]*)\], ddq: \[([^\]]*)\]", line).groups()
    powers = [int(k) for part in powers for k in part.split(",")]

    # PySINDy counts the arguments.
    def value(q1, q2, q3, dq1, dq2, dq3, ddq1, ddq2, ddq3):
        column = np.ones_like(q1)
        for multiples, function, power in factors:
            angle = sum(k * q for k, q in zip(multiples, (q1, q2, q3)))
            column = column * function(angle) ** power
        for x, power in zip((dq1, dq2, dq3, ddq1, ddq2, ddq3), powers):
            column = column * x**power if power else column
        return column

    return value


def candidates(folder):
    return [candidate(line) for line in (folder / "terms.txt").read_text().splitlines()]


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
    signals, functions = np.hstack([q, rates]), candidates(folder)
    if peer == "pysindy":
        return sindy(functions, signals, tau)
    columns = np.ascontiguousarray(signals.T)
    evaluated, x = timed(lambda: np.stack([f(*columns) for f in functions]).T)
    if peer == "check":
        ours = np.fromfile(folder / "ours_lstsq.f64").reshape(JOINTS, -1).T
        lambdas = np.fromfile(folder / "lambdas.f64")
        size = np.sqrt((x**2).mean(axis=0))
        weights = np.fromfile(folder / "ours_lasso.f64").reshape(len(lambdas), -1) * size
        found = {"lstsq_rms": np.sqrt(((tau - x @ ours) ** 2).mean(axis=0)).tolist()}
        found["gap"] = path_gap(x / size, tau[:, JOINT], weights, lambdas)
        return {}, found
    found = {"library_seconds": evaluated}
    if peer == "lstsq":
        work = lambda: np.linalg.lstsq(x, tau, rcond=None)[0]
        after = lambda w: {"lstsq_rms": np.sqrt(((tau - x @ w) ** 2).mean(axis=0)).tolist()}
    else:
        lambdas = np.fromfile(folder / "lambdas.f64")
        scaled = np.asfortranarray(x / np.sqrt((x**2).mean(axis=0)))
        y = tau[:, JOINT].copy()
        work = lambda: lasso(peer, scaled, y, lambdas)
        after = lambda w: {"gap": path_gap(scaled, y, w, lambdas)}
    spent, done = timed(work)
    return {"seconds": spent}, {**found, **after(done)}


def sindy(functions, signals, tau):
    """From the rows to the weights, as ours: the library is evaluated, too."""
    import pysindy

    names = [lambda *_, place=place: f"f{place}" for place in range(len(functions))]
    model = pysindy.SINDy(
        optimizer=pysindy.STLSQ(threshold=0.1, alpha=0.05),
        feature_library=pysindy.CustomLibrary(functions, function_names=names),
    )
    spent, _ = timed(lambda: model.fit(signals, t=0.01, x_dot=tau))
    return {"seconds": spent}, {"active": int((model.coefficients() != 0).sum())}


def timed(work):
    clock, processors = time.perf_counter(), time.process_time()
    done = work()
    return [time.perf_counter() - clock, time.process_time() - processors], done


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
