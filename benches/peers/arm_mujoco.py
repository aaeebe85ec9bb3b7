"""`mujoco.sysid` on a real arm: links, armature, damping and dry friction, from the URDF on.

It fits windows of half a second that are simulated from their measured state with the measured torque.
An offset of each motor, with stiffer dry friction or without, gains nothing on the UR10.
"""

import mujoco
import numpy as np
from forward import HORIZON, STEP, drift
from mujoco import sysid

TIMESTEP = 2e-3  # of what it simulates [s]
LONGEST = 20.0  # of the training rows that it is given [s]
ITERATIONS = 30  # twenty more lower what it minimises by 1 % on the UR10


def robot(folder, joints):
    """The URDF as MJCF with a motor and sensors at each joint."""
    spec = mujoco.MjSpec.from_file(str(folder / "arm.urdf"))
    spec.compiler.boundmass, spec.compiler.boundinertia = 1e-3, 1e-6
    spec.compiler.balanceinertia = True
    spec.compile()
    spec = mujoco.MjSpec.from_string(spec.to_xml())
    spec.compiler.boundmass = spec.compiler.boundinertia = spec.compiler.balanceinertia = 0
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.timestep = TIMESTEP
    spec.option.disableflags |= (
        mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_AUTORESET
    )
    for joint in spec.joints:
        joint.limited = joint.actfrclimited = mujoco.mjtLimited.mjLIMITED_FALSE
        motor = spec.add_actuator(name=f"{joint.name}_motor", target=joint.name)
        motor.trntype = mujoco.mjtTrn.mjTRN_JOINT
        motor.set_to_motor()
        sensor = spec.add_sensor(name=f"{joint.name}_position", objname=joint.name)
        sensor.type, sensor.objtype = mujoco.mjtSensor.mjSENS_JOINTPOS, mujoco.mjtObj.mjOBJ_JOINT
    spec.compile()
    assert len(spec.joints) == len(joints)
    return spec


def change_body(spec, name, parameter):
    """What `mujoco.sysid` does by itself leaves a body that MuJoCo 4.0.0 refuses: its frame is no number."""
    sysid.apply_body_inertia(spec, name, parameter)
    spec.body(name).iquat[:] = (1.0, 0.0, 0.0, 0.0)


def change_drive(joint, key, value):
    """Of the polynomial of damping the first term."""
    setattr(joint, key, np.array([value, 0.0, 0.0]) if key == "damping" else value)


def parameters(spec, tau):
    """Inertia of each link, and the drive of each joint, from a tenth of its torque on."""
    found, model = sysid.ParameterDict(), spec.compile()
    for joint in spec.joints:
        body = joint.parent.name
        change = lambda s, p, name=body: change_body(s, name, p)
        found.add(
            sysid.body_inertia_param(spec, model, body, sysid.InertiaType.Pseudo, modifier=change)
        )
    for joint, spread in zip(spec.joints, tau.std(axis=0)):
        for key in ("armature", "damping", "frictionloss"):
            change = lambda s, p, name=joint.name, key=key: change_drive(
                s.joint(name), key, p.value[0]
            )
            start, most = 0.1 * spread, 10 * spread
            found.add(sysid.Parameter(f"{joint.name}_{key}", start, 0.0, most, modifier=change))
    return found


def stretches(data, longest):
    """The first rows to train on, as trajectories."""
    left, found = longest, []
    for own in data.seen:
        kept = own["t"] - own["t"][0] <= left
        found.append({key: own[key][kept] for key in own})
        left -= found[-1]["t"][-1] - found[-1]["t"][0]
        if left <= 0:
            break
    return found


def sequences(data, spec):
    """Windows one after the other as its measured rollouts, simulated together."""
    model = spec.compile()
    names, starts, controls, sensors = [], [], [], []
    step = np.median(np.diff(data.seen[0]["t"]))
    rows = 1 + int(HORIZON / step)
    for part in stretches(data, LONGEST):
        t = part["t"]
        for row in range(0, len(t) - rows, rows):
            kept = slice(row, row + rows)
            names.append(f"window{len(names)}")
            starts.append(sysid.create_initial_state(model, part["q"][row], part["dq"][row]))
            times = np.arange(rows) * step
            controls.append(sysid.TimeSeries(times, part["tau"][kept]))
            sensors.append(sysid.TimeSeries.from_names(times, part["q"][kept], model))
    own = sysid.ModelSequences("arm", spec, names, starts, controls, sensors)
    # A list in this list is simulated at once, which saves it compiling its models for each window.
    own.measured_rollout = [own.measured_rollout]
    return own


def residual(measured):
    """What it minimises: distances, over those of an arm that keeps its velocity.

    Its own measure divides by the size of each position in each window.
    """
    held = []
    for own in measured.measured_rollout[0]:
        q, last = own.sensordata.data, own.sensordata.times[-1]
        n = q.shape[1]
        held.append(q[-1] - q[0] - last * own.initial_state[1 + n : 1 + 2 * n])
    size = np.sqrt((np.array(held) ** 2).mean(axis=0))

    def over_held(params, predicted, given, model, return_pred_all, **state):
        at = predicted.resample(given.times[1:])
        return (at.data - given.data[1:]) / size, at, at

    found = sysid.build_residual_fn(models_sequences=[measured], modify_residual=over_held)

    def of(x, params):
        """Of many parameters at once it returns the windows of one after those of the other."""
        left, *rest = found(x, params)
        if x.ndim == 2:
            left = [own.reshape(len(own), x.shape[1], -1).transpose(2, 0, 1) for own in left]
            left = [own.reshape(-1, x.shape[1]) for own in left]
        return left, *rest

    return of


def simulated(model):
    """Where MuJoCo leads a window."""
    model.opt.timestep = STEP
    data = mujoco.MjData(model)

    def end(window):
        mujoco.mj_resetData(model, data)
        data.qpos[:], data.qvel[:] = window.q, window.dq
        for tau in window.tau:
            data.ctrl[:] = tau
            mujoco.mj_step(model, data)
        return data.qpos.copy()

    return end


def torque(model):
    """Torque of the motors that a state takes: what they hold by themselves is no part of it."""
    data = mujoco.MjData(model)
    held = model.actuator_biasprm[:, 0] if model.nu else 0.0

    def of(q, dq, ddq):
        data.qpos[:], data.qvel[:], data.qacc[:] = q, dq, ddq
        mujoco.mj_inverse(model, data)
        return data.qfrc_inverse - held

    return lambda own: np.array([of(*row) for row in zip(own["q"], own["dq"], own["ddq"])])


def run(data, folder, timed):
    data.require_masses()
    spec = robot(folder, data.joints)
    start = parameters(spec, np.concatenate([own["tau"] for own in data.seen]))
    measured = sequences(data, spec)

    def work():
        return sysid.optimize(start, residual(measured), verbose=False, max_iters=ITERATIONS)

    spent, (found, result) = timed(work)
    model = sysid.apply_param_modifiers(found, spec)
    return {
        "seconds": spent, "terms": found.size, "errors": data.errors([torque(model)(own) for own in data.judged]),
        "drift": drift(data.judged, simulated(model)),
    }  # fmt: skip


def exported(data, folder):
    """The MJCF that torquewise writes of its model, in MuJoCo."""
    import torquewise

    file = folder / "torquewise.xml"
    torquewise.Model.load(folder / "torquewise-urdf.json").export(file, force=True)
    model = mujoco.MjModel.from_xml_path(str(file))
    model.actuator_ctrllimited[:] = False
    errors = data.errors([torque(model)(own) for own in data.judged])
    return {"errors": errors, "drift": drift(data.judged, simulated(model))}
