//! Errors of a regression problem.
#![expect(missing_docs, reason = "each message explains its fields")]

/// What fails by [`SparseError`].
pub type Result<T, E = SparseError> = std::result::Result<T, E>;

/// Why a regression problem cannot be worked on.
#[derive(Debug, thiserror::Error, miette::Diagnostic, PartialEq)]
#[non_exhaustive]
pub enum SparseError {
    #[error("{what} has {found} entries, expected {expected}")]
    Shape { what: &'static str, found: usize, expected: usize },
    #[error("{what} is not finite at entry {entry}")]
    #[diagnostic(help("filter the log or drop the sample"))]
    NotFinite { what: &'static str, entry: usize },
    #[error("{setting} is {found:?}, expected {expected}")]
    Setting { setting: &'static str, found: f64, expected: &'static str },
    #[error("column {column} of a problem with {columns}")]
    #[diagnostic(help("count columns from 0"))]
    Column { column: usize, columns: usize },
    #[error("{found:e} is too large for a sum of rows")]
    #[diagnostic(help("check the units of the log"))]
    OutOfRange { found: f64 },
    #[error("the normal equations cannot be solved")]
    #[diagnostic(help("check the log for values that are not finite"))]
    NotSolvable,
    #[error("{clusters} clusters of {points} points")]
    #[diagnostic(help("ask for at least 1 cluster and at most one a point"))]
    Clusters { clusters: usize, points: usize },
}

pub(crate) fn expect(what: &'static str, found: usize, expected: usize) -> Result<()> {
    if found == expected { Ok(()) } else { Err(SparseError::Shape { what, found, expected }) }
}
