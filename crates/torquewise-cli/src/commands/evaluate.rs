//! Model, logs → scores: RMSE, NRMSE and R² of each joint.

use crate::files::read_model;
use crate::outcome::Outcome;
use crate::progress::Watched;
use crate::table::{Table, number};
use anyhow::Result;
use clap::Args;
use serde_json::{Value, json};
use std::path::PathBuf;
use torquewise::identify::score::{JointScore, score};
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

    let mut table = Table::new(&["joint", "RMSE [N·m]", "NRMSE [%]", "R²"]);
    let mut warnings = Vec::new();
    for JointScore { name, rmse, nrmse_percent, r2 } in &scores.joints {
        table.row(name, [number(*rmse), number(*nrmse_percent), format!("{r2:.6}")]);
        if !nrmse_percent.is_finite() {
            warnings.push(format!("the torque of {name} never changes: look at its RMSE only"));
        }
    }
    let joint = |joint: &JointScore| -> Value {
        let JointScore { name, rmse, nrmse_percent, r2 } = joint;
        json!({ "name": name, "rmse": rmse, "nrmse_percent": nrmse_percent, "r2": r2 })
    };
    let json = json!({
        "joints": scores.joints.iter().map(joint).collect::<Vec<_>>(),
        "rows": scores.rows,
    });
    let text = format!("{}\n{} rows\n", table.text(), scores.rows);
    Ok(Outcome { text, json, warnings })
}
