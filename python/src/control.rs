//! The loop closed with a model, on a simulated arm.

use crate::arrays::{Rows, array, motion, same_rows};
use crate::errors::{choice, raised, value_error, wrong};
use crate::model::Model;
use crate::simulation::{ArmSource, arm_of};
use crate::work::work;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;
use torquewise::control::{
    Drive, Gains, Law, Learned, Periodic, Plant, Sensors, Tracking, compare, each, is_of_joints,
    mean_inertia, periodic,
};
use torquewise::dynamics::Friction;
use torquewise::motion::Motion;
use torquewise::twin;

/// Time stamps, positions, velocities and accelerations.
type Desired<'py> = (Vec<f64>, Rows<'py>, Rows<'py>, Rows<'py>);

/// Numbers of a periodic motion: seconds, period, rate, speed, acceleration and seed.
type Waves = (f64, f64, f64, f64, f64, u64);

/// What the arm did, a pair of name and dict for each controller.
///
/// - `sensors`: counts of the encoders, noise, cut-off of the velocity, seed
#[pyfunction]
#[pyo3(signature = (model, arm, *, wanted, waves, controllers, perfect, bandwidth, settle, friction, lock,
                    rotor, torque_limit, delay, sensors))]
#[expect(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn control<'py>(
    py: Python<'py>,
    model: Bound<'py, Model>,
    arm: ArmSource<'py>,
    wanted: Option<Desired<'py>>,
    waves: Waves,
    controllers: Vec<String>,
    perfect: bool,
    bandwidth: f64,
    settle: Option<f64>,
    friction: Option<&str>,
    lock: Vec<String>,
    rotor: Vec<f64>,
    torque_limit: Vec<f64>,
    delay: f64,
    sensors: (u32, f64, f64, u64),
) -> PyResult<Vec<(String, Bound<'py, PyDict>)>> {
    let named = Law::ALL.map(|law| (law.name(), law));
    let laws = controllers.iter().map(|name| choice("controllers", name, &named));
    let laws = laws.collect::<PyResult<Vec<_>>>()?;
    let (arm, of_model) = arm_of(&arm, &lock)?;
    let (n, joints) = (arm.n_joints(), arm.joints().to_vec());
    if !is_of_joints(&model.get().model, &arm) {
        let (expected, found) = (model.get().model.joints.join(", "), joints.join(", "));
        return wrong(format!("arm: expected the joints of the model, {expected}, not {found}"));
    }
    let friction = match (of_model, friction) {
        (Some(_), Some(_)) => return wrong("friction is not for a model, which has its own"),
        (Some(twin), None) => twin::friction(&twin).map_err(raised)?,
        (None, Some(text)) => Friction::from_toml(text, &joints).map_err(value_error)?,
        (None, None) => Friction::none(n),
    };
    let arm = if rotor.is_empty() {
        arm
    } else {
        arm.with_rotors(&each(&rotor, n)).map_err(value_error)?
    };
    let (counts, noise, cutoff, seed) = sensors;
    let sensors = Sensors { noise, cutoff, seed, ..Sensors::of_counts(counts) };
    let drive = Drive::new(n, &torque_limit, delay);
    let plant = Plant { friction, drive, sensors, ..Plant::ideal(arm) };
    let wanted = desired(wanted, waves, &plant)?;
    let known = Arc::clone(&model.get().model);
    let job = move || -> Result<_, torquewise::Error> {
        let known = Learned::new(&known)?;
        let gains = Gains::critically_damped(bandwidth, &mean_inertia(&known, &wanted)?);
        let mut found = compare(&plant, &known, &laws, &gains, &wanted)?;
        if perfect {
            let laws = [Law::Controller1, Law::Controller2];
            found.extend(compare(&plant, &plant, &laws, &gains, &wanted)?);
        }
        Ok(found)
    };
    let found = work(py, None, move |_| Ok(job()))?.map_err(value_error)?;
    let perfect = ["controller1_perfect", "controller2_perfect"].map(str::to_owned);
    let names = controllers.into_iter().chain(perfect);
    names.zip(&found).map(|(name, own)| Ok((name, tracking_dict(py, own, settle)?))).collect()
}

fn desired(wanted: Option<Desired<'_>>, waves: Waves, plant: &Plant) -> PyResult<Motion> {
    let Some((t, q, dq, ddq)) = wanted else {
        let (seconds, period, rate, speed, acceleration, seed) = waves;
        let waves = Periodic { seconds, period, rate, speed, acceleration, seed };
        return periodic(&plant.arm, &waves).map_err(value_error);
    };
    let rows = same_rows([("q", &q), ("dq", &dq), ("ddq", &ddq)], plant.arm.n_joints())?;
    motion(plant.arm.joints(), t, rows, None)
}

/// - `settle`: when errors begin to count \[s\]; halfway without
fn tracking_dict<'py>(
    py: Python<'py>,
    found: &Tracking,
    settle: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let settle = settle.unwrap_or(found.t.last().map_or(0.0, |end| end / 2.0));
    let dict = PyDict::new(py);
    let Tracking { q, dq, error, tau, hand, .. } = found;
    for (name, rows) in [("q", q), ("dq", dq), ("error", error), ("tau", tau), ("hand", hand)] {
        dict.set_item(name, array(py, rows.as_ref()))?;
    }
    let (rms, peak) = (found.rms_error(settle), found.peak_error(settle));
    let numbers = [
        ("t", &found.t),
        ("rms_error", &rms),
        ("peak_error", &peak),
        ("saturated", &found.saturated),
    ];
    for (name, values) in numbers {
        dict.set_item(name, PyArray1::from_slice(py, values))?;
    }
    Ok(dict)
}
