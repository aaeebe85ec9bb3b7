"""What all tasks share: rows, candidates, times, the duality gap of a LASSO."""

import re
import time

import numpy as np

GAP = 1e-5  # of the mean square of the torque
FACTOR = re.compile(r"Factor \{ multiples: \[([^\]]*)\], function: (\w+), power: (\d+) \}")


def rows(file, joints=3):
    """q, dq, ddq, tau, each rows x joints."""
    values = np.fromfile(file).reshape(4 * joints, -1).T
    return np.split(values, 4, axis=1)


def candidates(file):
    return [candidate(line) for line in file.read_text().splitlines()]


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


def evaluated(functions, signals):
    columns = np.ascontiguousarray(signals.T)
    return np.stack([f(*columns) for f in functions]).T


def timed(work):
    """Seconds by the clock and of all processors, and what the work gave."""
    clock, processors = time.perf_counter(), time.process_time()
    done = work()
    return [time.perf_counter() - clock, time.process_time() - processors], done


def nrmse(tau, found):
    """In percent of the spread of each joint."""
    return (100 * np.sqrt(((tau - found) ** 2).mean(axis=0)) / tau.std(axis=0)).tolist()


def gap(x, y, w, alpha):
    """Duality gap of 1/2m ||y - X w||^2 + alpha ||w||_1."""
    m = len(y)
    rest = y - x @ w
    scale = min(1.0, alpha * m / max(np.abs(x.T @ rest).max(), 1e-300))
    primal = rest @ rest / (2 * m) + alpha * np.abs(w).sum()
    dual = (y @ y - (y - scale * rest) @ (y - scale * rest)) / (2 * m)
    return primal - dual


def path_gap(x, y, weights, lambdas):
    return max(gap(x, y, w, a) for w, a in zip(weights, lambdas)) / (y @ y / len(y))


def sindy(functions):
    import pysindy

    names = [lambda *_, place=place: f"f{place}" for place in range(len(functions))]
    return pysindy.SINDy(
        optimizer=pysindy.STLSQ(threshold=0.1, alpha=0.05),
        feature_library=pysindy.CustomLibrary(functions, function_names=names),
    )


def lasso(peer, x, y, lambdas, tol=GAP):
    """Weights at each penalty, penalties x columns."""
    # Looser stops end above the gap asked for, so each is set to reach it.
    if peer == "celer":
        from celer import celer_path

        return celer_path(x, y, pb="lasso", alphas=lambdas, tol=tol, max_iter=200)[1].T
    if peer == "sklearn":
        from sklearn.linear_model import lasso_path

        found = lasso_path(x, y, alphas=lambdas, precompute=True, tol=tol, max_iter=100_000)
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
