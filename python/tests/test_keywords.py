"""Keywords are listed once: signatures, help, types and the engine name the same."""

import inspect
import pickle
import pydoc
import re
import typing

import numpy as np
import pandas as pd
import pytest

import torquewise
from torquewise import FitOptions, LogOptions, Model, Summary, plot

WORDS = {
    name: typing.get_args(typing.get_args(eval(kind.__forward_arg__, vars(typing)))[0])
    for name, kind in FitOptions.__annotations__.items()
    if kind.__forward_arg__.startswith("Literal") and name != "filter"
}


def test_help_shows_every_keyword():
    text = pydoc.plain(pydoc.render_doc(torquewise.fit))

    for name in FitOptions.__annotations__:
        assert re.search(rf"^    {name}\b|, {name}\b|\b{name}: ", text, re.M), name
    assert "library: \"Literal['energy', 'product', 'chain'] | None\"" in text or (
        "library: Literal['energy', 'product', 'chain'] | None" in text
    )


@pytest.mark.parametrize(
    "function, options",
    [
        (torquewise.fit, FitOptions),
        (torquewise.compare, FitOptions),
        (Summary.of, FitOptions),
        (torquewise.read_log, LogOptions),
        (torquewise.inspect, LogOptions),
        (torquewise.patterns, LogOptions),
        (torquewise.contacts, LogOptions),
        (Model.evaluate, LogOptions),
        (Model.predict, LogOptions),
        (plot.torque, LogOptions),
    ],
)
def test_signatures_name_each_option(function, options):
    parameters = inspect.signature(function).parameters

    assert options.__annotations__.keys() <= parameters.keys()
    kinds = {own.kind for own in parameters.values()}
    assert inspect.Parameter.VAR_KEYWORD not in kinds
    assert all(parameters[name].kind.name == "KEYWORD_ONLY" for name in options.__annotations__)
    # What read_log itself takes has the same usual values.
    usual = inspect.signature(torquewise.read_log).parameters
    for name, own in parameters.items():
        if name in options.__annotations__:
            assert own.default == (usual[name].default if name in usual else None)


@pytest.mark.parametrize("name", WORDS)
def test_words_are_those_of_the_engine(name, train):
    with pytest.raises(ValueError) as caught:
        torquewise.fit(train, **{name: "magic"}, progress=False)

    told = str(caught.value).partition("expected one of ")[2].split("\n")[0]
    assert told.split(", ") == list(WORDS[name])


def test_every_option_of_the_package_is_one_of_the_engine(train):
    with pytest.raises(torquewise.UsageError, match="librari"):
        torquewise.fit(train, librari="chain")
    for name in FitOptions.__annotations__.keys() - LogOptions.__annotations__.keys():
        with pytest.raises((ValueError, TypeError, torquewise.TorquewiseError)) as caught:
            torquewise.fit(train, **{name: object()})
        assert "no option" not in str(caught.value), name


def test_results_are_frames(fit, test, train):
    found = fit.evaluate(test)
    frame = found.to_frame()
    assert list(frame.index) == found.joints
    assert np.array_equal(frame["nrmse_percent"], found.nrmse_percent)

    labels = torquewise.patterns(train)
    assert labels.inertia.dtype == np.float64 and labels.inertia.ndim == 1
    assert labels.to_frame()["pattern"].value_counts().to_dict() == labels.counts

    contacts = torquewise.contacts(fit.model, test, filter="none")
    assert isinstance(contacts.to_frame(), pd.DataFrame)
    assert list(contacts.to_frame()) == ["begin", "end", "joint", "torque", "factor"]


def test_a_log_of_files_is_pickled_and_one_of_arrays_says_why_not(tmp_path, train):
    path = tmp_path / "log.csv"
    torquewise.write_log(path, train)
    log = torquewise.read_log(path, filter=8.0)

    again = pickle.loads(pickle.dumps(log))

    assert again.files == log.files and again.is_filtered
    with pytest.raises(TypeError, match="read_log where they arrive"):
        pickle.dumps(torquewise.read_log(train))
