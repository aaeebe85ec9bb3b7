//! Errors of a model, joint by joint.

use crate::Table;
use torquewise::Evaluation;
use torquewise::model::rollout::Drift;
use torquewise::model::units::heading;
use torquewise::model::{JointKinds, number};

/// One line per joint: errors in the band of the model, and against raw torque if it was filtered.
pub(crate) fn text(evaluation: &Evaluation, kinds: &JointKinds) -> String {
    let joints = &evaluation.joints;
    let is_filtered = joints.iter().any(|joint| joint.noise_floor_percent.is_some());
    let rmse = heading(kinds, "RMSE [N·m]");
    let mut names = vec!["joint", &rmse, "NRMSE [%]", "R²"];
    if is_filtered {
        names.extend(["of raw torque [%]", "its noise [%]"]);
    }
    let covered = evaluation.interval_coverage_percent.as_ref();
    names.extend(covered.map(|_| "in 95 % interval [%]"));
    let mut table = Table::new(names);
    for (place, joint) in joints.iter().enumerate() {
        let errors = [joint.rmse, joint.nrmse_percent].map(number).into_iter();
        let mut cells: Vec<String> = errors.chain([format!("{:.6}", joint.r2)]).collect();
        if is_filtered {
            let raw = [joint.raw_nrmse_percent, joint.noise_floor_percent];
            cells.extend(raw.map(|percent| percent.map_or_else(String::new, number)));
        }
        cells.extend(covered.map(|covered| format!("{:.1}", covered[place])));
        table.row(&joint.name, cells);
    }
    table.text()
}

/// One line per joint: how far simulated windows drift, beside an arm that keeps its velocity.
pub(crate) fn rollouts(evaluation: &Evaluation, kinds: &JointKinds) -> String {
    let Some(first) = evaluation.rollouts.first() else { return String::new() };
    let horizons = evaluation.rollouts.iter();
    let names = horizons.flat_map(|drift| {
        let band = drift.covered.as_ref().map(|_| "in band [%]".to_owned());
        [format!("after {} s", drift.horizon_s), "held".into()].into_iter().chain(band)
    });
    let mut table = Table::new(["joint".into()].into_iter().chain(names));
    for (joint, of) in evaluation.joints.iter().enumerate() {
        let all = |drift: &Drift| {
            let band = drift.covered.as_ref().map(|covered| 100.0 * covered[joint]);
            [drift.rms_drift_rad[joint], drift.hold_rms_rad[joint]].into_iter().chain(band)
        };
        let cells: Vec<String> = evaluation.rollouts.iter().flat_map(all).map(number).collect();
        table.row(&of.name, cells);
    }
    let windows = first.windows;
    format!(
        "\n{}, beside holding the velocity\n{}",
        heading(kinds, &format!("drift of {windows} simulated windows, RMS [rad]")),
        table.text()
    )
}
