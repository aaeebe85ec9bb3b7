//! What can keep a log from becoming a model.
#![expect(missing_docs, reason = "each message explains its fields")]

use torquewise_model::{JointKinds, ModelError};
use torquewise_motion::{MotionError, ReadError};
use torquewise_regression::SparseError;

/// Why no model could be made or scored.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum IdentifyError {
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Motion(#[from] MotionError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Model(#[from] ModelError),
    #[error("the log has {rows} rows, at least {needed} are needed to fit {joints} joints")]
    #[diagnostic(help("record a longer motion"))]
    TooFewRows { rows: usize, needed: usize, joints: usize },
    #[error("the log has {windows} windows to be simulated, at least {needed} are needed")]
    #[diagnostic(help("record a longer motion without gaps, or do not refine by rollouts"))]
    TooFewWindows { windows: usize, needed: usize },
    #[error("sums of logs cannot be refined by rollouts, which need the logs themselves")]
    #[diagnostic(help("fit the logs at once, or do not refine"))]
    RolloutsOfSums,
    #[error("the regression of step {step} failed")]
    #[diagnostic(help("record more rows of this pattern, or fit in one shot by the method sindy"))]
    Step { step: String, source: SparseError },
    #[error("{0} clusters asked for")]
    #[diagnostic(help("ask for at least 1 and at most 9"))]
    Clusters(usize),
    #[error("the library has {candidates} candidates, which takes {gigabytes} GB of sums")]
    #[diagnostic(help(
        "an arm of so many joints wants a learned chain, which has no orders; or lower the orders \
         and interactions of the library to {limit} candidates at most"
    ))]
    LibraryTooLarge { candidates: usize, gigabytes: usize, limit: usize },
    #[error("cannot merge summaries: {what} differs, {expected} and {found}")]
    #[diagnostic(help(
        "make both with the same settings; a cut-off that a log chooses for itself is its own: give one"
    ))]
    Apart { what: &'static str, expected: String, found: String },
    #[error("not a valid moments file, {0}")]
    #[diagnostic(help("make the file of moments again"))]
    Moments(String),
    #[error("the moments are for a learned chain and hold no sums of a library")]
    #[diagnostic(help(
        "make them again with the library energy or product, or learn a chain from them"
    ))]
    NoLibrary,
    #[error("the torque columns, as they are, show no load: {found:.2e} ± {error:.2e} kg")]
    #[diagnostic(help(
        "give a log of the arm with the load, held in many poses, far out and near, its centre where it is \
         known, and a model of which a URDF says where the axes lie"
    ))]
    NoLoad { found: f64, error: f64 },
    #[error("the counterbalanced joint {name} is not in the log, which has {joints}")]
    #[diagnostic(help("name one of these"))]
    NoSuchJoint { name: String, joints: String },
    #[error("the kinds of joints {kinds} are not those of {joints}")]
    #[diagnostic(help(
        "give a letter for each joint, r where it turns and p where it slides, as a URDF has them where one is given"
    ))]
    Kinds { kinds: String, joints: String },
    #[error("{signal} of {joint} reaches {found:.3e}, which no arm does")]
    #[diagnostic(help(
        "repair or drop such rows, and check the units: where they are degrees, `unit` in a profile says so"
    ))]
    NoMotion { signal: &'static str, joint: String, found: f64 },
    #[error("the torque of {0} never changes")]
    #[diagnostic(help("check that it is measured, or leave the joint out"))]
    ConstantTorque(String),
    #[error("no chain of rigid bodies could be learned: {0}")]
    #[diagnostic(forward(0))]
    Chain(#[from] torquewise_rigid::ChainError),
    #[error("the model has no covariance of an arm's parameters to draw from")]
    #[diagnostic(help("fit a learned chain, library chain; other models have none"))]
    NoScatter,
    #[error("stopped")]
    Stopped,
    #[error("the numbers of the log cannot be worked with")]
    #[diagnostic(help(
        "check that its units are rad, s and N·m and that every signal is measured"
    ))]
    Sparse(#[from] SparseError),
}

impl IdentifyError {
    /// Fails unless kinds are those of as many joints as a log has.
    pub(crate) fn check_kinds(kinds: &JointKinds, joints: &[String]) -> Result<(), Self> {
        if kinds.fit(joints.len()) {
            return Ok(());
        }
        Err(Self::Kinds { kinds: kinds.to_string(), joints: joints.join(", ") })
    }
}
