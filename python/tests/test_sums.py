"""Logs summed up apart."""

import pickle

import numpy as np
import pytest

import torquewise
from torquewise import Summary


def parts(log, count):
    cuts = np.array_split(np.arange(len(log["t"])), count)
    return [{key: log[key][own] for key in ("t", "q", "dq", "ddq", "tau")} for own in cuts]


def test_sums_of_parts_give_the_model_of_all_in_any_order(train):
    logs = parts(train, 3)
    sums = [Summary.of(own) for own in logs]
    forward = sums[0].merge(sums[1], sums[2]).solve()
    backward = sums[2].merge(sums[0]).merge(sums[1]).solve()

    assert forward.model == backward.model
    assert forward.model == torquewise.fit(logs, progress=False).model
    assert sums[0].merge(sums[1]).rows == 4000 and sums[0].logs == 1


def test_the_same_sums_do_not_count_twice(train):
    first, second = (Summary.of(own) for own in parts(train, 2))

    for others in ([first], [second, second], [pickle.loads(pickle.dumps(first))]):
        with pytest.raises(ValueError, match="same sums twice"):
            first.merge(*others)


def test_a_log_is_added(train):
    first, second = parts(train, 2)

    assert Summary.of(first).update(second).rows == 6000


def test_sums_are_pickled_and_checked(train):
    own = Summary.of(train)
    again = pickle.loads(pickle.dumps(own))

    assert type(again) is Summary and again.to_bytes() == own.to_bytes()
    assert again.solve().model == own.solve().model
    data = bytearray(own.to_bytes())
    data[len(data) // 2] ^= 1
    with pytest.raises(torquewise.LogError):
        Summary.from_bytes(bytes(data))


def test_a_chain_is_solved_in_rounds(train):
    logs = parts(torquewise.simulate("puma560-3", seconds=60, rate=100, case=2, seed=1), 2)
    options = {"library": "chain", "friction": "none"}
    request, rounds = None, 0
    while True:
        one, two = (Summary.of(own, request=request, **options) for own in logs)
        found = two.merge(one).solve(friction="none")
        if not isinstance(found, torquewise.Request):
            break
        request = pickle.loads(pickle.dumps(found))
        rounds += 1
        assert rounds < 6

    assert rounds >= 1
    clean = torquewise.simulate("puma560-3", motion="sines", seconds=10, rate=100, seed=5)
    assert max(found.evaluate(clean).nrmse_percent) < 2.0


def test_sums_of_other_arms_do_not_add_up(train):
    other = torquewise.simulate("puma560-3", seconds=20, rate=100)
    with pytest.raises(torquewise.FitError):
        Summary.of(train).merge(Summary.of(other))


def test_a_report_of_sums_says_why_there_is_none(train):
    with pytest.raises(torquewise.FitError, match="no rows"):
        Summary.of(train).solve().report()
