"""Keywords are listed once: signatures, help, types and the engine name the same."""

import inspect
import json
import os
import pickle
import pydoc
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import torquewise
from torquewise import FitOptions, LogOptions, Model, Summary, _core, plot


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


TYPES = {
    "whole": "int",
    "number": "float",
    "switch": "bool",
    "text": "str",
    "texts": "Sequence[str]",
}
LISTED = Path(__file__).parent.parent / "package/torquewise/_engine_options.py"


def test_options_of_the_package_are_those_of_the_engine():
    lines = [
        '"""Options of a fit that are plain values, as the engine lists them: written by its tests."""',
        "",
        "from __future__ import annotations",
        "",
        "from collections.abc import Sequence",
        "from typing import Literal, TypedDict",
        "",
        "",
        "class EngineOptions(TypedDict, total=False):",
        '    """Keywords of :func:`torquewise.fit` that are plain values."""',
        "",
    ]
    for keyword in json.loads(_core.keywords()):
        words = ", ".join(f'"{word}"' for word in keyword.get("word", []))
        kind = f"Literal[{words}]" if words else TYPES[next(k for k in keyword if k != "name")]
        lines.append(f"    {keyword['name']}: {kind} | None")
    text = "\n".join([*lines, ""])

    if os.environ.get("TORQUEWISE_WRITE_DOCUMENTS"):
        LISTED.write_text(text)
    assert LISTED.read_text() == text, "write it anew with TORQUEWISE_WRITE_DOCUMENTS=1"


def test_words_and_names_that_are_none_are_refused(train):
    with pytest.raises(ValueError, match="expected one of energy, product, chain"):
        torquewise.fit(train, library="magic", progress=False)
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
