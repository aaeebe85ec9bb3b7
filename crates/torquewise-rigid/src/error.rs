//! Why a chain cannot be learned.
#![expect(missing_docs, reason = "each message explains its fields")]

/// What fails by [`ChainError`].
pub type Result<T, E = ChainError> = std::result::Result<T, E>;

/// An error of this crate.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum ChainError {
    #[error("{what} has {found} entries where {expected} were expected")]
    Shape { what: &'static str, found: usize, expected: usize },
    #[error(
        "{rows} rows of {joints} joints cannot determine a chain: at least {needed} are needed"
    )]
    #[diagnostic(help("record a longer motion"))]
    TooFewRows { rows: usize, joints: usize, needed: usize },
    #[error("the normal equations of the chain cannot be solved")]
    #[diagnostic(help(
        "inspect the log for joints that never move and values that are not in rad, s and N·m"
    ))]
    Singular,
    #[error("stopped")]
    Stopped,
    #[error("a chain has 1 to {most} joints, not {joints}")]
    TooManyJoints { joints: usize, most: usize },
}

pub(crate) fn expect(what: &'static str, found: usize, expected: usize) -> Result<()> {
    if found == expected { Ok(()) } else { Err(ChainError::Shape { what, found, expected }) }
}
