//! Model, logs → scores: RMSE, NRMSE and R² of each joint.

use crate::files::read_model;
use crate::outcome::Outcome;
use crate::progress::Watched;
use crate::score_table;
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;
use torquewise::identify::score;
use torquewise::logs::Logs;

/// Compare the torque a model predicts with the torque measured
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Model file
    model: PathBuf,
    /// Logs of the arm
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
}

/// Scores the model.
pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let model = read_model(&arguments.model)?;
    let logs = Logs::open(&arguments.logs)?;
    model.check_joints(logs.joints())?;
    logs.require_tau()?;
    let scores = score(&model, &Watched::new(&logs, "predicting"))?;

    Ok(Outcome {
        text: format!("{}\n{} rows\n", score_table::text(&scores), scores.rows),
        json: score_table::json(&scores),
        warnings: score_table::warnings(&scores),
    })
}
