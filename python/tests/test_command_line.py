"""The command line that comes with the package."""

import subprocess
import sys

import pytest

import torquewise


def run(*words, **options):
    command = [sys.executable, "-m", "torquewise", *words]
    return subprocess.run(command, capture_output=True, text=True, **options)


def test_it_says_its_version_and_exits_as_the_program_does():
    told = run("--version")
    assert (told.returncode, told.stdout) == (0, f"torquewise {torquewise.__version__}\n")

    failed = run("show", "missing.json")
    assert failed.returncode == 1 and "missing.json cannot be read" in failed.stderr
    wrong = run("fit", "--librari", "chain")
    assert wrong.returncode == 2 and "--library" in wrong.stderr


def test_it_gives_the_model_of_the_package_to_the_byte(tmp_path, train):
    torquewise.write_log(tmp_path / "log.csv", train)

    done = run("fit", "log.csv", "-o", "by_line.json", "--report", "page.html", cwd=tmp_path)

    assert done.returncode == 0, done.stderr
    torquewise.fit(tmp_path / "log.csv", progress=False).save(tmp_path / "by_call.json")
    assert (tmp_path / "by_line.json").read_bytes() == (tmp_path / "by_call.json").read_bytes()
    assert "torquewise fit log.csv -o by_line.json" in (tmp_path / "page.html").read_text()


def test_profiles_are_found_by_name(tmp_path):
    log = tmp_path / "log.csv"
    log.write_text("time,pos1\n0,1\n")

    with pytest.raises(
        torquewise.LogError, match="built-in profiles are delan_character, .*, ur10"
    ):
        torquewise.read_log(log, profile="ur11")
    with pytest.raises(torquewise.LogError, match="log.csv"):
        torquewise.read_log(log, profile="panda")
