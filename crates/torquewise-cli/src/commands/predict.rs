//! Model, log → torque, whole and in parts.

use crate::conditioning;
use crate::error::CliError;
use crate::files::{check_output, read_model};
use crate::interrupt::Shield;
use crate::outcome::Outcome;
use crate::progress::Watched;
use crate::signal_arguments::{ProfileArguments, SignalArguments, Wanted};
use crate::table::{Table, number};
use crate::training_range::AskedRange;
use anyhow::{Result, anyhow};
use clap::Args;
use faer::Mat;
use serde_json::json;
use std::path::PathBuf;
use torquewise::logs::{Column, ColumnKind, TableWriter, Values};
use torquewise::model::{Model, RigidChain, Torque};
use torquewise::motion::{Motion, ReadError, Recording};
use torquewise::survey::NoiseFloor;

/// Predict the torque of a log, with or without measured torque
///
/// Columns are t and tau_hat of each joint; where the log has torque, tau_measured, filtered as the
/// motion, and residual = tau_measured − tau_hat too.
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Model file
    model: PathBuf,
    /// Log of the arm
    log: PathBuf,
    /// Table to write, .csv or .parquet
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Add the columns inertia, coriolis, gravity and friction of each joint
    #[arg(long)]
    parts: bool,
    /// Predict with what was known after this step
    #[arg(long, value_name = "1|2|3", value_parser = clap::value_parser!(u8).range(1..=3))]
    step: Option<u8>,
    /// Add the columns tau_low and tau_high of each joint, between which this percentage of
    /// measured torques should lie
    #[arg(long, value_name = "PERCENT", value_parser = clap::value_parser!(u8).range(1..=99))]
    interval: Option<u8>,
    #[command(flatten)]
    profile: ProfileArguments,
    #[command(flatten)]
    signals: SignalArguments,
}

/// Predicts row by row.
pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let inputs = [arguments.model.clone(), arguments.log.clone()];
    check_output(&arguments.output, &inputs)?;
    let whole = read_model(&arguments.model)?;
    let model = match arguments.step {
        Some(step) => whole.after_step(step.into())?,
        None => whole,
    };
    let logs = arguments.profile.open(std::slice::from_ref(&arguments.log))?;
    model.check_joints(logs.joints())?;
    let logs = arguments.signals.prepare_as(model.training.filter, logs, Wanted::EveryRow)?;

    let _shield = Shield::new();
    let interval =
        arguments.interval.map(|percent| Interval::new(&model, &logs, percent)).transpose()?;
    let measured = logs.logs().has_tau();
    let written =
        Written { torque: Torque::new(&model), parts: arguments.parts, interval, measured };
    let names = written.column_names(model.n_joints());
    let columns: Vec<Column> =
        names.iter().map(|name| Column::new(name.as_str(), ColumnKind::Number)).collect();
    let mut writer = TableWriter::create(&arguments.output, &columns)?;
    let mut asked = AskedRange::new(model.n_joints());
    let mut largest = vec![0.0_f64; model.n_joints()];
    let mut rows = 0;
    let mut path = written.torque.path();
    Watched::new(&logs, "predicting")
        .of(logs.rows_hint(), 1)
        .read(&mut |trajectory, block| {
            rows += block.n_rows();
            asked.add(block);
            let tau_hat = written.append(&mut writer, &path.follow(trajectory, block))?;
            for (joint, largest) in largest.iter_mut().enumerate() {
                *largest = tau_hat.col(joint).iter().fold(*largest, |l, tau| l.max(tau.abs()));
            }
            Ok(())
        })
        .map_err(|error| anyhow!(error))?;
    writer.finish()?;
    let mut outcome = outcome(arguments, &model, rows, &largest, &names, &asked);
    let repairs = logs.repairs();
    outcome.text.push_str(&conditioning::text(&repairs));
    outcome.json["conditioning"] = conditioning::json(&repairs);
    Ok(outcome)
}

/// What is written of each row.
struct Written<'a> {
    torque: Torque,
    /// Whether parts of the torque are.
    parts: bool,
    /// Bounds of the torque, if they are.
    interval: Option<Interval<'a>>,
    /// Whether measured torque and residual are.
    measured: bool,
}

impl Written<'_> {
    fn column_names(&self, n_joints: usize) -> Vec<String> {
        let mut signals = vec!["tau_hat"];
        if self.parts {
            signals.extend(["inertia", "coriolis", "gravity", "friction"]);
        }
        if self.interval.is_some() {
            signals.extend(["tau_low", "tau_high"]);
        }
        if self.measured {
            signals.extend(["tau_measured", "residual"]);
        }
        let numbered = |signal: &&str| {
            let signal = (*signal).to_owned();
            (1..=n_joints).map(move |joint| format!("{signal}{joint}"))
        };
        std::iter::once("t".to_owned()).chain(signals.iter().flat_map(numbered)).collect()
    }

    /// Writes the torque of a block, and returns it.
    fn append(&self, writer: &mut TableWriter, block: &Motion) -> Result<Mat<f64>, ReadError> {
        let parts = self.torque.parts(block)?;
        let total = parts.total();
        let mut signals = vec![&total];
        if self.parts {
            signals.extend([&parts.inertia, &parts.coriolis, &parts.gravity, &parts.friction]);
        }
        let bounds = self.interval.as_ref().map(|interval| interval.bounds(block, &total));
        let bounds = bounds.transpose()?;
        signals.extend(bounds.iter().flatten());
        let measured = self.measured.then(|| block.require_tau()).transpose()?;
        let measured = measured.map(|tau| [tau.to_owned(), tau - &total]);
        signals.extend(measured.iter().flatten());
        let joints = 0..block.n_joints();
        let columns = signals.iter().flat_map(|signal| {
            joints.clone().map(|joint| Values::Numbers(signal.col_as_slice(joint)))
        });
        let values: Vec<Values<'_>> =
            std::iter::once(Values::Numbers(block.t())).chain(columns).collect();
        writer.append(&values)?;
        Ok(total)
    }
}

/// What a measured torque is expected within: the parameters are uncertain, noise of the log
/// reaches the prediction, and what the model leaves of the torque is not predicted.
struct Interval<'a> {
    model: &'a Model,
    chain: &'a RigidChain,
    torque: Torque,
    /// Noise of the log \[rad, rad/s, rad/s²\].
    noise: NoiseFloor,
    /// RMS of what else was left of the torque of each joint \[N·m\], n.
    left: &'a [f64],
    /// Deviations of a normal number on either side.
    deviations: f64,
}

impl<'a> Interval<'a> {
    fn new(model: &'a Model, logs: &impl Recording, percent: u8) -> Result<Self> {
        let chain = model.chain.as_ref().filter(|chain| !chain.covariance.is_empty());
        let chain = chain.ok_or_else(|| {
            CliError::Usage(
                "--interval is for models of a chain, which keep the covariance of their \
                 parameters: leave it out, or fit with --library chain"
                    .into(),
            )
        })?;
        let deviations = normal_quantile(0.5 + f64::from(percent) / 200.0);
        let training = &model.training;
        let left = match &training.unexplained_rms[..] {
            [] => &training.residual_rms,
            left => left,
        };
        let noise = NoiseFloor::of(logs).map_err(|error| anyhow!(error))?;
        Ok(Self { model, chain, torque: Torque::new(model), noise, left, deviations })
    }

    /// Lower and upper bounds of the torque \[N·m\], m×n each.
    fn bounds(&self, block: &Motion, total: &Mat<f64>) -> Result<[Mat<f64>; 2], ReadError> {
        let (m, n) = (block.n_rows(), block.n_joints());
        let noise = self.noise.in_torque(&self.torque, block)?;
        let laws = self.torque.laws(block)?;
        let mut half = Mat::zeros(m, n);
        for row in 0..m {
            let state = [block.q(), block.dq(), block.ddq()]
                .map(|x| (0..n).map(|joint| x[(row, joint)]).collect::<Vec<f64>>());
            let state = [&state[0][..], &state[1][..], &state[2][..]];
            let laws: Vec<f64> = laws.row(row).iter().copied().collect();
            let errors = self.chain.std_errors((&self.model.friction, &laws), state)?;
            for (joint, error) in errors.into_iter().enumerate() {
                let left = self.left.get(joint).unwrap_or(&0.0);
                let known = noise[(row, joint)].sqrt();
                half[(row, joint)] = self.deviations * error.hypot(*left).hypot(known);
            }
        }
        Ok([total - &half, total + &half])
    }
}

/// The number that a standard normal one is below with probability `p`, above one half.
///
/// Source: M. Abramowitz, I. Stegun, *Handbook of Mathematical Functions* (1964), 26.2.23; the
/// error is below 5e-4.
fn normal_quantile(p: f64) -> f64 {
    let t = (-2.0 * (1.0 - p).ln()).sqrt();
    let above = 2.515_517 + t * (0.802_853 + t * 0.010_328);
    let below = 1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308));
    t - above / below
}

fn outcome(
    arguments: &Arguments,
    model: &Model,
    rows: usize,
    largest: &[f64],
    columns: &[String],
    asked: &AskedRange,
) -> Outcome {
    let file = arguments.output.display().to_string();
    let mut table = Table::new(&["joint", "largest |tau| [N·m]"]);
    for (name, &largest) in model.joints.iter().zip(largest) {
        table.row(name, [number(largest)]);
    }
    let json = json!({
        "joints": model.joints,
        "rows": rows,
        "columns": columns,
        "largest_torque": largest,
        "file": file,
    });
    let text = format!("{}\ntorque: {file} ({rows} rows)\n", table.text());
    Outcome { notes: Vec::new(), text, json, warnings: asked.warnings(model) }
}
