//! Errors of a regression problem.
#![expect(missing_docs, reason = "each message explains its fields")]

/// Why a regression problem cannot be worked on.
#[derive(Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum SparseError {
    #[error("{what} has {found} entries, expected {expected}")]
    Shape { what: &'static str, found: usize, expected: usize },
    #[error("{what} is not finite at entry {entry}: filter the log or drop the sample")]
    NotFinite { what: &'static str, entry: usize },
    #[error("{setting} is {found}, expected {expected}: correct it")]
    Setting { setting: &'static str, found: f64, expected: &'static str },
    #[error("column {column} of a problem with {columns}: count columns from 0")]
    Column { column: usize, columns: usize },
    #[error(
        "the Gram matrix is indefinite, the path ends above penalty {lambda}: \
         raise the penalty or correct for less noise"
    )]
    Indefinite { lambda: f64 },
    #[error("{found} is too large for a sum of rows: check the units of the log")]
    OutOfRange { found: f64 },
    #[error("the normal equations cannot be solved: are there values that are not finite?")]
    NotSolvable,
    #[error("{clusters} clusters of {points} points: ask for at least 1 and at most one a point")]
    Clusters { clusters: usize, points: usize },
}
