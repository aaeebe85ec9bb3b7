//! From model of an arm with friction to torque after each step, friction, tracking (Fig. 10, 11).

use crate::error::ExperimentError;
use crate::settings::Settings;
use crate::study::recorded::{RATE, learn, plant, recordings};
use serde::Serialize;
use torquewise_model::{Model, Parts, Torque};
use torquewise_motion::Motion;
use torquewise_sim::control::knowledge::sharp;
use torquewise_sim::control::{
    Gains, Law, Learned, Periodic, Plant, compare, mean_inertia, periodic,
};

/// Bandwidth of the feedback of all controllers \[rad/s\].
const BANDWIDTH: f64 = 15.0;
/// Speeds at which friction is judged, a decade and a half of them \[rad/s\].
const SPEEDS: usize = 60;
/// Below this speed \[rad/s\] friction is not judged: there the learner smooths its reversal.
pub(crate) const DEAD_ZONE: f64 = 0.06;
/// Highest of those speeds \[rad/s\].
const FASTEST: f64 = 1.2;
/// Every so many ticks one is kept for figures.
const SHOWN: usize = 20;

/// The experiment of the paper, whole, in simulation.
#[derive(Clone, Debug, Serialize)]
pub struct ControlResults {
    /// Rows of each recording, as the learner sees them.
    pub rows: Vec<usize>,
    /// Bandwidth of the feedback \[rad/s\].
    pub bandwidth: f64,
    /// Friction of each joint.
    pub friction: Vec<FrictionCurve>,
    /// Instants of what is shown \[s\].
    pub t: Vec<f64>,
    /// Torque that the desired motion takes \[N·m\], n × m.
    pub needed: Vec<Vec<f64>>,
    /// What each step predicts of it.
    pub steps: Vec<StepTorque>,
    /// What each controller does.
    pub tracking: Vec<ControllerResults>,
}

/// Friction of a joint, true and learned, outside the dead zone.
#[derive(Clone, Debug, Serialize)]
pub struct FrictionCurve {
    /// Speeds of both directions \[rad/s\].
    pub speed: Vec<f64>,
    /// f(v) of the plant \[N·m\].
    pub truth: Vec<f64>,
    /// f(v) of the model \[N·m\].
    pub learned: Vec<f64>,
    /// Largest difference as a share of the truth \[%\].
    pub worst_percent: f64,
}

/// The torque that is predicted after a step.
#[derive(Clone, Debug, Serialize)]
pub struct StepTorque {
    /// What is known after it.
    pub name: String,
    /// Torque \[N·m\], n × m.
    pub torque: Vec<Vec<f64>>,
    /// Its error, RMSE over the spread of the torque \[%\], per joint.
    pub nrmse_percent: Vec<f64>,
}

/// How well a controller tracks.
#[derive(Clone, Debug, Serialize)]
pub struct ControllerResults {
    /// Which one, and what it knows.
    pub name: String,
    /// RMS of the position error in the second period \[rad\], per joint.
    pub rms_error_rad: Vec<f64>,
    /// Position error \[rad\], n × m.
    pub error: Vec<Vec<f64>>,
}

/// Records, learns, predicts and controls.
pub(crate) fn study_control(settings: &Settings) -> Result<ControlResults, ExperimentError> {
    let plant = plant(settings)?;
    let recordings = recordings(&plant, settings)?;
    let model = learn(&recordings)?.model;
    let plan = Periodic { rate: RATE, seed: settings.seed, ..Periodic::default() };
    let wanted = periodic(&plant.arm, &plan)?;
    let shown: Vec<usize> = (0..wanted.n_rows()).step_by(SHOWN).collect();
    let shown = wanted.select(&shown);
    let needed = needed(&plant, &shown);
    Ok(ControlResults {
        rows: recordings.iter().map(Motion::n_rows).collect(),
        bandwidth: BANDWIDTH,
        friction: friction(&plant, &Torque::new(&sharp(&model)))?,
        t: shown.t().to_vec(),
        steps: steps(&model, &shown, &needed)?,
        needed,
        tracking: tracking(&plant, &model, &wanted, plan.seconds - plan.period)?,
    })
}

/// The torque that the plant needs for a motion, n × m.
fn needed(plant: &Plant, motion: &Motion) -> Vec<Vec<f64>> {
    let mut needed = vec![Vec::with_capacity(motion.n_rows()); motion.n_joints()];
    for row in 0..motion.n_rows() {
        let [q, dq, ddq] = [motion.q(), motion.dq(), motion.ddq()]
            .map(|x| x.row(row).iter().copied().collect::<Vec<f64>>());
        for (needed, tau) in needed.iter_mut().zip(plant.needed_torque(&q, &dq, &ddq)) {
            needed.push(tau);
        }
    }
    needed
}

/// f(v) of each joint at speeds from the dead zone on, both ways.
fn friction(plant: &Plant, known: &Torque) -> Result<Vec<FrictionCurve>, ExperimentError> {
    let n = plant.arm.n_joints();
    let mut speed: Vec<f64> = (0..SPEEDS)
        .map(|k| DEAD_ZONE * (FASTEST / DEAD_ZONE).powf(k as f64 / (SPEEDS - 1) as f64))
        .flat_map(|speed| [-speed, speed])
        .collect();
    speed.sort_by(f64::total_cmp);
    (0..n)
        .map(|joint| {
            let truth: Vec<f64> = speed.iter().map(|&v| plant.friction.torque(joint, v)).collect();
            let at = |&v: &f64| {
                let mut dq = vec![0.0; n];
                dq[joint] = v;
                Ok(known.friction(&vec![0.0; n], &dq)?[joint])
            };
            let learned = speed.iter().map(at).collect::<Result<Vec<f64>, ExperimentError>>()?;
            let off = truth.iter().zip(&learned).map(|(truth, f)| ((f - truth) / truth).abs());
            let worst_percent = 100.0 * off.fold(0.0, f64::max);
            Ok(FrictionCurve { speed: speed.clone(), truth, learned, worst_percent })
        })
        .collect()
}

/// Torque after each step: of the steps themselves, or, of a model that was found at once, of the
/// parts that the steps are about.
fn steps(
    model: &Model,
    motion: &Motion,
    needed: &[Vec<f64>],
) -> Result<Vec<StepTorque>, ExperimentError> {
    let columns = |tau: &faer::Mat<f64>| -> Vec<Vec<f64>> {
        (0..tau.ncols()).map(|joint| tau.col_as_slice(joint).to_vec()).collect()
    };
    let named = if model.stages.is_empty() {
        let Parts { inertia, coriolis, gravity, friction } =
            Torque::new(&sharp(model)).parts(motion)?;
        let first = &gravity + &friction;
        let second = &first + &coriolis;
        let third = &second + &inertia;
        let names = ["gravity and friction", "and Coriolis", "and inertia"].map(str::to_owned);
        names.into_iter().zip([first, second, third]).collect::<Vec<_>>()
    } else {
        let after = |(place, stage): (usize, &torquewise_model::Stage)| {
            let tau = Torque::new(&sharp(&model.after_step(place + 1)?)).over(motion)?;
            Ok((stage.name.clone(), tau))
        };
        let stages = model.stages.iter().enumerate().map(after);
        stages.collect::<Result<_, ExperimentError>>()?
    };
    let step = |(name, tau): (String, faer::Mat<f64>)| {
        let torque = columns(&tau);
        let nrmse_percent = torque.iter().zip(needed).map(|(tau, needed)| nrmse(tau, needed));
        StepTorque { name, nrmse_percent: nrmse_percent.collect(), torque }
    };
    Ok(named.into_iter().map(step).collect())
}

/// RMSE over the standard deviation of what is needed \[%\].
fn nrmse(found: &[f64], needed: &[f64]) -> f64 {
    let m = needed.len().max(1) as f64;
    let mean = needed.iter().sum::<f64>() / m;
    let spread = needed.iter().map(|tau| (tau - mean).powi(2)).sum::<f64>();
    let wrong = found.iter().zip(needed).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
    100.0 * (wrong / spread).sqrt()
}

/// PID, controllers 1 and 2 with the model, and the latter with the truth, all with the gains that
/// follow from the model.
fn tracking(
    plant: &Plant,
    model: &Model,
    wanted: &Motion,
    settle: f64,
) -> Result<Vec<ControllerResults>, ExperimentError> {
    let known = Learned::new(model)?;
    let gains = Gains::critically_damped(BANDWIDTH, &mean_inertia(&known, wanted)?);
    let learned = [Law::Pid, Law::Controller1, Law::Controller2, Law::ComputedTorque];
    let perfect = [Law::Controller1, Law::Controller2];
    let found = compare(plant, &known, &learned, &gains, wanted)?;
    let best = compare(plant, plant, &perfect, &gains, wanted)?;
    let name = |law: Law| match law {
        Law::Pid => "PID",
        Law::Controller1 => "controller 1",
        Law::Controller2 => "controller 2",
        Law::ComputedTorque => "computed torque",
        Law::HandGuiding => "hand guiding",
    };
    let named = learned.map(|law| name(law).to_owned()).into_iter();
    let named = named.chain(perfect.map(|law| format!("{}, perfect model", name(law))));
    let results = named.zip(found.into_iter().chain(best)).map(|(name, found)| {
        let shown = |joint| found.error.col_as_slice(joint).iter().step_by(SHOWN).copied();
        ControllerResults {
            name,
            rms_error_rad: found.rms_error(settle),
            error: (0..found.error.ncols()).map(|joint| shown(joint).collect()).collect(),
        }
    });
    Ok(results.collect())
}
