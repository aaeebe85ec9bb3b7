//! Model, logs → scores: RMSE, NRMSE and R² of each joint.

use crate::conditioning;
use crate::files::read_model;
use crate::outcome::Outcome;
use crate::progress::Watched;
use crate::score_table;
use crate::signal_arguments::{ProfileArguments, SignalArguments, Wanted};
use crate::training_range::AskedRange;
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;
use torquewise::diagnose::score::score_along;

/// Compare the torque a model predicts with the torque measured
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Model file
    model: PathBuf,
    /// Logs of the arm
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    #[command(flatten)]
    profile: ProfileArguments,
    #[command(flatten)]
    signals: SignalArguments,
}

/// Scores the model.
pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let model = read_model(&arguments.model)?;
    let logs = arguments.profile.open(&arguments.logs)?;
    model.check_joints(logs.joints())?;
    logs.require_tau()?;
    let logs = arguments.signals.prepare_as(model.training.filter, logs, Wanted::WithRaw)?;
    let mut asked = AskedRange::new(model.n_joints());
    let watched = Watched::new(&logs, "predicting").of(logs.rows_hint(), 1);
    let scores = score_along(&model, &watched, &mut |block| asked.add(block))?;
    let raw = logs.raw_scores(&model)?;
    let repairs = logs.repairs();
    let mut json = score_table::json_beside_raw(&scores, raw.as_ref());
    json["conditioning"] = conditioning::json(&repairs);
    Ok(Outcome {
        text: format!(
            "{}{}\n{} rows\n{}",
            logs.text(),
            score_table::text(&scores, raw.as_ref()),
            scores.rows,
            conditioning::text(&repairs)
        ),
        json,
        warnings: score_table::warnings(&scores).into_iter().chain(logs.warnings()).collect(),
        notes: asked.warnings(&model),
    })
}
