//! What can keep an arm from being controlled.
#![expect(missing_docs, reason = "each message explains its fields")]

use crate::DynamicsError;
use torquewise_model::ModelError;
use torquewise_motion::MotionError;

/// Why a loop cannot be closed or did not stay closed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ControlError {
    #[error("{what} is for {found} joints, the arm has {expected}: give what belongs together")]
    JointCount { what: &'static str, found: usize, expected: usize },
    #[error("{what} is {found}, expected {expected}")]
    Setting { what: &'static str, found: f64, expected: &'static str },
    #[error("the desired motion is not even in time at row {row}: give one row per control period")]
    Uneven { row: usize },
    #[error("the desired motion has {rows} rows, at least 2 are needed: make it longer")]
    TooShort { rows: usize },
    #[error(
        "the motion of the arm runs away at {t:.3} s: the loop is unstable, lower its bandwidth, \
         or raise the rate or the limits of the torque"
    )]
    Diverged { t: f64 },
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
    #[error(transparent)]
    Model(#[from] ModelError),
    #[error(transparent)]
    Motion(#[from] MotionError),
}

/// Refuses what is made for another number of joints.
pub(crate) fn check_joints(
    what: &'static str,
    found: usize,
    expected: usize,
) -> Result<(), ControlError> {
    if found == expected { Ok(()) } else { Err(ControlError::JointCount { what, found, expected }) }
}

/// Refuses a number that is NaN or outside `[least, most]`.
pub(crate) fn check_between(
    what: &'static str,
    found: f64,
    [least, most]: [f64; 2],
    expected: &'static str,
) -> Result<(), ControlError> {
    if (least..=most).contains(&found) {
        Ok(())
    } else {
        Err(ControlError::Setting { what, found, expected })
    }
}
