//! What can be wrong with a regression problem.
#![expect(missing_docs, reason = "each message explains its fields")]

/// Why a regression problem cannot be worked on.
#[derive(Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum SparseError {
    #[error("{what} has {found} entries, expected {expected}")]
    Shape { what: &'static str, found: usize, expected: usize },
    #[error("{what} is not finite at entry {entry}: filter the log or drop the sample")]
    NotFinite { what: &'static str, entry: usize },
}
