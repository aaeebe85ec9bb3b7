"""Builds and tries all that is published: crates, sources of the package, wheel.

Called by `cargo xtask package [--sources]`; with `--sources` without the wheel, which takes minutes.
What was built is in target/package/dist.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import time
import venv
import zipfile
from pathlib import Path

import notices

ROOT = notices.ROOT
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
FOLDER = TARGET / "package/python"
DIST = FOLDER / "dist"
LICENCES = ("LICENSE-MIT", "LICENSE-APACHE")
#: For a wheel that runs on any Linux with a C library of 2014 or newer.
ZIG = ["--zig", "--compatibility", "manylinux2014"] if sys.platform == "linux" else []
#: Bytes of a wheel, and seconds of a processor until its user has the first models.
LARGEST_WHEEL, LONGEST_START = 15_000_000, 20


def call(*words: object, folder: Path = ROOT, **environment: str) -> None:
    print("$", *words, flush=True)
    subprocess.run([*map(str, words)], cwd=folder, check=True, env={**os.environ, **environment})


def program(environment: Path, name: str) -> Path:
    return environment / (f"Scripts/{name}.exe" if os.name == "nt" else f"bin/{name}")


def environment(name: str, *packages: object) -> Path:
    folder = FOLDER / name
    if not program(folder, "python").exists():
        venv.create(folder, with_pip=True)
    quiet = ("--quiet", "--disable-pip-version-check")
    call(program(folder, "python"), "-m", "pip", "install", *quiet, *packages)
    return folder


def require(names: list[str], wanted: tuple[str, ...], what: object) -> None:
    missing = [own for own in wanted if not any(name.endswith("/" + own) for name in names)]
    if missing:
        sys.exit(f"{what} lacks {', '.join(missing)}")


def crates(is_whole: bool) -> None:
    """What `cargo publish` would send, each with its licences."""
    members = json.loads(notices.cargo("metadata", "--format-version", "1", "--no-deps"))
    published = [own["name"] for own in members["packages"] if own["publish"] is None]
    named = [word for name in published for word in ("--package", name)]
    quiet = ("--no-verify", "--allow-dirty", "--quiet")
    call("cargo", "package", *named, *quiet, "--offline")
    if is_whole:
        call("cargo", "publish", "--workspace", "--dry-run", *quiet)
    for name in published:
        (crate,) = (TARGET / "package").glob(f"{name}-[0-9]*.crate")
        with tarfile.open(crate) as archive:
            require(archive.getnames(), (*LICENCES, "README.md"), crate)
    print(f"{len(published)} crates")


def sources(tools: Path) -> Path:
    """The sources of the package, with those of the engine."""
    maturin = program(tools, "maturin")
    call(maturin, "sdist", "--manifest-path", "python/Cargo.toml", "--out", DIST)
    (found,) = DIST.glob("*.tar.gz")
    with tarfile.open(found) as archive:
        require(archive.getnames(), (*LICENCES, notices.FILE.name, "Cargo.lock"), found)
    print(f"{found.name}: {found.stat().st_size / 1e6:.1f} MB")
    return found


def wheel(tools: Path, archive: Path) -> Path:
    """The wheel, built outside the repository from these sources and nothing else."""
    place = FOLDER / "sources"
    shutil.rmtree(place, ignore_errors=True)
    with tarfile.open(archive) as own:
        own.extractall(place)
    (unpacked,) = place.iterdir()
    path = os.pathsep.join([str(program(tools, "python").parent), os.environ["PATH"]])
    build = (program(tools, "maturin"), "build", "--release", *ZIG, "--out", DIST)
    page = ROOT / "web/dist"  # of `cargo xtask web`
    if not page.exists():
        print("no web/dist: `torquewise serve` of this wheel has no page")
    has = {"TORQUEWISE_PAGE": str(page)} if page.exists() else {}
    call(*build, folder=unpacked, PATH=path, CARGO_TARGET_DIR=str(FOLDER / "target"), **has)
    (found,) = DIST.glob("*.whl")
    with zipfile.ZipFile(found) as own:
        require(own.namelist(), (*LICENCES, notices.FILE.name, "py.typed", "_core.pyi"), found)
    size = found.stat().st_size
    print(f"{found.name}: {size / 1e6:.1f} MB")
    if size > LARGEST_WHEEL:
        sys.exit(f"{found.name} has {size} bytes, at most {LARGEST_WHEEL} are allowed")
    call(program(tools, "abi3audit"), "--strict", found)
    return found


def try_out(found: Path) -> None:
    """The wheel in an environment of its own: the program of its README, and the command line."""
    shutil.rmtree(FOLDER / "bare", ignore_errors=True)
    shutil.rmtree(FOLDER / "work", ignore_errors=True)
    (FOLDER / "work").mkdir()
    begun, used = time.monotonic(), sum(os.times()[2:4])
    bare = environment("bare", found)
    (lines,) = re.findall(
        r"^```python\n(.*?)^```", (ROOT / "python/README.md").read_text("utf-8"), re.S | re.M
    )
    (FOLDER / "work/readme.py").write_text(lines, encoding="utf-8")
    call(program(bare, "python"), "readme.py", folder=FOLDER / "work")
    command = program(bare, "torquewise")
    simulated = ("simulate", "planar-2", "-o", "log.csv", "--seconds", "60", "--rate", "100")
    call(command, *simulated, folder=FOLDER / "work")
    call(command, "fit", "log.csv", "-o", "model.json", folder=FOLDER / "work")
    seconds = time.monotonic() - begun
    # The clock counts what others do on the machine too, but Windows tells no processor time.
    busy = sum(os.times()[2:4]) - used or seconds
    print(f"installed and used in {seconds:.1f} s, {busy:.1f} s of a processor")
    if busy > LONGEST_START:
        sys.exit(f"that takes longer than {LONGEST_START} s")


def main() -> None:
    shutil.rmtree(DIST, ignore_errors=True)
    is_whole = "--sources" not in sys.argv[1:]
    notices.main()
    crates(is_whole)
    needs = ["maturin>=1.9,<2", "twine"]
    tools = environment("tools", *needs, *(["ziglang", "abi3audit"] if is_whole else []))
    archive = sources(tools)
    found = wheel(tools, archive) if is_whole else None
    call(program(tools, "twine"), "check", "--strict", *sorted(DIST.iterdir()))
    if found:
        try_out(found)


if __name__ == "__main__":
    main()
