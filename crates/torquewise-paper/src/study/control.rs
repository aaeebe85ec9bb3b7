//! An arm with friction, recorded, learned and controlled: friction, torque after each step, tracking
//! (Fig. 10, 11).

use crate::trial::{self, step_lines};
use crate::{Result, Settings, Study, within};
use faer::Mat;
use rayon::prelude::*;
use torquewise_identify::{FrictionKind, LibraryOptions, reconstruct};
use torquewise_model::{Model, Torque};
use torquewise_motion::signals::{Conditioned, Cutoff, condition};
use torquewise_motion::{Conditioning, Motion, Raw};
use torquewise_report::{Chart, Colour, Guide, Mark, Series, significant, torque_charts};
use torquewise_sim::control::knowledge::sharp;
use torquewise_sim::control::{
    Law, Learned, Periodic, Plant, Runs, Sensors, compare, periodic, record,
};
use torquewise_sim::excite::{self as excite, Planned, Wishes};
use torquewise_sim::{Arm, Friction, SimError, Stribeck};

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
const RATE: f64 = 1000.0;
/// Bandwidth of the drives in velocity mode \[rad/s\].
const VELOCITY_BANDWIDTH: f64 = 60.0;
/// Speed and acceleration that recordings keep to.
const LIMITS: [f64; 2] = [1.5, 4.0];
/// Bandwidth of the feedback of all controllers \[rad/s\].
const BANDWIDTH: f64 = 15.0;
/// Speeds at which friction is judged, a decade and a half of them \[rad/s\].
const SPEEDS: usize = 60;
/// Below this speed \[rad/s\] friction is not judged: there the learner smooths its reversal.
const DEAD_ZONE: f64 = 0.06;
/// Highest of those speeds \[rad/s\].
const FASTEST: f64 = 1.2;
/// Every so many ticks one is kept for figures.
const SHOWN: usize = 20;
/// Controller 2 is clearly better than controller 1 below this share of its error.
const FEWER: f64 = 0.5;
/// The controllers that are compared, and what they know.
const NAMES: [&str; 6] = [
    "PID",
    "controller 1",
    "controller 2",
    "computed torque",
    "controller 1, perfect model",
    "controller 2, perfect model",
];

pub(crate) fn study(settings: &Settings) -> Result<Study> {
    let plant = plant(settings)?;
    let model = learn(&plant, settings)?;
    let plan = Periodic { rate: RATE, seed: settings.seed, ..Periodic::default() };
    let wanted = periodic(&plant.arm, &plan)?;
    let mut study = Study::described("control", plant.arm.n_joints());
    friction(&plant, &model, &mut study)?;
    steps(&plant, &model, &wanted, &mut study)?;
    // The first period begins with an empty integral.
    track(&plant, &model, &wanted, plan.seconds - plan.period, &mut study)?;
    Ok(study)
}

/// The arm of the settings with friction, rotors, drives and encoders.
fn plant(settings: &Settings) -> Result<Plant> {
    let arm = Arm::builtin(settings.arm)?;
    let curves: Vec<Stribeck> = FRICTION.into_iter().cycle().take(arm.n_joints()).collect();
    let rotors: Vec<f64> = ROTORS.into_iter().cycle().take(arm.n_joints()).collect();
    let mut plant = Plant::ideal(arm.with_rotors(&rotors)?);
    plant.friction = Friction::new(&curves)?;
    plant.drive.delay = DELAY;
    plant.sensors =
        Sensors { torque_noise: TORQUE_NOISE, seed: settings.seed, ..Sensors::default() };
    Ok(plant)
}

/// The model that recordings of very slow, uniform and variable velocity lead to.
fn learn(plant: &Plant, settings: &Settings) -> Result<Model> {
    let [velocity, acceleration] = LIMITS.map(|value| excite::JointValues(vec![(None, value)]));
    let wishes = Wishes { velocity, acceleration, speed_scale: 1.0, ..Wishes::default() };
    let plan = excite::ExcitationPlan {
        seconds: settings.recordings,
        dwell: 1.0,
        slow_sweeps: true,
        rate: RATE,
        seed: settings.seed,
        tries: 8,
        ..excite::ExcitationPlan::default()
    };
    let planned =
        excite::excite(&excite::limits(&plant.arm, &wishes)?, None, &plan, &mut |_, _| {})?;
    let recorded = |planned: &Planned| -> Result<Raw> {
        Ok(record(plant, &planned.motion()?, VELOCITY_BANDWIDTH)?)
    };
    let raw = planned.recordings.par_iter().map(recorded).collect::<Result<Vec<_>>>()?;
    // All at the cut-off of the liveliest: at that of slow motion its reversals are blurred.
    let conditioned = |settings: &Conditioning| -> Result<Vec<Conditioned>> {
        raw.par_iter().map(|raw| Ok(condition(raw, settings)?)).collect()
    };
    let apart = conditioned(&Conditioning::default())?;
    let widest = apart.iter().map(|log| log.report.cutoff).fold(0.0, f64::max);
    let alike = Conditioning { cutoff: Cutoff::Hz(widest), ..Conditioning::default() };
    let logs: Vec<Motion> = conditioned(&alike)?.into_iter().map(|log| log.motion).collect();
    let options = LibraryOptions { friction: FrictionKind::Stribeck, ..LibraryOptions::default() };
    let experiment = "on the recordings of an arm with friction";
    let found = reconstruct(&logs[..], &options.into(), torquewise_identify::UNWATCHED)
        .map_err(within(experiment))?;
    Ok(found.model)
}

/// f(v) of each joint, true and learned, at speeds from the dead zone on, both ways.
fn friction(plant: &Plant, model: &Model, study: &mut Study) -> Result {
    let n = plant.arm.n_joints();
    let known = Torque::new(&sharp(model));
    let mut speeds: Vec<f64> = (0..SPEEDS)
        .map(|k| DEAD_ZONE * (FASTEST / DEAD_ZONE).powf(k as f64 / (SPEEDS - 1) as f64))
        .flat_map(|speed| [-speed, speed])
        .collect();
    speeds.sort_by(f64::total_cmp);
    let at = |&v: &f64| -> Result<[Vec<f64>; 2]> {
        let all = vec![v; n];
        Ok([plant.friction.torques(&all), known.friction(&vec![0.0; n], &all)?])
    };
    let torques = speeds.iter().map(at).collect::<Result<Vec<_>>>()?;
    let mut worst_percent = Vec::new();
    for joint in 0..n {
        let off = torques.iter().map(|[truth, f]| ((f[joint] - truth[joint]) / truth[joint]).abs());
        worst_percent.push(100.0 * off.fold(0.0, f64::max));
        let line = |label, mark, colour, which: usize| {
            let points = speeds.iter().zip(&torques).map(|(&v, both)| [v, both[which][joint]]);
            Series::new(label, mark, colour, points.collect())
        };
        let series = vec![
            line("plant", Mark::BroadLine, Colour::Measured, 0),
            line("model", Mark::Line, Colour::Series(0), 1),
        ];
        let guides = [-DEAD_ZONE, DEAD_ZONE].map(|at| Guide::at_x(at, "")).to_vec();
        let axes = ["speed [rad/s]", "friction [N·m]"];
        let chart = Chart::over(format!("Joint {}: friction", joint + 1), axes, series);
        study.figures[0].charts.push(Chart { guides, ..chart });
    }
    study.tables[0].push(&["".into()], worst_percent);
    Ok(())
}

/// The torque that a motion takes, and what each step predicts of it.
fn steps(plant: &Plant, model: &Model, wanted: &Motion, study: &mut Study) -> Result {
    let rows: Vec<usize> = (0..wanted.n_rows()).step_by(SHOWN).collect();
    let states = rows.iter().map(|&row| wanted.state(row));
    let needed: Vec<Vec<f64>> =
        states.map(|[q, dq, ddq]| plant.needed_torque(&q, &dq, &ddq)).collect();
    let mut signals = wanted.select(&rows).into_signals();
    signals.tau = Some(Mat::from_fn(rows.len(), needed[0].len(), |row, j| needed[row][j]));
    let motion = Motion::new(signals)?;
    let steps = trial::steps(model, sharp, &motion)?;
    for step in &steps {
        study.tables[1].push(&[step.name.clone().into()], step.nrmse_percent.iter().copied());
    }
    let predicted = step_lines(steps);
    study.figures[1].charts = torque_charts(("needed", &motion), 1, &predicted, Some("control"))?;
    Ok(())
}

/// PID, controllers 1 and 2 with the model, and the latter with the truth, all with the gains that
/// follow from the model.
///
/// - `settle`: from when on errors count \[s\]
fn track(plant: &Plant, model: &Model, wanted: &Motion, settle: f64, study: &mut Study) -> Result {
    let known = Learned::new(model)?;
    let learned = [Law::Pid, Law::Controller1, Law::Controller2, Law::ComputedTorque];
    let Runs { runs: found, ran_away, .. } =
        compare(plant, &known, (&learned, true), BANDWIDTH, wanted)?;
    if let Some(&(_, t)) = ran_away.first() {
        return Err(SimError::Diverged { t }.into());
    }
    let pid = found[0].tracking.rms_error(settle);
    let mut worst = Vec::new();
    for (name, found) in NAMES.iter().zip(&found) {
        let errors = found.tracking.rms_error(settle);
        let shares: Vec<f64> = errors.iter().zip(&pid).map(|(error, pid)| error / pid).collect();
        let percent = shares.iter().map(|share| 100.0 * share);
        let errors = errors.iter().map(|error| 1e3 * error);
        study.tables[2].push(&[(*name).into()], errors.chain(percent));
        worst.push(shares.into_iter().fold(0.0, f64::max));
    }
    let values = [1, 2, 4, 5].map(|place: usize| significant(100.0 * worst[place], 2));
    let (first, second) = (worst[1], worst[2]);
    let is_better = second < first && second < 1.0;
    study.claims[0].judge(values, &[is_better, first < 1.0 && second < FEWER * first]);
    let t: Vec<f64> = wanted.t().iter().copied().step_by(SHOWN).collect();
    let of_joint = |joint: usize| {
        // PID, controller 1 and controller 2.
        let series = NAMES.iter().zip(&found).take(3).enumerate().map(|(place, (name, found))| {
            let error = found.tracking.error.col_as_slice(joint).iter().step_by(SHOWN);
            let points = t.iter().zip(error).map(|(&t, &error)| [t, 1e3 * error]);
            Series::new(*name, Mark::Line, Colour::Series(place), points.collect())
        });
        let title = format!("Joint {}: tracking error", joint + 1);
        let chart = Chart::over(title, ["time [s]", "error [mrad]"], series.collect());
        Chart { linked: Some("control".into()), ..chart }
    };
    study.figures[2].charts = (0..wanted.n_joints()).map(of_joint).collect();
    Ok(())
}
