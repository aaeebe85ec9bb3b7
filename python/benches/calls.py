"""What a call from Python costs, beside PySINDy; and the memory of a fit to arrays.

pip install ./python pysindy
python python/benches/calls.py
"""

import resource
import timeit
import warnings

import numpy as np

import torquewise

ROWS = 6_000_000
SOME = 200_000


def microseconds(call, number):
    return 1e6 * min(timeit.repeat(call, number=number, repeat=7)) / number


def peak():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def pysindy(train):
    """The torque of the same arm as a sum of products of degree 3, and one row of it."""
    import pysindy as ps

    warnings.filterwarnings("ignore")

    def factors(log):
        return np.hstack([np.sin(log["q"]), np.cos(log["q"]), log["dq"], log["ddq"]])

    model = ps.SINDy(
        optimizer=ps.STLSQ(threshold=0.1), feature_library=ps.PolynomialLibrary(degree=3)
    )
    model.fit(factors(train), t=0.01, x_dot=train["tau"])
    row = factors(train)[:1]
    return microseconds(lambda: model.predict(row), 200)


def main():
    train = torquewise.simulate("planar-2", seconds=60, rate=100, case=2, seed=1)
    model = torquewise.fit(train, progress=False).model
    q, dq, ddq = (train[key][100] for key in ("q", "dq", "ddq"))
    one = microseconds(lambda: model.torque(q, dq, ddq), 50_000)
    rows = [np.repeat(own[None], SOME, axis=0) for own in (q, dq, ddq)]
    arithmetic = microseconds(lambda: model.torque(*rows, follow=False), 1) / SOME
    add = microseconds(lambda: np.add(q, dq), 50_000)
    print(f"torque at one state          {one:8.2f} µs")
    print(f"the same in {SOME} rows    {arithmetic:8.2f} µs a row")
    print(f"numpy.add of two numbers     {add:8.2f} µs")
    try:
        print(f"PySINDy predict of one row   {pysindy(train):8.2f} µs")
    except ImportError:
        print("PySINDy is not installed")
    t = np.arange(ROWS) / 100.0
    log = {"t": t}
    for key in ("q", "dq", "ddq", "tau"):
        log[key] = np.empty((ROWS, 2))
    phases = np.array([0.31, 0.47])
    for first in range(0, ROWS, SOME):
        part = slice(first, first + SOME)
        angle = np.outer(t[part], phases)
        log["q"][part] = np.sin(angle) + 0.5 * np.sin(2.3 * angle)
        log["dq"][part] = phases * (np.cos(angle) + 1.15 * np.cos(2.3 * angle))
        log["ddq"][part] = -(phases**2) * (np.sin(angle) + 2.645 * np.sin(2.3 * angle))
        state = [log[key][part] for key in ("q", "dq", "ddq")]
        log["tau"][part] = model.torque(*state, follow=False)
    arrays = sum(own.nbytes for own in log.values()) / 2**20
    before = peak()
    seconds = torquewise.fit(log, library="energy", progress=False).seconds
    print(
        f"{ROWS} rows in arrays of {arrays:.0f} MiB: peak {before:.0f} MiB before a fit, {peak():.0f} after it, {seconds:.1f} s"
    )


if __name__ == "__main__":
    main()
