//! An arm with friction, three recordings of it in velocity mode, and the model learned from them.

use crate::error::{PaperError, within};
use crate::settings::Settings;
use rayon::prelude::*;
use torquewise_identify::plan::{FrictionKind, LibraryOptions};
use torquewise_identify::{Plan, Reconstruction, reconstruct};
use torquewise_motion::Motion;
use torquewise_motion::signals::{Conditioning, Raw, condition};
use torquewise_sim::control::{Plant, Sensors, record};
use torquewise_sim::excite::{self as excite, Planned, Wishes};
use torquewise_sim::{Arm, Friction, Stribeck};

/// Friction of the joints, the first of an arm that has fewer.
const FRICTION: [Stribeck; 3] = [
    Stribeck { coulomb: 4.0, stiction: 6.0, speed: 0.1, viscous: 3.0 },
    Stribeck { coulomb: 5.0, stiction: 7.0, speed: 0.12, viscous: 4.0 },
    Stribeck { coulomb: 2.0, stiction: 3.0, speed: 0.08, viscous: 1.5 },
];
/// Inertia of the rotors as felt at the joints \[kg·m²\]: 200 g·cm² behind the gears of the PUMA.
const ROTORS: [f64; 3] = [0.78, 2.32, 0.58];
/// Time from a command to its torque \[s\].
const DELAY: f64 = 1e-3;
/// White noise in the recorded torque \[N·m\].
const TORQUE_NOISE: f64 = 0.05;
/// Rate of the drives and of their recordings \[Hz\].
pub(crate) const RATE: f64 = 1000.0;
/// Bandwidth of the drives in velocity mode \[rad/s\].
const VELOCITY_BANDWIDTH: f64 = 60.0;
/// Speed and acceleration that recordings keep to.
const LIMITS: [f64; 2] = [1.5, 4.0];

/// The arm of the settings with friction, rotors, drives and encoders.
pub(crate) fn plant(settings: &Settings) -> Result<Plant, PaperError> {
    let arm = Arm::builtin(settings.arm)?;
    let n = arm.n_joints();
    let first = |place: usize| place % FRICTION.len();
    let curves: Vec<Stribeck> = (0..n).map(|joint| FRICTION[first(joint)]).collect();
    let rotors: Vec<f64> = (0..n).map(|joint| ROTORS[first(joint)]).collect();
    let mut plant = Plant::ideal(arm.with_rotors(&rotors)?);
    plant.friction = Friction::new(&curves)?;
    plant.drive.delay = DELAY;
    plant.sensors =
        Sensors { torque_noise: TORQUE_NOISE, seed: settings.seed, ..Sensors::default() };
    Ok(plant)
}

/// How the recordings become a model.
pub(crate) fn plan() -> Plan {
    LibraryOptions { friction: FrictionKind::Stribeck, ..LibraryOptions::default() }.into()
}

/// What was recorded, cleaned for the learner: very slow, uniform and variable velocity.
pub(crate) fn recordings(plant: &Plant, settings: &Settings) -> Result<Vec<Motion>, PaperError> {
    let all = |value| excite::PerJoint(vec![(None, value)]);
    let [velocity, acceleration] = LIMITS.map(all);
    let wishes = Wishes { velocity, acceleration, speed_scale: 1.0, ..Wishes::default() };
    let limits = excite::limits(&plant.arm, &wishes)?;
    let plan = excite::Plan {
        seconds: settings.recordings,
        dwell: 1.0,
        slow_sweeps: true,
        rate: RATE,
        seed: settings.seed,
        tries: 8,
        ..excite::Plan::default()
    };
    let planned = excite::excite(&limits, &plan, &mut |_, _| {})?;
    planned.recordings.par_iter().map(|planned| recorded(plant, planned)).collect()
}

/// One recording: moved, measured, cleaned.
fn recorded(plant: &Plant, planned: &Planned) -> Result<Motion, PaperError> {
    let log = record(plant, &planned.motion()?, VELOCITY_BANDWIDTH)?;
    let raw =
        Raw { joints: log.joints, t: log.t, q: log.q, dq: None, ddq: None, tau: Some(log.tau) };
    Ok(condition(&raw, &Conditioning::default())?.motion)
}

/// The model that the recordings lead to.
pub(crate) fn learn(recordings: &[Motion]) -> Result<Reconstruction, PaperError> {
    let experiment = "on the recordings of an arm with friction";
    reconstruct(recordings, &plan(), &mut |_| {}).map_err(within(experiment))
}
