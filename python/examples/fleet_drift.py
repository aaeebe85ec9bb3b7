"""Three simulated robots, one of which turns harder since some week.

pip install './python[dask]'
python python/examples/fleet_drift.py
"""

import tempfile
from pathlib import Path

import torquewise
from torquewise import fleet

FRICTION = ((4.0, 3.0), (5.0, 4.0), (2.0, 1.5))  # dry [N·m], viscous [N·m·s/rad]


def record(folder: Path, robot: str, week: int) -> None:
    """A minute of a robot; the third joint of one has more viscous friction from the eighth week."""
    factor = 1.2 if (robot, week >= 8) == ("robot2", True) else 1.0
    friction = folder / "friction.toml"
    friction.write_text(
        "".join(
            f"[joint{k}]\ncoulomb = {dry}\nviscous = {viscous * (factor if k == 3 else 1)}\n"
            for k, (dry, viscous) in enumerate(FRICTION, 1)
        )
    )
    path = folder / robot / f"week{week:02}.parquet"
    path.parent.mkdir(exist_ok=True)
    seed = 100 * int(robot[-1]) + week
    torquewise.simulate(
        "puma560-3", seconds=60, rate=100, seed=seed, case=2, friction=friction, path=path
    )


def main() -> None:
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        for robot in ("robot1", "robot2", "robot3"):
            for week in range(1, 15):
                record(folder, robot, week)
        found = fleet.fit(
            f"{folder}/*/*.parquet",
            by=["robot", "week"],
            name="{robot}/week{week}.parquet",
            library="chain",
            friction="linear",
        )
    print(found)
    found.save("fleet-out")
    print("fleet-out/fleet.html")


if __name__ == "__main__":
    main()
