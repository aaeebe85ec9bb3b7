//! What can keep a figure or a report from being made.
#![expect(missing_docs, reason = "each message explains its fields")]

/// Why there is no figure or report.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum ReportError {
    #[error(
        "{signal} is {rows}x{columns}, expected {expected_rows}x{expected_columns}: \
         give one row per time stamp and one column per joint"
    )]
    Shape {
        signal: String,
        rows: usize,
        columns: usize,
        expected_rows: usize,
        expected_columns: usize,
    },
    #[error(
        "a figure of {rows} rows and {joints} joints shows nothing: give two rows of one joint"
    )]
    Empty { rows: usize, joints: usize },
    #[error("{signal} is not finite at row {row}: drop the row or repair the signal")]
    NotFinite { signal: String, row: usize },
    #[error("t does not increase at row {row}: sort the rows and drop repeated ones")]
    TimeOrder { row: usize },
    #[error("the figure cannot be drawn, {reason}: check that its values are of ordinary size")]
    Drawing { reason: String },
    #[error("the page cannot be written, {reason}: report this as an error of this program")]
    Page { reason: String },
    #[error("the model after step {step} cannot be evaluated, {reason}: fit it anew")]
    Step { step: usize, reason: String },
}
