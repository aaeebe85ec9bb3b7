//! Model, log → torque, whole and in parts.

use crate::files::{check_output, read_model};
use crate::interrupt::Shield;
use crate::outcome::Outcome;
use crate::progress::Watched;
use crate::recorded::ProfileArguments;
use crate::table::{Table, number};
use crate::training_range::AskedRange;
use anyhow::{Result, anyhow};
use clap::Args;
use faer::Mat;
use serde_json::json;
use std::path::PathBuf;
use torquewise::logs::{Column, ColumnKind, TableWriter, Values};
use torquewise::model::{Model, Torque};
use torquewise::motion::{Motion, ReadError, Recording};

/// Predict the torque of a log, with or without measured torque
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
    #[command(flatten)]
    profile: ProfileArguments,
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

    let _shield = Shield::new();
    let names = column_names(model.n_joints(), arguments.parts);
    let columns: Vec<Column> =
        names.iter().map(|name| Column::new(name.as_str(), ColumnKind::Number)).collect();
    let mut writer = TableWriter::create(&arguments.output, &columns)?;
    let torque = Torque::new(&model);
    let mut asked = AskedRange::new(model.n_joints());
    let mut largest = vec![0.0_f64; model.n_joints()];
    let mut rows = 0;
    Watched::new(&logs, "predicting")
        .of(logs.rows_hint(), 1)
        .read(&mut |_, block| {
            rows += block.n_rows();
            asked.add(block);
            let tau_hat = append(&mut writer, &torque, block, arguments.parts)?;
            for (joint, largest) in largest.iter_mut().enumerate() {
                *largest = tau_hat.col(joint).iter().fold(*largest, |l, tau| l.max(tau.abs()));
            }
            Ok(())
        })
        .map_err(|error| anyhow!(error))?;
    writer.finish()?;
    Ok(outcome(arguments, &model, rows, &largest, &names, &asked))
}

fn column_names(n_joints: usize, parts: bool) -> Vec<String> {
    let signals: &[&str] = if parts {
        &["tau_hat", "inertia", "coriolis", "gravity", "friction"]
    } else {
        &["tau_hat"]
    };
    let numbered = |signal: &&str| {
        let signal = (*signal).to_owned();
        (1..=n_joints).map(move |joint| format!("{signal}{joint}"))
    };
    std::iter::once("t".to_owned()).chain(signals.iter().flat_map(numbered)).collect()
}

/// Writes the torque of a block, and returns it.
fn append(
    writer: &mut TableWriter,
    torque: &Torque,
    block: &Motion,
    with_parts: bool,
) -> Result<Mat<f64>, ReadError> {
    let parts = torque.parts(block)?;
    let total = parts.total();
    let mut signals = vec![&total];
    if with_parts {
        signals.extend([&parts.inertia, &parts.coriolis, &parts.gravity, &parts.friction]);
    }
    let joints = 0..block.n_joints();
    let columns = signals
        .iter()
        .flat_map(|signal| joints.clone().map(|joint| Values::Numbers(signal.col_as_slice(joint))));
    let values: Vec<Values<'_>> =
        std::iter::once(Values::Numbers(block.t())).chain(columns).collect();
    writer.append(&values)?;
    Ok(total)
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
    Outcome { text, json, warnings: asked.warnings(model) }
}
