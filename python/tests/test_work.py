"""Threads, progress, and Ctrl-C."""

import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

import torquewise


def test_fits_in_many_threads_give_one_model(train, model):
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda _: torquewise.fit(train, progress=False).model, range(8)))

    assert all(own == model for own in found)


def test_the_interpreter_runs_on_while_a_log_is_fitted():
    log = torquewise.simulate("planar-2", seconds=600, rate=100, seed=1)
    counted, done = 0, threading.Event()

    def count():
        nonlocal counted
        while not done.is_set():
            counted += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    torquewise.fit(log, progress=False)
    done.set()
    thread.join()

    assert counted > 10


def test_progress_is_told(train):
    told = []
    torquewise.fit(train, progress=lambda what, rows, total: told.append((what, rows, total)))

    assert {"reading", "clustering", "selecting terms, step 1"} <= {what for what, _, _ in told}
    assert sum(rows for what, rows, _ in told) >= 6000
    assert 6000 in {total for _, _, total in told}


def test_a_bar_shows_it(train, capsys):
    pytest.importorskip("tqdm")
    torquewise.fit(train, progress=True)

    assert "clustering" in capsys.readouterr().err


def test_an_exception_of_the_listener_ends_the_fit(train, model):
    def listener(what, rows, total):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        torquewise.fit(train, progress=listener)
    assert torquewise.fit(train, progress=False).model == model


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_ctrl_c_ends_a_fit_at_once_and_leaves_the_interpreter_usable():
    program = textwrap.dedent(
        """
        import signal, sys, time
        import torquewise

        small = torquewise.simulate("planar-2", seconds=30, rate=100)
        big = torquewise.simulate("generic-7", seconds=600, rate=100, case=2)
        print("fitting", flush=True)
        try:
            torquewise.fit(big, progress=False)
        except KeyboardInterrupt:
            print("interrupted", flush=True)
        print(torquewise.fit(small, progress=False).model.joints, flush=True)
        """
    )
    child = subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert child.stdout.readline() == "fitting\n"
    time.sleep(1.0)
    child.send_signal(signal.SIGINT)
    begin = time.monotonic()
    assert child.stdout.readline() == "interrupted\n"
    waited = time.monotonic() - begin
    out, error = child.communicate(timeout=300)

    assert out == "['joint1', 'joint2']\n" and child.returncode == 0, error
    # It is looked for every 50 ms; the machine may be busy.
    assert waited < 5.0


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize(
    "stage", ["learning the geometry", "choosing friction", "fitting all rows"]
)
def test_ctrl_c_leaves_no_engine_at_work(stage):
    program = textwrap.dedent(
        """
        import time
        import torquewise

        def told(what, rows, total):
            print(what, flush=True)

        log = torquewise.simulate("generic-7", seconds=60, rate=100, case=2)
        try:
            torquewise.fit(log, library="chain", progress=told)
        except KeyboardInterrupt:
            begin = time.process_time()
            time.sleep(3.0)
            print("worked on for", time.process_time() - begin, flush=True)
        """
    )
    child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    for told in child.stdout:
        if stage in told:
            child.send_signal(signal.SIGINT)
            break
    *_, last = child.communicate(timeout=300)[0].splitlines()

    # Half a second of two processors, counted as their time: the machine may be busy.
    assert float(last.removeprefix("worked on for ")) < 1.0
