//! What can be wrong with a motion.
#![expect(missing_docs, reason = "each message explains its fields")]

/// Why a set of signals is not a motion.
#[derive(Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum MotionError {
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
    #[error("a motion needs at least one joint")]
    NoJoints,
    #[error(
        "{signal}{} is not finite at row {row}: drop the row or repair the signal",
        joint + 1
    )]
    NotFinite { signal: &'static str, joint: usize, row: usize },
    #[error("{0} is missing, and this work needs it")]
    Missing(&'static str),
}
