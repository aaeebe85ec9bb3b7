//! How well a model predicts the torque of logs.

use crate::conditioning;
use crate::error::Result;
use crate::files::read_model;
use crate::outcome::{Outcome, object};
use crate::progress::watch;
use crate::score_table;
use crate::signal_arguments::SignalArguments;
use clap::Args;
use std::path::PathBuf;
use torquewise::evaluate::{evaluate_prepared, prepare};
use torquewise::summary::AllRepairs;

/// Compare the torque a model predicts with the torque measured
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Model file
    model: PathBuf,
    /// Logs of the arm
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    #[command(flatten)]
    signals: SignalArguments,
}

/// Scores the model.
pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let model = read_model(&arguments.model)?;
    let log = arguments.signals.open(&arguments.logs)?;
    let log = prepare(&model, &log)?;
    let scores = evaluate_prepared(&model, &log, &watch())?;
    let repairs = log.repairs();
    let mut json = object(&scores);
    json["conditioning"] = object(&AllRepairs::of(&repairs));
    Ok(Outcome {
        text: format!(
            "{}{}\n{} rows\n{}",
            log.text(),
            score_table::text(&scores),
            scores.rows,
            conditioning::text(&repairs)
        ),
        json,
        warnings: scores.warnings.into_iter().chain(log.warnings()).collect(),
        notes: scores.notes,
        ..Outcome::default()
    })
}
