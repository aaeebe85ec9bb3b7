//! What dry friction holds of the torque of joints that rest: no contact is told from it (E16).

use faer::Mat;
use torquewise_model::{Model, ModelError, Torque};
use torquewise_motion::{Motion, Signals};
use torquewise_stepwise::IdentifyError;

/// What dry friction may hold at the rows of a motion \[N·m\], either way, m×n.
pub(super) fn held(torque: &Torque, motion: &Motion) -> Result<Mat<f64>, ModelError> {
    let [least, most] = torque.held(motion)?;
    Ok(Mat::from_fn(motion.n_rows(), motion.n_joints(), |row, joint| {
        most[(row, joint)].max(-least[(row, joint)])
    }))
}

/// The same at rest in the middle of the range that a model was fitted to, n.
pub(super) fn held_at_rest(model: &Model) -> Result<Vec<f64>, IdentifyError> {
    let n = model.n_joints();
    let middle =
        |joint: usize| model.training.q_range.get(joint).map_or(0.0, |[a, b]| 0.5 * (a + b));
    let still = Mat::zeros(1, n);
    let motion = Motion::new(Signals {
        joints: model.joints.clone(),
        t: vec![0.0],
        q: Mat::from_fn(1, n, |_, joint| middle(joint)),
        dq: still.clone(),
        ddq: still,
        tau: None,
    })?;
    let held = held(&Torque::new(model), &motion)?;
    Ok(held.row(0).iter().copied().collect())
}
