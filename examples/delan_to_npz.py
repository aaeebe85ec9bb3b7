"""Character trajectories of Deep Lagrangian Networks (a pickle) -> one .npz per trajectory.

    pip install numpy dill
    python examples/delan_to_npz.py character_data.pickle FOLDER

Unpickle only files you trust. `m`, `c` and `g` are the true parts of the torque.
"""

import pathlib
import sys

import dill
import numpy


def main(source: str, target: str) -> None:
    folder = pathlib.Path(target)
    folder.mkdir(parents=True, exist_ok=True)
    with open(source, "rb") as file:
        data = dill.load(file)
    for place, label in enumerate(data["labels"]):
        of = lambda key, place=place: numpy.asarray(data[key][place], dtype=float)
        numpy.savez(
            folder / f"{place:02}-{label}.npz",
            t=of("t"),
            q=of("qp"),
            dq=of("qv"),
            ddq=of("qa"),
            tau=of("tau"),
            m=of("m"),
            c=of("c"),
            g=of("g"),
        )


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2])
