//! RMSE, NRMSE and R² of each joint.

use crate::warning::list;
use torquewise_model::{Model, Torque};
use torquewise_motion::{Motion, Recording};
use torquewise_stepwise::IdentifyError;

/// How well a model predicts the torque of one joint.
#[derive(Clone, Debug, PartialEq)]
pub struct JointScore {
    /// Joint name.
    pub name: String,
    /// RMSE(τ − τ̂) \[N·m\].
    pub rmse: f64,
    /// Standard deviation of τ \[N·m\].
    pub std: f64,
    /// RMSE / std(τ) \[%\]; infinite if the torque never changes.
    pub nrmse_percent: f64,
    /// 1 − RMSE²/var(τ).
    pub r2: f64,
    /// RMS of what dry friction that holds a joint at rest cannot make up for \[N·m\].
    pub unheld_rmse: f64,
}

/// Friction at rest explains most of an error where it leaves less than this part of it.
pub const MOSTLY: f64 = 0.7;

impl JointScore {
    /// RMS of what dry friction at rest may make up for \[N·m\], where that is most of the error.
    pub fn held_rms(&self) -> Option<f64> {
        let held = || (self.rmse.powi(2) - self.unheld_rmse.powi(2)).sqrt();
        (self.unheld_rmse < MOSTLY * self.rmse).then(held)
    }
}

/// What is said of joints that dry friction may hold at rest.
pub fn note_of_rest(joints: &[String]) -> String {
    format!(
        "at rest dry friction may hold {} with any torque up to that at which it breaks away: what it may \
         hold does not count in the verdict",
        list(joints)
    )
}

/// Scores of all joints.
#[derive(Clone, Debug, PartialEq)]
pub struct Scores {
    /// One per joint, n.
    pub joints: Vec<JointScore>,
    /// Rows.
    pub rows: usize,
}

/// Compares predicted with measured torque over a recording, in one pass and fixed memory.
///
/// # Errors
/// [`IdentifyError`]: the reader's message, missing torque, or a model of another arm.
pub fn score(
    model: &Model,
    recording: &(impl Recording + ?Sized),
) -> Result<Scores, IdentifyError> {
    score_along(model, recording, &mut |_, _| {})
}

/// The same where something else is to see each block in that one pass.
///
/// # Errors
/// As [`score`].
pub fn score_along(
    model: &Model,
    recording: &(impl Recording + ?Sized),
    see: &mut dyn FnMut(usize, &Motion),
) -> Result<Scores, IdentifyError> {
    model.check_joints(recording.joints())?;
    let torque = Torque::new(model);
    let n = model.n_joints();
    // First torque, sums of differences to it and their squares, squared errors, and those that friction
    // at rest does not hold.
    let mut sums = vec![[0.0_f64; 5]; n];
    let mut rows = 0_usize;
    let mut path = torque.path();
    recording.read(&mut |trajectory, block| {
        see(trajectory, block);
        let motion = path.follow(trajectory, block);
        let (tau_hat, [least, most]) = (torque.over(&motion)?, torque.held(&motion)?);
        let tau = block.require_tau()?;
        for (joint, [first, sum, squares, errors, unheld]) in sums.iter_mut().enumerate() {
            for row in 0..block.n_rows() {
                if rows == 0 && row == 0 {
                    *first = tau[(row, joint)];
                }
                let centred = tau[(row, joint)] - *first;
                *sum += centred;
                *squares += centred * centred;
                let error = tau[(row, joint)] - tau_hat[(row, joint)];
                *errors += error * error;
                *unheld += (error - error.clamp(least[(row, joint)], most[(row, joint)])).powi(2);
            }
        }
        rows += block.n_rows();
        Ok(())
    })?;
    let m = rows.max(1) as f64;
    let joint = |(name, [_, sum, squares, errors, unheld]): (&String, &[f64; 5])| {
        let variance = (squares / m - (sum / m).powi(2)).max(0.0);
        let rmse = (errors / m).sqrt();
        JointScore {
            name: name.clone(),
            rmse,
            std: variance.sqrt(),
            nrmse_percent: 100.0 * rmse / variance.sqrt(),
            r2: 1.0 - rmse * rmse / variance,
            unheld_rmse: (unheld / m).sqrt(),
        }
    };
    Ok(Scores { joints: recording.joints().iter().zip(&sums).map(joint).collect(), rows })
}
