"""A fleet on Spark: `mapInArrow` sums up, `treeReduce` merges.

pip install ./python pyspark          # and a Java runtime
python python/examples/fleet_spark.py 'logs/*.parquet'
"""

import argparse
import glob
import os
import pickle
import sys
import time
from collections.abc import Iterable, Iterator
from typing import Any

import pyarrow as pa
from pyspark.sql import SparkSession

import torquewise
from torquewise import FitOptions, Model, fleet


def fit(
    spark: Any, paths: list[str], plan: fleet.Plan, partitions: int
) -> tuple[Model, fleet.Part]:
    """The model of all files, and what became of each."""

    def summed(request: bytes | None, known: dict[str, str]) -> fleet.Part:
        def sums(batches: Iterable[Any]) -> Iterator[Any]:
            for batch in batches:
                part = fleet.summarise(batch.column("path").to_pylist(), plan, request, known)
                yield pa.RecordBatch.from_pydict({"part": [pickle.dumps(part)]})

        table = spark.createDataFrame([(path,) for path in paths], "path string")
        parts = table.repartition(partitions).mapInArrow(sums, "part binary").rdd
        part: fleet.Part = parts.map(lambda row: pickle.loads(row.part)).treeReduce(
            fleet.merge, depth=2
        )
        return part

    return fleet.rounds(summed, plan)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("logs", help="files, as a pattern")
    parser.add_argument("--master", default="local[2]")
    parser.add_argument("--check", action="store_true", help="fit all in one process too")
    arguments = parser.parse_args()
    paths = sorted(glob.glob(arguments.logs, recursive=True))
    options: FitOptions = {"library": "chain", "friction": "linear"}
    # Workers of this machine run in the environment of this program.
    os.environ.setdefault("PYSPARK_PYTHON", sys.executable)
    spark = SparkSession.builder.master(arguments.master).appName("torquewise").getOrCreate()
    spark.sparkContext.setLogLevel("ERROR")
    begin = time.monotonic()
    model, part = fit(spark, paths, fleet.Plan({**options}), max(4, len(paths) // 8))
    print(f"{len(part.good)} files, {len(part.bad)} left out, {time.monotonic() - begin:.0f} s")
    model.save("model.json")
    if arguments.check:
        begin = time.monotonic()
        same = torquewise.fit(paths, progress=False, **options).model == model
        print(f"one process: {time.monotonic() - begin:.0f} s, the same model: {same}")
    spark.stop()


if __name__ == "__main__":
    main()
