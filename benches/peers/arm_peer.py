"""One peer on a real arm: its errors on the test rows, how far its simulation drifts, what it took.

    python arm_peer.py FOLDER PEER

The folder is that of `arm_data.py`. Every peer runs in a process of its own, and prints one JSON object.
"""

import json
import logging
import resource
import sys
import time
import warnings
from pathlib import Path

import numpy as np
from arm_data import Data
from forward import HORIZON, RegressorArm, drift
from public_logs import PlainFriction, Regressor, band, joined, springs

warnings.filterwarnings("ignore")
logging.disable(logging.WARNING)


def timed(work):
    """Seconds by the clock and of all processors, and what the work gave."""
    clock, processors = time.perf_counter(), time.process_time()
    done = work()
    return [time.perf_counter() - clock, time.process_time() - processors], done


def filtered(parts, model):
    import torquewise

    return torquewise.read_log(parts, **band(model)).trajectories(conditioned=True)


def ours(data, folder, name, **options):
    import torquewise

    options = {"library": "chain", "counterbalance": list(data.arm.balanced), **options}
    spent, fit = timed(lambda: torquewise.fit(data.train, progress=False, **options))
    model = fit.model
    model.save(folder / f"{name}.json")
    if name == "torquewise":
        data.seen, data.judged = (filtered(part, model) for part in (data.train, data.test))
        data.save(folder)
    found = model.rollout(data.test, horizons=[HORIZON], **band(model))
    ran_away = bool(found.ran_away[0])
    ratios = [None if ran_away else own for own in (found.drift[0] / found.hold[0]).tolist()]
    expected = [model.torque(*(own[key] for key in ("q", "dq", "ddq"))) for own in data.judged]
    return {
        "seconds": spent, "terms": model.complexity, "verdict": fit.verdict,
        "errors": data.errors(expected), "drift": ratios,
    }  # fmt: skip


def torquewise_alone(data, folder):
    return ours(data, folder, "torquewise")


def with_urdf(data, folder, name="torquewise-urdf", **more):
    import torquewise

    same = band(torquewise.Model.load(folder / "torquewise.json"))
    return ours(data, folder, name, urdf=folder / "arm.urdf", **same, **more)


def refined(data, folder):
    return with_urdf(data, folder, "torquewise-refined", refine="rollout")


class OurFriction:
    """Columns of each law that torquewise chose, as its own model gives them, rotors and springs."""

    def __init__(self, data, folder):
        import torquewise

        self.balanced = [data.joints.index(name) for name in data.arm.balanced]
        text = (folder / "torquewise-urdf.json").read_text()
        found = json.loads(text)
        self.models = []
        for place in range(len(found["friction"])):
            for k, law in enumerate(found["friction"]):
                law["coefficient"] = float(k == place)
            self.models.append(torquewise.Model.from_json(json.dumps(found)))
        rotors = [own["rotor"]["shaft"] for own in found["chain"]["drives"] if "rotor" in own]
        self.rotors = np.array(rotors)

    def __call__(self, motion):
        q, dq, ddq = (motion[key] for key in ("q", "dq", "ddq"))
        columns = [model.friction(q, dq) for model in self.models]
        columns += [(ddq @ shaft)[:, None] * shaft for shaft in self.rotors]
        return np.concatenate([np.stack(columns, axis=-1), *springs(self.balanced, q)], axis=-1)


def robot(folder):
    import pinocchio

    return pinocchio.buildModelFromUrdf(str(folder / "arm.urdf"))


def regressor(data, folder):
    seen = joined(data.seen)
    plain = PlainFriction(data.arm, data.joints, seen)
    spent, found = timed(lambda: Regressor(robot(folder), plain, seen))
    result = {"seconds": spent, "terms": int(np.count_nonzero(found.coefficients))}
    result["errors"] = data.errors([found.torque(own) for own in data.judged])
    n = len(data.joints)
    if len(plain.shafts) == n and not plain.balanced:
        bodies, laws = np.split(found.coefficients, [10 * n])
        offset, viscous, dry, rotor = laws.reshape(n, 4).T
        arm = RegressorArm(
            found.bodies, bodies, list(zip(offset, viscous, dry, plain.widths, rotor))
        )
        result["drift"] = drift(data.judged, arm.end)
    return result


def regressor_same_friction(data, folder):
    laws = OurFriction(data, folder)
    # What friction remembers begins anew with each trajectory.
    drives = lambda motion: np.concatenate([laws(own) for own in motion["parts"]])
    whole = lambda parts: joined(parts) | {"parts": parts}
    spent, found = timed(lambda: Regressor(robot(folder), drives, whole(data.seen)))
    errors = data.errors([found.torque(whole([own])) for own in data.judged])
    return {"seconds": spent, "terms": int(np.count_nonzero(found.coefficients)), "errors": errors}


def figaroh(data, folder, physical=False):
    import arm_figaroh

    return arm_figaroh.run(data, folder, timed, physical)


def figaroh_physical(data, folder):
    return figaroh(data, folder, physical=True)


def pysindy(data, folder):
    import arm_sindy

    return arm_sindy.run(data, timed)


def mujoco_sysid(data, folder):
    import arm_mujoco

    return arm_mujoco.run(data, folder, timed)


def exported(data, folder):
    import arm_mujoco

    return arm_mujoco.exported(data, folder)


PEERS = {
    "torquewise": torquewise_alone,
    "torquewise, URDF": with_urdf,
    "the MJCF of it, in MuJoCo": exported,
    "torquewise, URDF, refined": refined,
    "regressor, plain friction": regressor,
    "regressor, our friction": regressor_same_friction,
    "FIGAROH": figaroh,
    "FIGAROH, physical": figaroh_physical,
    "PySINDy": pysindy,
    "mujoco.sysid": mujoco_sysid,
}


def main():
    folder, name = Path(sys.argv[1]), sys.argv[2]
    found = PEERS[name](Data.load(folder), folder)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(json.dumps({**found, "memory_mb": memory}))


if __name__ == "__main__":
    main()
