//! Errors of a motion.
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
    #[error(
        "a polynomial of degree {degree} does not fit on {half_window} rows to each side: \
         take a degree of at least 1 and at most twice that number"
    )]
    Window { half_window: usize, degree: usize },
    #[error(
        "derivative {order} of a polynomial of degree {degree} is always zero: \
         take a degree of at least {order}"
    )]
    Order { order: usize, degree: usize },
    #[error(
        "{rows} rows are too few to differentiate, at least {needed} are needed: \
         drop them or record the derivatives"
    )]
    TooFewRows { rows: usize, needed: usize },
    #[error("t does not increase at row {row}: sort the rows and drop repeated ones")]
    TimeOrder { row: usize },
}
