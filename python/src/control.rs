//! The loop closed with a model, on a simulated arm.

use crate::arrays::{Rows, array, motion, same_rows};
use crate::errors::{choice, raised, value_error, wrong};
use crate::model::Model;
use crate::simulation::{ArmSource, arm_of};
use crate::work::work;
use numpy::PyArray1;
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::ffi::CString;
use std::sync::Arc;
use torquewise::control::{
    Actuator, Law, Learned, Periodic, Plant, Run, Sensors, Tracking, compare, each, is_of_joints,
    periodic,
};
use torquewise::dynamics::Friction;
use torquewise::motion::Motion;
use torquewise::twin;

/// Time stamps, positions, velocities and accelerations.
type Desired<'py> = (Vec<f64>, Rows<'py>, Rows<'py>, Rows<'py>);

/// Numbers of a periodic motion: seconds, period, rate, speed and acceleration.
type Waves = [Option<f64>; 5];

/// What the arm did, a pair of name and dict for each controller.
///
/// - `sensors`: counts of the encoders, noise, cut-off of the velocity, seed
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn control<'py>(
    py: Python<'py>,
    model: Bound<'py, Model>,
    arm: ArmSource<'py>,
    wanted: Option<Desired<'py>>,
    waves: Waves,
    seed: u64,
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
    let (counts, noise, cutoff, noise_seed) = sensors;
    let sensors = Sensors { noise, cutoff, seed: noise_seed, ..Sensors::of_counts(counts) };
    let drive = Actuator::new(n, &torque_limit, delay);
    let plant = Plant { friction, drive, sensors, ..Plant::ideal(arm) };
    let wanted = desired(wanted, (waves, seed), &plant)?;
    let long = wanted.t().last().map_or(0.0, |end| end - wanted.t()[0]);
    let settle = settle.unwrap_or(long / 2.0);
    if !(0.0..long).contains(&settle) {
        return wrong(format!("settle={settle} leaves nothing of {long} s: take less"));
    }
    let known = Arc::clone(&model.get().model);
    let job = move || -> Result<_, torquewise::Error> {
        let known = Learned::new(&known)?;
        Ok(compare(&plant, &known, (&laws, perfect), bandwidth, &wanted)?)
    };
    let found = work(py, None, move |_| Ok(job()))?.map_err(value_error)?;
    for (name, t) in found.ran_away {
        let told =
            CString::new(format!("{name}: the arm runs away at {t:.3} s: lower the bandwidth"))?;
        PyErr::warn(py, &py.get_type::<PyUserWarning>(), &told, 3)?;
    }
    found.runs.iter().map(|own| Ok((own.name.clone(), tracking_dict(py, own, settle)?))).collect()
}

fn desired(
    wanted: Option<Desired<'_>>,
    (waves, seed): (Waves, u64),
    plant: &Plant,
) -> PyResult<Motion> {
    let Some((t, q, dq, ddq)) = wanted else {
        let Periodic { seconds, period, rate, speed, acceleration, .. } = Periodic::default();
        let mut usual = [seconds, period, rate, speed, acceleration];
        usual.iter_mut().zip(waves).for_each(|(usual, own)| *usual = own.unwrap_or(*usual));
        let [seconds, period, rate, speed, acceleration] = usual;
        let waves = Periodic { seconds, period, rate, speed, acceleration, seed };
        return periodic(&plant.arm, &waves).map_err(value_error);
    };
    let rows = same_rows([("q", &q), ("dq", &dq), ("ddq", &ddq)], plant.arm.n_joints())?;
    motion(plant.arm.joints(), t, rows, None)
}

/// - `settle`: when errors begin to count \[s\]
fn tracking_dict<'py>(
    py: Python<'py>,
    Run { tracking: found, .. }: &Run,
    settle: f64,
) -> PyResult<Bound<'py, PyDict>> {
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
