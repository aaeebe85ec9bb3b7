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


def evaluated(file, q, dq, ddq):
    """The library over the rows: every wave and every product of rates once."""
    lines, rates, known = file.read_text().splitlines(), np.hstack([dq, ddq]), {}
    out = np.empty((len(q), len(lines)), order="F")

    def once(key, work):
        if key not in known:
            known[key] = work()
        return known[key]

    def wave(multiples, function):
        return getattr(np, function.lower())(q @ [float(k) for k in multiples.split(",")])

    def monomial(powers):
        some = [rates[:, j] ** k if k > 1 else rates[:, j] for j, k in enumerate(powers) if k]
        return np.prod(some, axis=0) if some else np.ones(len(q))

    for place, line in enumerate(lines):
        parts = re.search(r" dq: \[([^\]]*)\], ddq: \[([^\]]*)\]", line).groups()
        powers = tuple(int(k) for part in parts for k in part.split(","))
        column = once(powers, lambda: monomial(powers))
        for factor in FACTOR.findall(line):
            value = once(factor[:2], lambda: wave(*factor[:2]))
            column = column * (value if factor[2] == "1" else value ** int(factor[2]))
        out[:, place] = column
    return out


def timed(work):
    """Seconds by the clock and of all processors, and what the work gave; the median if short."""
    runs = []
    while not runs or (len(runs) < 5 and runs[0][0] < 0.5):
        clock, processors = time.perf_counter(), time.process_time()
        done = work()
        runs.append([time.perf_counter() - clock, time.process_time() - processors])
    return sorted(runs)[len(runs) // 2], done


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


def sindy(functions, threshold=0.1):
    import pysindy

    names = [lambda *_, place=place: f"f{place}" for place in range(len(functions))]
    return pysindy.SINDy(
        optimizer=pysindy.STLSQ(threshold=threshold, alpha=0.05),
        feature_library=pysindy.CustomLibrary(functions, function_names=names),
    )


def lasso(peer, tol=GAP):
    """A function of columns, response and penalties: weights, penalties x columns."""
    path = {"celer": celer, "sklearn": sklearn, "lars": lars, "skglm": skglm}[peer](tol)
    # What is imported or compiled when first asked for is no part of the work.
    small = np.random.default_rng(1).normal(size=(50, 5))
    path(np.asfortranarray(small), small[:, 0] + 0.1 * small[:, 1], np.array([0.1, 0.05]))
    return path


# Looser stops end above the gap asked for, so each is set to reach it.
def celer(tol):
    from celer import celer_path

    return lambda x, y, lambdas: (
        celer_path(x, y, pb="lasso", alphas=lambdas, tol=tol, max_iter=1_000)[1].T
    )


def sklearn(tol):
    from sklearn.linear_model import lasso_path

    return lambda x, y, lambdas: (
        lasso_path(x, y, alphas=lambdas, precompute=True, tol=tol, max_iter=100_000)[1].T
    )


def lars(_):
    from sklearn.linear_model import lars_path_gram

    def path(x, y, lambdas):
        gram, cross = x.T @ x, x.T @ y
        alphas, _, weights = lars_path_gram(
            cross, gram, n_samples=len(y), method="lasso", alpha_min=lambdas[-1], max_iter=5_000
        )
        places = [np.interp(a, alphas[::-1], np.arange(len(alphas))[::-1]) for a in lambdas]
        low = np.floor(places).astype(int)
        high = np.minimum(low + 1, len(alphas) - 1)
        part = np.array(places) - low
        return (weights[:, low] * (1 - part) + weights[:, high] * part).T

    return path


def skglm(_):
    from skglm import Lasso

    def path(x, y, lambdas):
        model, weights = Lasso(fit_intercept=False, warm_start=True), []
        for alpha in lambdas:
            model.alpha = alpha
            model.tol = 1e-2 * alpha
            weights.append(model.fit(x, y).coef_.copy())
        return np.array(weights)

    return path
