"""Wrong inputs, each kind by each verb: every one is an error that says what is wrong, none a result."""

import datetime
import itertools

import numpy as np
import pytest

import torquewise
from torquewise import FitOptions, LogOptions, Stepwise, Summary

#: What may be raised; a panic of the engine is none of these.
REFUSED = (torquewise.TorquewiseError, ValueError, TypeError, OSError)

ROWS = 600
T = np.arange(ROWS) * 0.01
Q = np.sin(np.outer(T, [1.0, 1.7]))
GOOD = {"t": T, "q": Q, "dq": 2 * Q, "ddq": 3 * Q, "tau": 4 * Q}


def _with(name, values):
    return lambda folder: {**GOOD, name: values}


def _file(name, content):
    def make(folder):
        path = folder / name
        path.write_bytes(content)
        return path

    return make


def _put(name, place, value):
    values = GOOD[name].copy()
    values[place] = value
    return _with(name, values)


LOGS = {
    "a number": lambda folder: 3,
    "bytes": lambda folder: b"log.csv",
    "an object": lambda folder: object(),
    "an array": lambda folder: Q,
    "no logs": lambda folder: [],
    "nothing in it": lambda folder: {},
    "a set": lambda folder: {"q", "t"},
    "a file that is not there": lambda folder: folder / "missing.csv",
    "a folder": lambda folder: folder,
    "a file of nothing": _file("empty.csv", b""),
    "a header alone": _file("header.csv", b"t,q1,dq1,ddq1,tau1\n"),
    "bytes that are no text": _file("noise.csv", bytes(range(256))),
    "bytes that are no Parquet": _file("noise.parquet", bytes(range(256))),
    "bytes that are no bag": _file("noise.mcap", bytes(range(256))),
    "bytes that are no archive": _file("noise.npz", bytes(range(256))),
    "an ending that is none": _file("log.xlsx", b"t,q1\n0,0\n"),
    "words in a file": _file("words.csv", b"t,q1,dq1,ddq1,tau1\n0,a,b,c,d\n1,a,b,c,d\n"),
    "a path and a table": lambda folder: [GOOD, folder / "log.csv"],
    "two arms": lambda folder: [GOOD, {"t": T, **{k: GOOD[k][:, :1] for k in GOOD if k != "t"}}],
    "no positions": lambda folder: {"t": T, "tau": Q},
    "no time": lambda folder: {"q": Q, "tau": Q},
    "q of words": _with("q", np.full((ROWS, 2), "a")),
    "q of objects": _with("q", Q.astype(object)),
    "q of truth": _with("q", Q > 0),
    "q of complex numbers": _with("q", Q + 1j),
    "q of dates": _with("q", np.full((ROWS, 2), np.datetime64("2026-01-01"))),
    "q of Python's dates": _with("q", [[datetime.date(2026, 1, 1)] * 2] * ROWS),
    "q in three dimensions": _with("q", Q[..., None]),
    "q of one number": _with("q", 1.0),
    "q in ragged rows": _with("q", [[1.0, 2.0], [3.0]]),
    "q too short": _with("q", Q[:-1]),
    "no rows": lambda folder: {name: values[:0] for name, values in GOOD.items()},
    "one row": lambda folder: {name: values[:1] for name, values in GOOD.items()},
    "q that is not a number": _put("q", (9, 1), np.nan),
    "q without end": _put("q", (9, 1), np.inf),
    "q masked": _with("q", np.ma.array(Q, mask=Q > 0.9)),
    "tau that is not a number": _put("tau", (9, 1), np.nan),
    "tau of too many joints": _with("tau", np.hstack([Q, Q])),
    "tau of words": _with("tau", np.full((ROWS, 2), "a")),
    "dq of too few joints": _with("dq", Q[:, :1]),
    "time that goes back": _put("t", 300, 0.0),
    "time that stands": _with("t", 0.0 * T),
    "time upside down": _with("t", T[::-1]),
    "time in two columns": _with("t", np.column_stack([T, T])),
    "time of words": _with("t", [f"{t} s" for t in T]),
    "time that is not a number": _put("t", 9, np.nan),
}

VERBS = {
    "trajectories": lambda model, log: torquewise.read_log(log).trajectories(),
    "inspect": lambda model, log: torquewise.inspect(log),
    "patterns": lambda model, log: torquewise.patterns(log),
    "fit": lambda model, log: torquewise.fit(log, progress=False),
    "fit chain": lambda model, log: torquewise.fit(log, library="chain", progress=False),
    "Summary.of": lambda model, log: Summary.of(log),
    "evaluate": lambda model, log: model.evaluate(log),
    "predict": lambda model, log: model.predict(log),
    "rollout": lambda model, log: model.rollout(log),
    "contacts": lambda model, log: torquewise.contacts(model, log),
    "payload": lambda model, log: torquewise.payload(model, log),
    "gains": lambda model, log: torquewise.gains(model, log, known_mass=1.0),
    "Stepwise.fit": lambda model, log: Stepwise().fit(log),
    "plot.torque": lambda model, log: model.plot(log),
}


#: One row has a torque and a range, and an estimator knows the rate of rows without time.
FINE = {("one row", own) for own in VERBS.keys() - {"fit", "fit chain", "rollout", "contacts"}}
FINE -= {("one row", own) for own in ("payload", "gains", "Stepwise.fit")}
FINE |= {("no time", "Stepwise.fit")}


def _told(call, *arguments):
    with pytest.raises(REFUSED) as caught:
        call(*arguments)
    told = str(caught.value)
    assert 10 < len(told) < 1500, told


@pytest.mark.parametrize(
    "kind, verb", [own for own in itertools.product(LOGS, VERBS) if own not in FINE]
)
def test_a_wrong_log_is_refused(kind, verb, tmp_path, model):
    _told(VERBS[verb], model, LOGS[kind](tmp_path))


STATES = {
    "nothing": None,
    "a word": "zero",
    "words": ["a", "b"],
    "an object": object(),
    "a dict": {"q": 1.0},
    "truth": [True, False],
    "complex numbers": [1j, 0.0],
    "no number": [np.nan, 0.0],
    "without end": [np.inf, 0.0],
    "one number": 1.0,
    "too few": [1.0],
    "too many": [1.0, 2.0, 3.0],
    "ragged": [[1.0, 2.0], [1.0]],
    "three dimensions": np.zeros((1, 1, 2)),
    "masked": np.ma.array([1.0, 2.0], mask=[True, False]),
}
ZERO = [0.0, 0.0]
METHODS = {
    "torque": lambda model, x: model.torque(ZERO, x, ZERO),
    "mass_matrix": lambda model, x: model.mass_matrix(x),
    "gravity": lambda model, x: model.gravity(x),
    "coriolis": lambda model, x: model.coriolis(ZERO, x),
    "coriolis_matrix": lambda model, x: model.coriolis_matrix(x, ZERO),
    "friction": lambda model, x: model.friction(ZERO, x),
    "forward_dynamics": lambda model, x: model.forward_dynamics(ZERO, ZERO, x),
    "parts": lambda model, x: model.parts(ZERO, ZERO, x),
    "range_warnings": lambda model, x: model.range_warnings(x, ZERO, ZERO),
    "outside_range": lambda model, x: model.outside_range(x, ZERO, ZERO),
    "state": lambda model, x: model.state().step(x),
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("kind", STATES)
def test_a_wrong_state_is_refused(kind, method, model):
    _told(METHODS[method], model, STATES[kind])


VALUES = {
    "an object": object(),
    "a word": "magic",
    "a negative number": -2,
    "no number": float("nan"),
    "a list of nothing": [None],
    "a dict": {"a": 1},
}


@pytest.mark.parametrize("name", sorted(FitOptions.__annotations__.keys() - {"t", "dq", "ddq"}))
@pytest.mark.parametrize("kind", VALUES)
def test_a_wrong_option_is_refused(kind, name):
    if name in LogOptions.__annotations__:
        _told(lambda: torquewise.read_log(GOOD, **{name: VALUES[kind]}))
    else:
        _told(lambda: torquewise.fit(GOOD, progress=False, **{name: VALUES[kind]}))


def test_rows_that_are_left_out_are_named(model):
    far = _put("q", (9, 1), 1e300)(None)

    for told in (torquewise.fit(far, progress=False).warnings, model.evaluate(far).notes):
        assert any("q2 = 1e300 in row 10" in own for own in told), told
    notes = torquewise.fit(far, progress=False).notes
    assert any("left out: 1 row with a value far beyond" in own for own in notes), notes


def test_these_are_many():
    assert len(LOGS) * len(VERBS) + len(STATES) * len(METHODS) > 700
