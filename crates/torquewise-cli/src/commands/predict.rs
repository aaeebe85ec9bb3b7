//! The torque of a log, whole and in parts.

use crate::arguments::parsed;
use crate::signal_arguments::SignalArguments;
use crate::{Outcome, Result, TABLES, Table, check_files, read_model, staged, watch};
use clap::Args;
use faer::Mat;
use serde_json::json;
use std::path::PathBuf;
use torquewise::logs::{Column, TableWriter, Values};
use torquewise::model::friction::FrictionLaw;
use torquewise::model::units::heading;
use torquewise::model::{FrictionTerm, Model, Parts, Torque, Weighted, number};
use torquewise::motion::{Motion, ReadError, Recording, Signals};
use torquewise::predict::{Interval, MotionRange};
use torquewise::summary::{all_repairs, repairs_text};
use torquewise::{Prepared, Rows};

/// Predict the torque of a log, with or without measured torque, or at one pose
///
/// Columns are t and tau_hat of each joint; where the log has torque, tau_measured, filtered as the
/// motion, and residual = tau_measured − tau_hat too; outside_range is 1 where a joint leaves the range
/// the model was fitted on, else 0. Ends where a filter has not settled are left out.
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Model file
    model: PathBuf,
    /// Log of the arm
    #[arg(required_unless_present = "q")]
    log: Option<PathBuf>,
    /// Table to write, .csv or .parquet
    #[arg(help_heading = "Output", short, long, value_name = "FILE")]
    #[arg(required_unless_present = "q")]
    output: Option<PathBuf>,
    /// Add the columns inertia, coriolis, gravity and friction of each joint
    #[arg(help_heading = "Output", long)]
    parts: bool,
    /// Predict with what was known after this step
    #[arg(help_heading = "Output", long, value_name = "1|2|3", value_parser = clap::value_parser!(u8).range(1..=3))]
    step: Option<u8>,
    /// Add the columns tau_low and tau_high of each joint, between which this percentage of
    /// measured torques should lie
    #[arg(help_heading = "Output", long, value_name = "PERCENT", value_parser = clap::value_parser!(u8).range(1..=99))]
    interval: Option<u8>,
    /// Print the torque at these positions of the joints [rad], without a log
    #[arg(long, value_name = "Q1,Q2,…", value_delimiter = ',', allow_hyphen_values = true)]
    #[arg(value_parser = number_of, conflicts_with_all = ["log", "output", "parts", "interval", "profile"])]
    #[arg(conflicts_with_all = ["topic", "repair", "filter", "delay"])]
    q: Option<Vec<f64>>,
    /// Velocities there [rad/s]; 0 if left out
    #[arg(long, value_name = "DQ1,…", value_delimiter = ',', allow_hyphen_values = true)]
    #[arg(value_parser = number_of, requires = "q")]
    dq: Option<Vec<f64>>,
    /// Accelerations there [rad/s²]; 0 if left out
    #[arg(long, value_name = "DDQ1,…", value_delimiter = ',', allow_hyphen_values = true)]
    #[arg(value_parser = number_of, requires = "q")]
    ddq: Option<Vec<f64>>,
    #[command(flatten)]
    signals: SignalArguments,
}

fn number_of(text: &str) -> Result<f64, String> {
    parsed(text, |x: &f64| x.is_finite(), "expected a number for each joint, as 0.3,-0.5")
}

/// The torque at one state, whole and in parts; friction as after a long way in the direction of dq.
fn at_pose(model: &Model, pose: [&Option<Vec<f64>>; 3]) -> Result<Outcome> {
    let n = model.n_joints();
    let [q, dq, ddq] = pose.map(|own| own.clone().unwrap_or(vec![0.0; n]));
    let torque = Torque::new(model);
    let row = |x: &[f64]| Mat::from_fn(1, n, |_, joint| x[joint]);
    let tau = row(&torque.at(&q, &dq, &ddq)?);
    let friction = row(&torque.friction(&q, &dq)?);
    let (t, joints, speeds) = (vec![0.0], model.joints.clone(), dq.clone());
    let signals = Signals { joints, t, q: row(&q), dq: row(&dq), ddq: row(&ddq), tau: None };
    let motion = Motion::new(signals)?;
    let Parts { inertia, coriolis, gravity, .. } = torque.parts(&motion)?;
    let words = ["tau", "inertia", "coriolis", "gravity", "friction"];
    let all = [tau, inertia, coriolis, gravity, friction];
    let headings = words.map(|word| heading(&model.kinds(), &format!("{word} [N·m]")));
    let mut table = Table::new(std::iter::once("joint".to_owned()).chain(headings));
    for (joint, name) in model.joints.iter().enumerate() {
        table.row(name, all.each_ref().map(|part| number(part[(0, joint)])));
    }
    let mut json = json!({ "joints": model.joints });
    for (word, part) in words.into_iter().zip(&all) {
        json[word] = json!(part.row(0).iter().collect::<Vec<_>>());
    }
    let mut range = MotionRange::new(n);
    range.add(&motion);
    let is_at_rest = |own: &Weighted<FrictionTerm>| {
        let is_dry = !matches!(own.term.law, FrictionLaw::Offset | FrictionLaw::Viscous);
        is_dry && own.term.speed(&speeds) == 0.0
    };
    let notes = model.friction.iter().any(is_at_rest).then(|| {
        "dry friction of a joint at rest may be anything within its Coulomb value".to_owned()
    });
    let (text, warnings, notes) =
        (table.text(), range.warnings(model), notes.into_iter().collect());
    Ok(Outcome { text, json, warnings, notes, ..Outcome::default() })
}

pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let files = [Some(&arguments.model), arguments.log.as_ref()].into_iter().flatten();
    check_files(files, arguments.output.iter().map(|file| (file.as_path(), TABLES)))?;
    let whole = read_model(&arguments.model)?;
    let model = match arguments.step {
        Some(step) => whole.after_step(step.into())?,
        None => whole,
    };
    let (Some(log), Some(output)) = (&arguments.log, &arguments.output) else {
        return at_pose(&model, [&arguments.q, &arguments.dq, &arguments.ddq]);
    };
    let log = arguments.signals.open(std::slice::from_ref(log))?;
    model.check_joints(log.joints())?;
    let logs = log.prepare_as(model.training.filter, Rows::Settled)?;

    let interval =
        arguments.interval.map(|percent| Interval::new(&model, logs.rows(), percent.into()));
    let interval = interval.transpose()?;
    let measured = logs.logs().has_tau();
    let written = Written {
        model: &model,
        torque: Torque::new(&model),
        parts: arguments.parts,
        interval,
        measured,
    };
    let columns = written.columns(model.n_joints());
    let mut writer = TableWriter::create(&staged(output)?, &columns)?;
    let mut range = MotionRange::new(model.n_joints());
    let mut largest = vec![0.0_f64; model.n_joints()];
    let mut rows = 0;
    let mut path = written.torque.path();
    logs.watched(&watch(), "predicting").read(&mut |trajectory, block| {
        rows += block.n_rows();
        range.add(block);
        let tau_hat = written.append(&mut writer, &path.follow(trajectory, block))?;
        for (joint, largest) in largest.iter_mut().enumerate() {
            *largest = tau_hat.col(joint).iter().fold(*largest, |l, tau| l.max(tau.abs()));
        }
        Ok(())
    })?;
    writer.finish()?;
    let (file, repairs) = (output.display(), logs.repairs());
    let mut table =
        Table::new(["joint".to_owned(), heading(&model.kinds(), "largest |tau| [N·m]")]);
    for (name, &largest) in model.joints.iter().zip(&largest) {
        table.row(name, [number(largest)]);
    }
    let text = format!("{}\ntorque: {file} ({rows} rows)\n", table.text());
    let json = json!({
        "joints": model.joints,
        "rows": rows,
        "columns": columns.iter().map(|column| &column.name).collect::<Vec<_>>(),
        "largest_torque": largest,
        "file": file.to_string(),
        "conditioning": all_repairs(&repairs),
    });
    let (text, warnings) = (text + &repairs_text(&repairs), range.warnings(&model));
    let notes = left_out(&logs, rows).into_iter().collect();
    Ok(Outcome { text, json, warnings, notes, ..Outcome::default() })
}

/// Tells how many rows were read that are not predicted.
fn left_out(logs: &Prepared, rows: usize) -> Option<String> {
    logs.report().filter(|report| report.trimmed > 0.0)?;
    let rows = logs.logs().report().rows.saturating_sub(rows as u64);
    let what = "rows at ends are left out, where the filter has not settled";
    (rows > 0).then(|| format!("{rows} {what}"))
}

struct Written<'a> {
    model: &'a Model,
    torque: Torque,
    /// Whether parts of the torque are.
    parts: bool,
    /// Bounds of the torque, if they are.
    interval: Option<Interval<'a>>,
    /// Whether measured torque and residual are.
    measured: bool,
}

impl Written<'_> {
    fn columns(&self, n_joints: usize) -> Vec<Column> {
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
        let mut columns = Column::of_joints(&signals, n_joints);
        columns.push(Column::new("outside_range", Values::Counts(&[])));
        columns
    }

    fn append(&self, writer: &mut TableWriter, block: &Motion) -> Result<Mat<f64>, ReadError> {
        let parts = self.torque.parts(block)?;
        let total = parts.total();
        let is_finite = |row: &usize| total.row(*row).iter().all(|tau| tau.is_finite());
        if let Some(row) = (0..total.nrows()).find(|row| !is_finite(row)) {
            return Err(torquewise::Error::NotFinite { t: block.t()[row] }.into());
        }
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
        let outside = MotionRange::outside(self.model, block);
        let outside: Vec<u64> = outside.into_iter().map(u64::from).collect();
        let values: Vec<Values<'_>> = std::iter::once(Values::Numbers(block.t()))
            .chain(columns)
            .chain([Values::Counts(&outside)])
            .collect();
        writer.append(&values)?;
        Ok(total)
    }
}
