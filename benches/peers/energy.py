"""The energy library: columns that all joints share, from the functions in M(q) and V(q)."""

import json
from functools import reduce

import numpy as np
from trial import nrmse


def library(file):
    return [weighted["term"] for weighted in json.loads(file.read_text())["form"]["energy"]]


def columns(terms, q, dq, ddq):
    """Torque of each term per unit of its coefficient: (joints x rows) x terms, joint by joint."""
    m, n = q.shape
    out = np.zeros((n * m, len(terms)), order="F")
    waves = {}

    def wave(multiples):
        key = tuple(multiples)
        if key not in waves:
            angle = q @ np.array(multiples, dtype=float)
            waves[key] = np.cos(angle), np.sin(angle)
        return waves[key]

    def part(factor):
        cos, sin = wave(factor["multiples"])
        return (cos, -sin) if factor["function"] == "cos" else (sin, cos)

    for place, term in enumerate(terms):
        factors = term["function"]["factors"]
        parts = [part(factor) for factor in factors]
        product = lambda turned: reduce(
            np.multiply, (p[i == turned] for i, p in enumerate(parts)), np.ones(m)
        )
        slopes = {}
        for i, factor in enumerate(factors):
            for joint, multiple in enumerate(factor["multiples"]):
                if multiple:
                    slopes[joint] = slopes.get(joint, 0) + multiple * product(i)
        load = out[:, place].reshape(n, m)
        if term["place"] == "potential":
            for joint, slope in slopes.items():
                load[joint] = slope
            continue
        a, b = term["place"]["inertia"]
        share = 0.5 if a == b else 1.0
        change = sum((slope * dq[:, joint] for joint, slope in slopes.items()), np.zeros(m))
        for joint, slope in slopes.items():
            load[joint] -= share * slope * dq[:, a] * dq[:, b]
        value = product(None)
        for own, other in ((a, b), (b, a)):
            load[own] += share * (change * dq[:, other] + value * ddq[:, other])
    return out


def stacked(tau, spread):
    """Responses joint by joint, each divided by its spread."""
    return (tau / spread).T.ravel()


def divide(columns, spread):
    """Rows divided by the spread of their joint, in place."""
    m = len(columns) // len(spread)
    for joint, size in enumerate(spread):
        columns[joint * m : (joint + 1) * m] /= size


def judged(ways, terms, test):
    """Of some weights, named, those that do best on a motion: name, terms, NRMSE of each joint."""
    q, dq, ddq, tau = test
    some = np.flatnonzero(np.any([w != 0 for w in ways.values()], axis=0))
    x = columns([terms[place] for place in some], q, dq, ddq)
    joints = tau.shape[1]
    errors = {name: nrmse(tau, (x @ w[some]).reshape(joints, -1).T) for name, w in ways.items()}
    best = min(errors, key=lambda name: sum(errors[name]))
    return {"best": best, "active": int((ways[best] != 0).sum()), "errors": errors[best]}
