//! What can keep a log from becoming a model.
#![expect(missing_docs, reason = "each message explains its fields")]

use torquewise_model::ModelError;
use torquewise_motion::{MotionError, ReadError};
use torquewise_regression::SparseError;

/// Why no model could be made or scored.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IdentifyError {
    #[error(transparent)]
    Read(ReadError),
    #[error(transparent)]
    Motion(#[from] MotionError),
    #[error(transparent)]
    Model(#[from] ModelError),
    #[error(
        "the log has {rows} rows, at least {needed} are needed to fit {joints} joints: \
         record a longer motion"
    )]
    TooFewRows { rows: usize, needed: usize, joints: usize },
    #[error(
        "the regression of step {step} failed: record more rows of this pattern, or fit in one \
         shot with --method sindy"
    )]
    Step { step: String, source: SparseError },
    #[error("{0} clusters asked for: at least 1 and at most 9")]
    Clusters(usize),
    #[error(
        "the library has {candidates} candidates, which takes {gigabytes} GB of sums: \
         limit it to {limit} candidates by a lower interaction order or lower orders, or give no \
         order for an energy library, which is then grown along a learned chain"
    )]
    LibraryTooLarge { candidates: usize, gigabytes: usize, limit: usize },
    #[error(
        "cannot merge summaries: {what} differs, {expected} and {found}; make both with the \
         same settings"
    )]
    Apart { what: &'static str, expected: String, found: String },
    #[error("not a valid moments file, {0}: make the file again with torquewise moments")]
    Moments(String),
    #[error(
        "the moments are for a learned chain and hold no sums of a library: make them again with \
         --library energy or product, or learn a chain"
    )]
    NoLibrary,
    #[error(
        "the counterbalanced joint {name} is not in the log, which has {joints}: name one of these"
    )]
    NoSuchJoint { name: String, joints: String },
    #[error("the torque of {0} never changes: check that it is measured, or leave the joint out")]
    ConstantTorque(String),
    #[error("no chain of rigid bodies could be learned: {0}")]
    Chain(#[from] torquewise_rigid::ChainError),
    #[error(
        "the numbers of the log cannot be worked with: check that its units are rad, s and N·m and \
         that every signal is measured"
    )]
    Sparse(#[from] SparseError),
}
