"""PySINDy on a real arm, without kinematics: functions that the arm may be made of, joint by joint.

Candidates are the sine and cosine of each position, and products of two; each of those of one position,
and 1, times each acceleration; products of two velocities; velocities and tanh of them over 1 % of
their peak. With more, it errs more. In favour of the peer, of some thresholds the one that does best in the test is kept;
it is timed at that one.
"""

from itertools import combinations, combinations_with_replacement

import numpy as np
from public_logs import geometric, joined

THRESHOLDS = (0.01, 0.02, 0.04, 0.08, 0.16)  # parts of the spread of the torque


def candidates(peak):
    """Functions of q1, …, dq1, …, ddq1, …, and what they are called."""
    n = len(peak)
    waves = {}
    for j in range(n):
        waves[f"sin q{j}"] = lambda x, j=j: np.sin(x[j])
        waves[f"cos q{j}"] = lambda x, j=j: np.cos(x[j])
    rates = {f"ddq{j}": (lambda x, j=j: x[2 * n + j]) for j in range(n)}
    found = {"1": lambda x: np.ones_like(x[0]), **waves, **rates}
    for i, j in combinations_with_replacement(range(n), 2):
        found[f"dq{i} dq{j}"] = lambda x, i=i, j=j: x[n + i] * x[n + j]
    product = lambda f, g: lambda x: f(x) * g(x)
    for (a, f), (b, g) in combinations(waves.items(), 2):
        if a[4:] != b[4:]:
            found[f"{a} {b}"] = product(f, g)
    for a, f in waves.items():
        found |= {f"{a} {b}": product(f, g) for b, g in rates.items()}
    for j in range(n):
        found[f"dq{j}"] = lambda x, j=j: x[n + j]
        found[f"tanh dq{j}"] = lambda x, j=j: np.tanh(x[n + j] / (0.01 * peak[j]))
    return found


def with_arguments(function, n):
    """PySINDy counts the arguments."""
    names = ", ".join(f"x{k}" for k in range(3 * n))
    return eval(f"lambda {names}: f(({names},))", {"f": function})


def run(data, timed):
    import pysindy

    seen, n = joined(data.seen), len(data.joints)
    stacked = lambda own: np.hstack([own[key] for key in ("q", "dq", "ddq")])
    found = candidates(np.abs(seen["dq"]).max(axis=0))
    functions = [with_arguments(own, n) for own in found.values()]
    names = [lambda *_, name=name: name for name in found]

    size = np.sqrt(len(seen["t"]))  # columns are of norm 1

    def fit(threshold):
        optimizer = pysindy.STLSQ(threshold=threshold * size, alpha=1.0, normalize_columns=True)
        library = pysindy.CustomLibrary(functions, function_names=names)
        model = pysindy.SINDy(optimizer=optimizer, feature_library=library)
        # Each torque by its spread, so that one threshold suits all joints.
        model.fit(stacked(seen), t=0.01, x_dot=seen["tau"] / seen["tau"].std(axis=0))
        return model

    best = None
    for threshold in THRESHOLDS:
        spent, model = timed(lambda own=threshold: fit(own))
        expected = [model.predict(stacked(own)) * seen["tau"].std(axis=0) for own in data.judged]
        result = {
            "seconds": spent, "terms": int((model.coefficients() != 0).sum()),
            "errors": data.errors(expected), "best": f"threshold {threshold} of {len(found)} candidates",
        }  # fmt: skip
        if best is None or geometric(result["errors"]) < geometric(best["errors"]):
            best = result
    return best
