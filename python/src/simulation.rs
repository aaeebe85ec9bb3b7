//! Arms of known truth, and motions to record.

use crate::errors::{choice, raised, value_error, wrong};
use crate::log::motion_dict;
use crate::model::Model;
use crate::work::work;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::path::Path;
use std::sync::Arc;
use torquewise::dynamics::{
    Arm, Friction, MotionKind, MotionPlan, Noise, SimulatedLog, add_noise, arms as builtin_arms,
};
use torquewise::excite::{
    ExcitationPlan, JointValues, Limits, Torques, Wishes, excite as plan_motions, joint_trajectory,
    limits,
};
use torquewise::motion::{Recording, bounded_file};
use torquewise::twin::{self, TwinLog};

/// An arm: a name of a built-in one, a path of a `.urdf` or a `.toml` with a DH table, or a model.
#[derive(FromPyObject)]
pub(crate) enum ArmSource<'py> {
    Model(Bound<'py, Model>),
    Name(String),
}

pub(crate) fn arm_of(
    source: &ArmSource<'_>,
    lock: &[String],
) -> PyResult<(Arm, Option<Arc<torquewise::Model>>)> {
    match source {
        ArmSource::Model(model) => {
            let model = Arc::clone(&model.get().model);
            let arm = twin::arm(&model).map_err(raised)?;
            Ok((arm, Some(model)))
        }
        ArmSource::Name(name) => {
            let ending = Path::new(name).extension().map(|e| e.to_string_lossy().to_lowercase());
            let arm = match ending.as_deref() {
                Some("urdf") => Arm::from_urdf(&bounded_file::read_text(name.as_ref())?, lock),
                Some("toml") => Arm::from_dh_toml(&bounded_file::read_text(name.as_ref())?),
                _ => Arm::builtin(name),
            };
            Ok((arm.map_err(value_error)?, None))
        }
    }
}

/// Names and joints of the built-in arms.
#[pyfunction]
pub(crate) fn arms() -> Vec<(String, usize)> {
    builtin_arms().iter().map(|arm| (arm.name.to_owned(), arm.joints)).collect()
}

const MOTIONS: [(&str, MotionKind); 3] =
    [("moves", MotionKind::Moves), ("sines", MotionKind::Sines), ("staged", MotionKind::Staged)];

/// A motion of an arm with its torque: joint names, and a dict of t, q, dq, ddq and tau.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn simulate<'py>(
    py: Python<'py>,
    arm: ArmSource<'py>,
    motion: &str,
    seconds: Option<f64>,
    rate: Option<f64>,
    seed: u64,
    noise_db: Option<[f64; 3]>,
    friction: Option<&str>,
    lock: Vec<String>,
) -> PyResult<(Vec<String>, Bound<'py, PyDict>)> {
    let (usual, kind) = (MotionPlan::default(), choice("motion", motion, &MOTIONS)?);
    let plan = MotionPlan {
        kind,
        seconds: seconds.unwrap_or(usual.seconds),
        rate: rate.unwrap_or(usual.rate),
        seed,
    };
    let (arm, twin) = arm_of(&arm, &lock)?;
    if twin.is_some() && friction.is_some() {
        return wrong("friction is not for a model, which has its own");
    }
    let noise = noise_db.map(|[q, dq, ddq]| Noise::from_db(q, dq, ddq)).transpose();
    let noise = noise.map_err(value_error)?;
    let friction = friction.map(|text| Friction::from_toml(text, arm.joints())).transpose();
    let friction = friction.map_err(value_error)?;
    let joints = arm.joints().to_vec();
    let made = move || -> Result<_, torquewise::Error> {
        let clean = if let Some(model) = &twin {
            TwinLog::new(model, &plan)?.trajectories()?.remove(0)
        } else {
            let log = SimulatedLog::new(&arm, &plan)?;
            friction.map_or(Ok(log.clone()), |own| log.with_friction(own))?.whole()?.motion
        };
        Ok(noise.map_or(Ok(clean.clone()), |noise| add_noise(&clean, &noise, seed))?)
    };
    let made = work(py, None, move |_| Ok(made()))?.map_err(value_error)?;
    Ok((joints, motion_dict(py, &made)?))
}

/// Wishes per joint: a name, or none for all, and the value.
type Wish<T> = Vec<(Option<String>, T)>;

/// The recordings of standstill, uniform and variable velocity: a list of three dicts, each with t,
/// q, dq and ddq, and the name of the pattern and the `JointTrajectory` of ROS 2 as text.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn excite<'py>(
    py: Python<'py>,
    arm: ArmSource<'py>,
    seconds: Option<[f64; 3]>,
    dwell: Option<f64>,
    slow_sweeps: bool,
    range: Wish<[f64; 2]>,
    margin: Option<f64>,
    max_velocity: Wish<f64>,
    max_acceleration: Wish<f64>,
    torque_limit: Wish<f64>,
    speed_scale: Option<f64>,
    home: Option<Vec<f64>>,
    lock: Vec<String>,
    interaction: Option<usize>,
    tries: Option<usize>,
    rate: Option<f64>,
    ros_rate: f64,
    seed: u64,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyList>> {
    let (arm, model) = arm_of(&arm, &lock)?;
    let (usual, wishes) = (ExcitationPlan::default(), Wishes::default());
    let wishes = Wishes {
        range: JointValues(range),
        velocity: JointValues(max_velocity),
        acceleration: JointValues(max_acceleration),
        speed_scale: speed_scale.unwrap_or(wishes.speed_scale),
        margin: margin.unwrap_or(wishes.margin),
    };
    let limits: Vec<Limits> = limits(&arm, &wishes).map_err(value_error)?;
    let most = JointValues(torque_limit);
    let torques = match model {
        Some(model) => twin::torques(&model, &most).map_err(raised)?,
        None => Torques::of_arm(&arm, &most).map_err(value_error)?,
    };
    let plan = ExcitationPlan {
        seconds: seconds.unwrap_or(usual.seconds),
        dwell: dwell.unwrap_or(usual.dwell),
        slow_sweeps,
        rate: rate.unwrap_or(usual.rate),
        home,
        interaction,
        tries: tries.unwrap_or(usual.tries),
        seed,
    };
    let found = work(py, progress, move |_| {
        Ok(plan_motions(&limits, torques.as_ref(), &plan, &mut |_, _| {}))
    })?;
    let found = found.map_err(value_error)?;
    let dicts = PyList::empty(py);
    for (recording, name) in found.recordings.iter().zip(["standstill", "uniform", "variable"]) {
        let dict = motion_dict(py, &recording.motion().map_err(value_error)?)?;
        let text = joint_trajectory(recording, ros_rate).map_err(value_error)?;
        dict.set_item("name", name)?;
        dict.set_item("joint_trajectory", text)?;
        dicts.append(dict)?;
    }
    Ok(dicts)
}
