//! Scores → table, JSON and warnings.

use crate::table::{Table, number};
use serde_json::{Value, json};
use torquewise::diagnose::score::JointScore;
use torquewise::identify::Scores;

/// Scores against raw torque.
pub(crate) struct RawScores {
    /// Of the model.
    pub(crate) scores: Scores,
    /// White noise in the torque of each joint \[N·m\], n.
    pub(crate) noise: Vec<f64>,
}

impl RawScores {
    /// What is left of the torque of a joint, and its noise, of its spread \[%\].
    pub(crate) fn percent(&self, joint: usize) -> [f64; 2] {
        let JointScore { nrmse_percent, std, .. } = self.scores.joints[joint];
        [nrmse_percent, 100.0 * self.noise.get(joint).unwrap_or(&f64::NAN) / std]
    }
}

/// One line per joint: errors in the band of the model, and against raw torque if it was filtered.
pub(crate) fn text(scores: &Scores, raw: Option<&RawScores>) -> String {
    let mut names = vec!["joint", "RMSE [N·m]", "NRMSE [%]", "R²"];
    if raw.is_some() {
        names.extend(["of raw torque [%]", "its noise [%]"]);
    }
    let mut table = Table::new(&names);
    for (place, JointScore { name, rmse, nrmse_percent, r2, .. }) in
        scores.joints.iter().enumerate()
    {
        let mut cells = vec![number(*rmse), number(*nrmse_percent), format!("{r2:.6}")];
        if let Some(raw) = raw {
            cells.extend(raw.percent(place).map(number));
        }
        table.row(name, cells);
    }
    table.text()
}

/// Joints, and number of rows, with errors against raw torque: where nothing is filtered, the rows
/// are raw.
pub(crate) fn json_beside_raw(scores: &Scores, raw: Option<&RawScores>) -> Value {
    let mut value = json(scores);
    for (place, joint) in scores.joints.iter().enumerate() {
        let own = &mut value["joints"][place];
        match raw.map(|raw| raw.percent(place)) {
            Some([error, noise]) => {
                own["raw_nrmse_percent"] = json!(error);
                own["noise_floor_percent"] = json!(noise);
            }
            None => own["raw_nrmse_percent"] = json!(joint.nrmse_percent),
        }
    }
    value
}

/// Joints and number of rows.
pub(crate) fn json(scores: &Scores) -> Value {
    let joint = |joint: &JointScore| -> Value {
        let JointScore { name, rmse, nrmse_percent, r2, .. } = joint;
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
