//! Scores → table, JSON and warnings.

use crate::table::{Table, number};
use serde_json::{Value, json};
use torquewise::diagnose::score::JointScore;
use torquewise::identify::Scores;

/// One line per joint.
pub(crate) fn text(scores: &Scores) -> String {
    let mut table = Table::new(&["joint", "RMSE [N·m]", "NRMSE [%]", "R²"]);
    for JointScore { name, rmse, nrmse_percent, r2 } in &scores.joints {
        table.row(name, [number(*rmse), number(*nrmse_percent), format!("{r2:.6}")]);
    }
    table.text()
}

/// Joints and number of rows.
pub(crate) fn json(scores: &Scores) -> Value {
    let joint = |joint: &JointScore| -> Value {
        let JointScore { name, rmse, nrmse_percent, r2 } = joint;
        json!({ "name": name, "rmse": rmse, "nrmse_percent": nrmse_percent, "r2": r2 })
    };
    json!({ "joints": scores.joints.iter().map(joint).collect::<Vec<_>>(), "rows": scores.rows })
}

/// Joints whose scores mean little.
pub(crate) fn warnings(scores: &Scores) -> Vec<String> {
    let still = scores.joints.iter().filter(|joint| !joint.nrmse_percent.is_finite());
    still
        .map(|joint| format!("the torque of {} never changes: look at its RMSE only", joint.name))
        .collect()
}
