//! Errors of a model, joint by joint.

use crate::table::Table;
use torquewise::evaluate::{Evaluation, JointEvaluation};
use torquewise::model::number;

/// One line per joint: errors in the band of the model, and against raw torque if it was filtered.
pub(crate) fn text(evaluation: &Evaluation) -> String {
    let joints = &evaluation.joints;
    let is_filtered = joints.iter().any(|joint| joint.noise_floor_percent.is_some());
    let mut names = vec!["joint", "RMSE [N·m]", "NRMSE [%]", "R²"];
    if is_filtered {
        names.extend(["of raw torque [%]", "its noise [%]"]);
    }
    let mut table = Table::new(&names);
    for JointEvaluation { name, rmse, nrmse_percent, r2, raw_nrmse_percent, noise_floor_percent } in
        joints
    {
        let mut cells = vec![number(*rmse), number(*nrmse_percent), format!("{r2:.6}")];
        if is_filtered {
            let raw = [raw_nrmse_percent, noise_floor_percent];
            cells.extend(raw.map(|percent| percent.map_or_else(String::new, number)));
        }
        table.row(name, cells);
    }
    table.text()
}
