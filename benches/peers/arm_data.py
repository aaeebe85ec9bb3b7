"""Rows of a real arm that peers are trained and judged on, in a folder that one process writes.

    python arm_data.py FOLDER SHARED ARM CUT

writes FOLDER/arm.pickle and FOLDER/arm.urdf. What `torquewise` adds are the rows as it filtered them.
"""

import json
import pickle
import sys
import xml.etree.ElementTree as xml
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "benches"))

from public_logs import ARMS, cut, cut_by_region, joined, rms, urdf_of_dh  # noqa: E402

KEPT = ("inertial", "origin", "parent", "child", "axis", "limit")
LEAST = 1e-5  # [kg], below which an inertia may be anything


def cut_by_time(arm, log):
    """The last part, or every third block, each as long as what is simulated and more."""
    return cut(replace(arm, block=arm.block and max(arm.block, 1.0)), log, 0)


CUTS = {"time": cut_by_time, "region": cut_by_region}


@dataclass
class Data:
    """What all peers are given."""

    name: str
    joints: list
    train: list  # trajectories as they were measured
    test: list
    seen: list | None = None  # the same filtered
    judged: list | None = None

    @property
    def arm(self):
        return next(arm for (name, _), arm in ARMS.items() if name == self.name)

    def require_masses(self):
        """For peers that start from the inertias of the URDF."""
        if self.arm.dh:
            raise SystemExit("no URDF with masses")

    def errors(self, expected):
        """NRMSE of each joint, of the expected torque of each test trajectory."""
        tau = joined(self.judged)["tau"]
        return (rms(tau - np.concatenate(expected)) / tau.std(axis=0)).tolist()

    def save(self, folder):
        (folder / "arm.pickle").write_bytes(pickle.dumps(self.__dict__))

    @classmethod
    def load(cls, folder):
        return cls(**pickle.loads((folder / "arm.pickle").read_bytes()))


def bare_robot(arm, data, joints):
    """URDF of the joints that move, others fixed, of links without shapes."""
    robot = xml.fromstring(urdf_of_dh(arm, joints) if arm.dh else (data / arm.urdf).read_text())
    for element in list(robot):
        if element.tag not in ("link", "joint"):
            robot.remove(element)
        for part in list(element):
            mass = part.find("mass")
            is_nothing = mass is not None and float(mass.get("value")) < LEAST
            if is_nothing or part.tag not in KEPT:
                element.remove(part)
        if element.tag == "joint" and not (arm.dh or element.get("name").startswith(arm.moving)):
            element.set("type", "fixed")
    return xml.tostring(robot, encoding="unicode")


def main():
    import torquewise

    folder, shared, name, way = Path(sys.argv[1]), Path(sys.argv[2]), *sys.argv[3:]
    profile, arm = next((profile, arm) for (own, profile), arm in ARMS.items() if own == name)
    profile = ROOT / "profiles" / f"{profile}.toml"
    log = torquewise.read_log(shared / "data" / arm.log, profile=profile, repair=True)
    train, test = CUTS[way](arm, log)
    Data(name, log.joints, train, test).save(folder)
    (folder / "arm.urdf").write_text(bare_robot(arm, shared / "data", log.joints))
    rows = [sum(len(own["t"]) for own in part) for part in (train, test)]
    print(json.dumps({"raw": rows, "stretches": [len(train), len(test)]}))


if __name__ == "__main__":
    main()
