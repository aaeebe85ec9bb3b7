"""What other readers do with the mutated files that this project's readers are tried on.

Each file is read in a process of its own, with 4 GB of addresses and 20 s. Peers that are not
installed are left out.

    cargo run --release --package torquewise-fuzz -- --cases 1000 --write FOLDER
    python fuzz/peers.py FOLDER
"""

import collections
import pathlib
import resource
import subprocess
import sys

READERS = {
    "parquet": {
        "pyarrow": "import pyarrow.parquet as p; import pyarrow.dataset; p.read_table(path)",
    },
    "npz": {
        "numpy": "import numpy as n; f = n.load(path); [f[k] for k in f.files]",
    },
    "mat": {
        "scipy.io": "import scipy.io as s; s.loadmat(path)",
    },
    "db3": {
        "rosbags": "from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader as R\n"
        "from pathlib import Path\n"
        "r = R(Path(path)); r.open(); [m for m in r.messages(())]; r.close()",
    },
    "mcap": {
        "rosbags": "from rosbags.rosbag2.storage_mcap import McapReader as R\n"
        "from pathlib import Path\n"
        "r = R(Path(path)); r.open(); [m for m in r.messages(())]; r.close()",
    },
    "urdf": {
        "Pinocchio": "import pinocchio as p; p.buildModelFromUrdf(path)",
        "urdfdom": "import subprocess, os\n"
        "c = subprocess.run(['check_urdf', path], capture_output=True).returncode\n"
        "os.kill(os.getpid(), -c) if c < 0 else (sys.exit(1) if c else None)",
    },
    "csv": {
        "pandas": "import pandas; pandas.read_csv(path, comment='#')",
    },
}

#: Reads the files named on its standard input one after the other in children that share imports.
SERVER = """
import os, resource, signal, sys, time
resource.setrlimit(resource.RLIMIT_AS, (4_000_000_000,) * 2)
resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
{warm}
for line in sys.stdin:
    path = line.rstrip()
    begun = time.monotonic()
    child = os.fork()
    if child == 0:
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, 1)
        os.dup2(null, 2)
        signal.alarm(20)
        try:
            exec(READ, {{"path": path, "sys": sys}})
            os._exit(0)
        except MemoryError:
            os._exit(3)
        except BaseException:
            os._exit(1)
    _, status, usage = os.wait4(child, 0)
    code = -os.WTERMSIG(status) if os.WIFSIGNALED(status) else os.WEXITSTATUS(status)
    print(code, usage.ru_maxrss, flush=True)
"""


def warmed(code: str) -> str:
    """The imports of a reader, made once."""
    parts = [part.strip() for line in code.split("\n") for part in line.split(";")]
    return "\n".join(part for part in parts if part.startswith(("import ", "from ")))


def tried(code: str, files: list[pathlib.Path]) -> collections.Counter | None:
    """How often a reader took, refused, ran out of memory, died or waited."""
    program = f"READ = {code!r}\n" + SERVER.format(warm=warmed(code))
    listed = "\n".join(map(str, files)) + "\n"
    done = subprocess.run(
        [sys.executable, "-c", program], input=listed, capture_output=True, text=True
    )
    rows = [line.split() for line in done.stdout.splitlines()]
    if len(rows) != len(files):
        return None
    names = {0: "taken", 1: "refused", 3: "memory", -14: "over 20 s"}
    found = collections.Counter(names.get(int(code), "died") for code, _ in rows)
    found["over 1 GB"] = sum(int(kilobytes) > 1_000_000 for _, kilobytes in rows)
    return found


def main() -> None:
    folder = pathlib.Path(sys.argv[1])
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    columns = ["taken", "refused", "died", "memory", "over 20 s", "over 1 GB"]
    print("| files | reader |", " | ".join(columns), "|")
    print("|---|---|" + "---|" * len(columns))
    for ending, peers in READERS.items():
        files = sorted(folder.glob(f"*.{ending}"))
        for name, code in peers.items():
            found = tried(code, files)
            if found is not None:
                print(f"| {len(files)} {ending} | {name} |", *(f"{found[c]} |" for c in columns))


if __name__ == "__main__":
    main()
