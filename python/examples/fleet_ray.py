"""A fleet on Ray: `map_batches` sums up, and sums are merged by twos and twos.

pip install ./python 'ray[data]'
python python/examples/fleet_ray.py 'logs/*.parquet'
"""

import argparse
import glob
import pickle
import time
from typing import Any

import ray

import torquewise
from torquewise import FitOptions, Model, fleet

BATCH = 8


def fit(paths: list[str], plan: fleet.Plan) -> tuple[Model, fleet.Part]:
    """The model of all files, and what became of each."""

    def summed(request: bytes | None, known: dict[str, str]) -> fleet.Part:
        def sums(batch: dict[str, Any]) -> dict[str, list[bytes]]:
            part = fleet.summarise(list(batch["path"]), plan, request, known)
            return {"part": [pickle.dumps(part)]}

        def merged(batch: dict[str, Any]) -> dict[str, list[bytes]]:
            parts = [pickle.loads(own) for own in batch["part"]]
            return {"part": [pickle.dumps(fleet.merge(*parts))]}

        data = ray.data.from_items([{"path": path} for path in paths])
        data = data.repartition(max(1, len(paths) // BATCH)).map_batches(sums, batch_size=BATCH)
        data = data.map_batches(merged, batch_size=BATCH)
        return fleet.merge(*(pickle.loads(row["part"]) for row in data.iter_rows()))

    return fleet.rounds(summed, plan)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("logs", help="files, as a pattern")
    parser.add_argument("--address", help="of a cluster; processes of this machine without")
    parser.add_argument("--check", action="store_true", help="fit all in one process too")
    arguments = parser.parse_args()
    paths = sorted(glob.glob(arguments.logs, recursive=True))
    options: FitOptions = {"library": "chain", "friction": "linear"}
    ray.init(address=arguments.address, log_to_driver=False)
    ray.data.DataContext.get_current().enable_progress_bars = False
    begin = time.monotonic()
    model, part = fit(paths, fleet.Plan({**options}))
    print(f"{len(part.good)} files, {len(part.bad)} left out, {time.monotonic() - begin:.0f} s")
    model.save("model.json")
    if arguments.check:
        begin = time.monotonic()
        same = torquewise.fit(paths, progress=False, **options).model == model
        print(f"one process: {time.monotonic() - begin:.0f} s, the same model: {same}")


if __name__ == "__main__":
    main()
