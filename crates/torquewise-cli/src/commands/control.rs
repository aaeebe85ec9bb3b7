//! `control`: the loop closed at a fixed rate, and how well each controller tracks.

mod report;
mod setup;
mod summary;

use crate::arguments::{Word, choice};
use crate::commands::control::setup::{MotionArguments, PlantArguments};
use crate::files::{read_arm, read_friction};
use crate::{CliError, Outcome, Result, TABLES, check_files, read_model, staged, write_whole};
use clap::Args;
use std::path::{Path, PathBuf};
use torquewise::control::{Law, Learned, Plant, Run, Runs, compare, is_of_joints};
use torquewise::logs::{Column, TableWriter, Values};
use torquewise::model::Model;
use torquewise::motion::Motion;
use torquewise::twin;

/// Close the loop with a model: PID, controller 1 and controller 2 on a simulated arm
///
/// All controllers have the same gains: a joint of the model's mean inertia m alone, with Kp = 3 m
/// w², Ki = m w³ and Kd = 3 m w, is critically damped at the bandwidth w. Controller 1 adds what
/// the model knew after its first step (gravity, and friction if it has any), controller 2 all it
/// knows, both at the desired motion. The arm is simulated with the friction, drives and encoders
/// that are given.
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Model file
    model: PathBuf,
    /// The true arm: built-in (see `torquewise simulate --list`), .urdf file, .toml file with a DH table,
    /// or a model file, which has its own friction
    #[arg(long, value_name = "ARM")]
    arm: String,
    /// Controllers to compare, with commas
    #[arg(help_heading = "Controllers", long, value_parser = choice(&LAWS), value_name = "LAW")]
    #[arg(value_delimiter = ',', default_values = ["pid", "controller1", "controller2"])]
    controllers: Vec<Law>,
    /// Also control with perfect knowledge of arm and friction, by controllers 1 and 2
    #[arg(help_heading = "Controllers", long)]
    perfect: bool,
    /// Bandwidth of the feedback in rad/s
    #[arg(help_heading = "Controllers", long, value_name = "W", default_value_t = 15.0)]
    bandwidth: f64,
    /// Seconds before errors count [default: half of the motion]
    #[arg(help_heading = "Controllers", long, value_name = "S")]
    settle: Option<f64>,
    #[command(flatten)]
    motion: MotionArguments,
    #[command(flatten)]
    plant: PlantArguments,
    /// Table to write with position, error and torque at each tick, .csv or .parquet
    #[arg(help_heading = "Output", short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Figure to write, .svg
    #[arg(help_heading = "Output", long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Page to write, .html
    #[arg(help_heading = "Output", long, value_name = "FILE")]
    report: Option<PathBuf>,
}

const LAWS: [Word<Law>; 5] = [
    ("pid", "Feedback alone", Law::Pid),
    ("controller1", "Feedback, and gravity and friction as known after step 1", Law::Controller1),
    ("controller2", "Feedback and the whole model", Law::Controller2),
    ("computed-torque", "Feedback linearisation with the model", Law::ComputedTorque),
    ("hand-guiding", "The model's gravity alone, while a hand leads the arm", Law::HandGuiding),
];

struct Compared {
    wanted: Motion,
    found: Runs,
    /// When errors begin to count \[s\].
    settle: f64,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let Arguments { output, plot, report, .. } = arguments;
    let mut inputs = vec![arguments.model.clone(), PathBuf::from(&arguments.arm)];
    inputs.extend(arguments.plant.friction.clone());
    let outputs = [(output, TABLES), (plot, &["svg"][..]), (report, &["html"][..])];
    let given = outputs.iter().filter_map(|(file, endings)| Some((file.as_deref()?, *endings)));
    check_files(&inputs, given)?;

    let model = read_model(&arguments.model)?;
    let file = arguments.plant.friction.as_deref();
    let (arm, twin) = read_arm(&arguments.arm, &arguments.plant.lock, file)?;
    if !is_of_joints(&model, &arm) {
        let (model, arm) = (model.joints.join(", "), arm.joints().join(", "));
        return Err(CliError::ModelOfAnotherArm { model, arm });
    }
    let friction = match &twin {
        Some(twin) => twin::friction(twin)?,
        None => read_friction(file, &arm)?,
    };
    let plant = arguments.plant.plant(arm, friction)?;
    let compared = compare_all(arguments, &model, &plant)?;

    if let Some(file) = output {
        write_table(file, &compared)?;
    }
    if let Some(file) = plot {
        write_whole(file, &report::figure(&arguments.arm, &compared)?)?;
    }
    if let Some(file) = report {
        write_whole(file, &report::page(&arguments.arm, &compared)?)?;
    }
    // An arm that is the model itself shows the control alone.
    let is_own = twin.as_ref() == Some(&model);
    let mut outcome = summary::outcome(arguments, &compared, is_own);
    let useless = model.training.useless();
    outcome
        .warnings
        .extend(useless.map(|own| format!("the verdict of the fit of the model is {own}")));
    Ok(outcome)
}

fn compare_all(arguments: &Arguments, model: &Model, plant: &Plant) -> Result<Compared> {
    let wanted = arguments.motion.wanted(&plant.arm)?;
    let seconds = wanted.t().last().copied().unwrap_or_default();
    let settle = arguments.settle.unwrap_or(seconds / 2.0);
    if !(0.0..seconds).contains(&settle) {
        let message = format!("--settle {settle} leaves nothing of {seconds} s: take less");
        return Err(CliError::Usage(message));
    }
    let laws = (&arguments.controllers[..], arguments.perfect);
    let found = compare(plant, &Learned::new(model)?, laws, arguments.bandwidth, &wanted)?;
    Ok(Compared { wanted, found, settle })
}

/// t, then `q1_ref`, …, then `pid_q1`, …, `pid_error1`, …, `pid_tau1`, … of each controller.
fn write_table(file: &Path, compared: &Compared) -> Result<()> {
    let n = compared.wanted.n_joints();
    let q_ref = compared.wanted.q().to_owned();
    let mut names = vec!["t".to_owned()];
    names.extend((1..=n).map(|joint| format!("q{joint}_ref")));
    let Some(first) = compared.found.runs.first() else { return Ok(()) };
    let mut values = vec![Values::Numbers(&first.tracking.t)];
    values.extend((0..n).map(|joint| Values::Numbers(q_ref.col_as_slice(joint))));
    for Run { name, tracking, .. } in &compared.found.runs {
        let signals = [("q", &tracking.q), ("error", &tracking.error), ("tau", &tracking.tau)];
        for (signal, x) in signals {
            names.extend((1..=n).map(|joint| format!("{name}_{signal}{joint}")));
            values.extend((0..n).map(|joint| Values::Numbers(x.col_as_slice(joint))));
        }
    }
    let mut writer = TableWriter::create(&staged(file)?, &Column::numbers(&names))?;
    writer.append(&values)?;
    Ok(writer.finish()?)
}
