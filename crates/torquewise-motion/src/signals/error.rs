//! Errors of conditioning raw signals.
#![expect(missing_docs, reason = "each message explains its fields")]

use crate::MotionError;

/// Why raw signals cannot be conditioned.
#[derive(Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum SignalError {
    #[error("cannot condition {signal} of joint {joint}")]
    Joint { signal: &'static str, joint: String, source: Box<SignalError> },
    #[error("not finite at row {row}: drop the row or repair the signal")]
    NotFinite { row: usize },
    #[error(
        "{rows} rows are too few, at least {needed} are needed: \
         record longer, or raise the cut-off or lower the order of the filter"
    )]
    TooFewRows { rows: usize, needed: usize },
    #[error(
        "{signal} is {rows}x{columns}, expected {expected_rows}x{expected_columns}: \
         every signal has one row per time stamp and one column per joint"
    )]
    Shape {
        signal: &'static str,
        rows: usize,
        columns: usize,
        expected_rows: usize,
        expected_columns: usize,
    },
    #[error("t does not increase at row {row}: sort the rows and drop repeated ones")]
    TimeOrder { row: usize },
    #[error(
        "t has a gap of {gap} s at row {row}, with a usual step of {step} s the even grid would \
         have {rows} rows: cut the trajectory there"
    )]
    Gap { row: usize, gap: f64, step: f64, rows: f64 },
    #[error(
        "the first part of the log is evenly stamped, but not the part around row {row}: \
         plan from a part that shows it, or cut the trajectory at gaps"
    )]
    Uneven { row: usize },
    #[error(
        "no low-pass filter with a cut-off of {cutoff} Hz at {rate} Hz: \
         the cut-off must be above 0 and below half the rate"
    )]
    Cutoff { cutoff: f64, rate: f64 },
    #[error("no filter of order {order}: take one from 1 to {limit}, 4 is usual")]
    Order { order: usize, limit: usize },
    #[error("{what} is {value}: it must be {expected}")]
    Setting { what: &'static str, value: f64, expected: &'static str },
    #[error("{what} needs measured {signal}, the log has none: derive it from position")]
    Missing { what: &'static str, signal: &'static str },
    #[error("nothing is left of {rows} rows after trimming: record longer, or trim less")]
    NothingLeft { rows: usize },
    #[error(
        "a block has other joints or signals than the first: \
         feed the blocks of one trajectory to one conditioner"
    )]
    Block,
    #[error("the conditioned signals are no motion")]
    Motion(#[from] MotionError),
}

impl SignalError {
    /// Whether a trajectory is too short to be filtered.
    pub fn is_too_short(&self) -> bool {
        match self {
            Self::TooFewRows { .. } | Self::NothingLeft { .. } => true,
            Self::Joint { source, .. } => source.is_too_short(),
            _ => false,
        }
    }

    /// Says which signal of which joint this is about.
    pub(crate) fn of(self, signal: &'static str, joint: &str) -> Self {
        Self::Joint { signal, joint: joint.to_owned(), source: Box::new(self) }
    }
}
