"""FIGAROH by its own way: a subclass for the robot, a configuration file, `initialize`, `solve`.

It is handed rows that are filtered, so its own filter is left out, and nothing is decimated. Friction
is viscous and by the sign of the velocity, the weights those of the joints' residuals.
"""

import contextlib
import sys

import numpy as np
import yaml
from figaroh.identification.base_identification import BaseIdentification
from figaroh.tools.load_robot import load_robot
from figaroh.tools.regressor import build_regressor_basic
from forward import RegressorArm, drift
from public_logs import joined

SIGN = 1e-9  # half width of a reversal that is a sign [rad/s]


def configuration(joints, physical):
    """What its documentation asks for; the rank is judged by the largest pivot, as it advises."""
    task = {
        "enabled": True,
        "problem": {
            "use_joint_torques": True,
            "include_external_forces": False,
            "qr_relative_tolerance": 1e-4,
            "model_components": {"friction": True, "actuator_inertia": True, "joint_offset": True},
        },
        "signal_processing": {"sampling_frequency": 1000.0, "cutoff_frequency": 100.0},
    }
    if physical:
        task |= {"select_stage": "physical_fit", "physical_fit": {"enabled": True}}
    robot = {"name": "arm", "properties": {"joints": {"active_joints": joints}}}
    return {"robot": robot, "tasks": {"identification": task}}


class Identification(BaseIdentification):
    """The rows of an arm."""

    rows = None

    def load_trajectory_data(self, data_source=None):
        keys = {"timestamps": "t", "positions": "q", "velocities": "dq", "accelerations": "ddq"}
        return {name: self.rows[key] for name, key in (keys | {"torques": "tau"}).items()}

    def filter_kinematics_data(self, filter_config=None):
        self.processed_data = dict(self.raw_data)


def run(data, folder, timed, physical):
    if physical:
        data.require_masses()
    robot = load_robot(str(folder / "arm.urdf"), loader="figaroh")
    file = folder / "figaroh.yaml"
    file.write_text(yaml.safe_dump(configuration(list(robot.model.names)[1:], physical)))

    def work():
        own = Identification(robot, str(file))
        own.identif_config["act_idxq"] = own.identif_config["act_idxv"] = list(
            range(robot.model.nv)
        )
        own.rows = joined(data.seen)
        own.initialize()
        own.solve(decimate=False, plotting=False, wls=True)
        return own

    with contextlib.redirect_stdout(sys.stderr):
        spent, own = timed(work)
    if physical:
        if not own.selected.accepted:
            raise SystemExit(f"rejected: {own.selected.reason}")
        parameters = own.selected.values
    else:
        parameters = np.zeros(len(own.standard_parameter))
        kept = np.delete(np.arange(len(parameters)), own._idx_eliminated)
        parameters[kept[list(own._base_indices)]] = own.phi_base
    n = len(data.joints)
    expected = []
    for part in data.judged:
        state = (part[key] for key in ("q", "dq", "ddq"))
        columns = build_regressor_basic(robot, *state, own.identif_config)
        expected.append((columns @ parameters).reshape(n, -1).T)
    viscous, dry, rotor, offset = parameters[10 * n :].reshape(4, n)

    def bodies(q, dq, ddq):
        import pinocchio

        return pinocchio.computeJointTorqueRegressor(robot.model, robot.data, q, dq, ddq)

    friction = list(zip(offset, viscous, dry, np.full(n, SIGN), rotor))
    arm = RegressorArm(bodies, parameters[: 10 * n], friction)
    return {
        "seconds": spent, "terms": int(np.count_nonzero(parameters)),
        "errors": data.errors(expected), "drift": drift(data.judged, arm.end),
    }  # fmt: skip
