"""Writes the licences of all crates that are compiled into the wheel and the command line.

Each text stands once, after the crates that carry it.
"""

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
FILE = ROOT / "python/LICENSES-THIRD-PARTY.txt"
STARTS = ("LICENSE", "LICENCE", "COPYING", "COPYRIGHT", "NOTICE", "UNLICENSE")


def cargo(*words: str) -> str:
    command = ["cargo", *words]
    return subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout


def crates() -> list[dict]:
    """What cargo knows of each crate that is not ours, by name."""
    listed = cargo(
        *("tree", "--package", "torquewise-python", "--edges", "normal"),
        *("--prefix", "none", "--format", "{p}"),
    )
    used = {tuple(line.split()[:2]) for line in listed.splitlines()}
    about = subprocess.run(["rustc", "-vV"], check=True, stdout=subprocess.PIPE, text=True).stdout
    host = about.split("host: ")[1].split()[0]
    words = ("metadata", "--format-version", "1", "--locked", "--filter-platform", host)
    known = json.loads(cargo(*words))["packages"]
    own = [
        crate
        for crate in known
        if crate["source"] and (crate["name"], "v" + crate["version"]) in used
    ]
    return sorted(own, key=lambda crate: crate["name"])


def texts(crate: dict) -> list[str]:
    folder = Path(crate["manifest_path"]).parent
    files = sorted(own for own in folder.iterdir() if own.name.upper().startswith(STARTS))
    return [
        own.read_text(encoding="utf-8", errors="replace").strip() for own in files if own.is_file()
    ]


def main() -> None:
    found: dict[str, list[str]] = {}
    lines = [
        "What others wrote and is compiled into torquewise: crates of Rust, and C in some.",
        "",
    ]
    own = crates()
    for crate in own:
        name = f"{crate['name']} {crate['version']}"
        licence = crate["license"]
        if not licence:
            sys.exit(f"{name} says no licence: ask its authors, or do without it")
        by = ", ".join(crate["authors"]) or crate["repository"] or "its authors"
        lines.append(f"{name}: {licence}, by {by}")
        for text in texts(crate):
            found.setdefault(text, []).append(name)
    for text, names in found.items():
        lines += ["", "=" * 100, ", ".join(names), "=" * 100, "", text]
    FILE.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(f"{FILE.name}: {len(own)} crates, {len(found)} texts")


if __name__ == "__main__":
    main()
