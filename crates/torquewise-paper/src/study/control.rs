//! An arm with friction, recorded, learned and controlled: friction, torque after each step, tracking
//! (Fig. 10, 11).

use crate::charts::{after_step, points, torque_chart};
use crate::error::PaperError;
use crate::results::{Cell, Claim, Figure, Study, Table, Verdict};
use crate::settings::Settings;
use crate::study::recorded::{RATE, learn, plant, recordings};
use torquewise_model::{Model, Parts, Torque};
use torquewise_motion::Motion;
use torquewise_report::html::number::significant;
use torquewise_report::html::{Axis, Chart, Colour, Guide, Mark, Series};
use torquewise_sim::control::knowledge::sharp;
use torquewise_sim::control::{
    Gains, Law, Learned, Periodic, Plant, compare, mean_inertia, periodic,
};

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
/// Controllers that are drawn.
const DRAWN: [&str; 3] = ["PID", "controller 1", "controller 2"];

/// Friction of a joint, true and learned, outside the dead zone.
struct FrictionCurve {
    /// Speeds of both directions \[rad/s\].
    speed: Vec<f64>,
    /// f(v) of the plant \[N·m\].
    truth: Vec<f64>,
    /// f(v) of the model \[N·m\].
    learned: Vec<f64>,
    /// Largest difference as a share of the truth \[%\].
    worst_percent: f64,
}

/// The torque that is predicted after a step.
struct StepTorque {
    name: String,
    /// Torque \[N·m\], n × m.
    torque: Vec<Vec<f64>>,
    /// Its error, RMSE over the spread of the torque \[%\], per joint.
    nrmse_percent: Vec<f64>,
}

/// How well a controller tracks.
struct Tracked {
    /// Which one, and what it knows.
    name: String,
    /// RMS of the position error in the second period \[rad\], per joint.
    rms_error_rad: Vec<f64>,
    /// Position error \[rad\], n × m.
    error: Vec<Vec<f64>>,
}

/// Records, learns, predicts and controls.
pub(crate) fn study(settings: &Settings) -> Result<Study, PaperError> {
    let plant = plant(settings)?;
    let model = learn(&recordings(&plant, settings)?)?.model;
    let plan = Periodic { rate: RATE, seed: settings.seed, ..Periodic::default() };
    let wanted = periodic(&plant.arm, &plan)?;
    let shown: Vec<usize> = (0..wanted.n_rows()).step_by(SHOWN).collect();
    let shown = wanted.select(&shown);
    let needed = needed(&plant, &shown);
    let friction = friction(&plant, &Torque::new(&sharp(&model)))?;
    let steps = steps(&model, &shown, &needed)?;
    let tracking = tracking(&plant, &model, &wanted, plan.seconds - plan.period)?;
    Ok(Study {
        heading: "In the controller (Fig. 10 and 11)",
        text: "The second half of the paper, in simulation: an arm with rotors, Stribeck friction, \
               encoders of 20 bits and drives that are 1 ms late is moved by velocity controllers, \
               very slowly in both directions, uniformly, then variably. From measured positions \
               and torques alone a model is reconstructed; it then drives the arm at 1 kHz.",
        claims: vec![claim(&tracking)],
        tables: tables(&friction, &steps, &tracking),
        figures: vec![
            friction_figure(&friction),
            steps_figure(shown.t(), &needed, &steps),
            tracking_figure(shown.t(), &tracking),
        ],
        ..Study::default()
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
fn friction(plant: &Plant, known: &Torque) -> Result<Vec<FrictionCurve>, PaperError> {
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
            let learned = speed.iter().map(at).collect::<Result<Vec<f64>, PaperError>>()?;
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
) -> Result<Vec<StepTorque>, PaperError> {
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
        stages.collect::<Result<_, PaperError>>()?
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
) -> Result<Vec<Tracked>, PaperError> {
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
        Tracked {
            name,
            rms_error_rad: found.rms_error(settle),
            error: (0..found.error.ncols()).map(|joint| shown(joint).collect()).collect(),
        }
    });
    Ok(results.collect())
}

/// The error of each joint as a share of that of PID.
fn shares<'a>(tracking: &'a [Tracked], found: &'a Tracked) -> impl Iterator<Item = f64> + 'a {
    found.rms_error_rad.iter().zip(&tracking[0].rms_error_rad).map(|(error, pid)| error / pid)
}

fn claim(tracking: &[Tracked]) -> Claim {
    let share = |name: &str| {
        let found = tracking.iter().find(|found| found.name == name);
        found.map_or(f64::NAN, |found| shares(tracking, found).fold(0.0, f64::max))
    };
    let (first, second) = (share("controller 1"), share("controller 2"));
    let percent = |share: f64| significant(100.0 * share, 2);
    Claim {
        claim: "The model of step 1 in the controller improves tracking over PID significantly, \
                that of step 3 further.",
        source: "Fig. 11, here simulated",
        measured: format!(
            "Error of the worst joint beside PID with the same gains: controller 1 {} %, \
             controller 2 {} %; with a perfect model {} % and {} %.",
            percent(first),
            percent(second),
            percent(share("controller 1, perfect model")),
            percent(share("controller 2, perfect model")),
        ),
        verdict: Verdict::when(
            first < 1.0 && second < FEWER * first,
            second < first && second < 1.0,
        ),
    }
}

fn tables(friction: &[FrictionCurve], steps: &[StepTorque], tracking: &[Tracked]) -> Vec<Table> {
    let n = friction.len();
    let row = |name: String, numbers: &mut dyn Iterator<Item = f64>| {
        std::iter::once(Cell::from(name)).chain(numbers.map(Cell::from)).collect::<Vec<_>>()
    };
    let mut curves = Table::new("Learned friction, from 0.06 rad/s on, both directions.", "")
        .with_joints("largest error of f(v) [%]", n);
    curves.push(row(String::new(), &mut friction.iter().map(|curve| curve.worst_percent)));
    let mut after = Table::new("RMSE over the spread of the torque after each step.", "after")
        .with_joints("error [%]", n);
    for step in steps {
        after.push(row(step.name.clone(), &mut step.nrmse_percent.iter().copied()));
    }
    let mut errors = Table::new(
        "Second period; the same gains for all, critically damped at 15 rad/s by the inertia of \
         the learned model.",
        "controller",
    )
    .with_joints("RMS error [mrad]", n)
    .with_joints("of PID [%]", n);
    for found in tracking {
        let numbers = found.rms_error_rad.iter().map(|error| 1e3 * error);
        let shares = shares(tracking, found).map(|share| 100.0 * share);
        errors.push(row(found.name.clone(), &mut numbers.chain(shares)));
    }
    vec![curves, after, errors]
}

fn friction_figure(friction: &[FrictionCurve]) -> Figure {
    let chart = |(joint, curve): (usize, &FrictionCurve)| {
        let line =
            |label, mark, colour, f| Series::new(label, mark, colour, points(&curve.speed, f));
        Chart {
            title: format!("Joint {}: friction", joint + 1),
            x: Axis::named("speed [rad/s]"),
            y: Axis::named("friction [N·m]"),
            series: vec![
                line("plant", Mark::BroadLine, Colour::Measured, &curve.truth),
                line("model", Mark::Line, Colour::Series(0), &curve.learned),
            ],
            guides: [-DEAD_ZONE, DEAD_ZONE].map(|at| Guide::at_x(at, "")).to_vec(),
            ..Chart::default()
        }
    };
    Figure {
        name: "fig10_friction".into(),
        caption: "Stribeck friction (17), true and learned. Between the dashed lines it is not \
                  judged: a model smooths its reversal there."
            .into(),
        charts: friction.iter().enumerate().map(chart).collect(),
    }
}

fn steps_figure(t: &[f64], needed: &[Vec<f64>], steps: &[StepTorque]) -> Figure {
    let chart = |joint: usize| {
        let after = steps.iter().enumerate().map(|(place, step)| {
            let (label, colour) = after_step(place, &step.name);
            (label, colour, step.torque[joint].as_slice())
        });
        torque_chart(joint, t, &needed[joint], after, "control")
    };
    Figure {
        name: "fig10_control".into(),
        caption: "Fig. 10, simulated with friction: what the motion of the next figure takes, and \
                  what each step predicts of it."
            .into(),
        charts: (0..needed.len()).map(chart).collect(),
    }
}

fn tracking_figure(t: &[f64], tracking: &[Tracked]) -> Figure {
    let chart = |joint: usize| {
        let drawn = tracking.iter().filter(|found| DRAWN.contains(&found.name.as_str()));
        let series = drawn.enumerate().map(|(place, found)| {
            let points = t.iter().zip(&found.error[joint]).map(|(&t, &error)| [t, 1e3 * error]);
            Series::new(&found.name, Mark::Line, Colour::Series(place), points.collect())
        });
        Chart {
            title: format!("Joint {}: tracking error", joint + 1),
            x: Axis::named("time [s]"),
            y: Axis::named("error [mrad]"),
            series: series.collect(),
            linked: Some("control".into()),
            ..Chart::default()
        }
    };
    Figure {
        name: "fig11_tracking".into(),
        caption: "Fig. 11, simulated: position error with the same gains, of PID, of controller 1 \
                  with what slow motion shows (18), and of controller 2 with the whole model (19), \
                  at 1 kHz. The first period begins with an empty integral and does not count."
            .into(),
        charts: (0..tracking[0].error.len()).map(chart).collect(),
    }
}
