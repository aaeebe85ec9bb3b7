//! Why a chain cannot be learned.

/// An error of this crate.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum ChainError {
    /// Signals of different shapes.
    #[error("{what} has {found} entries where {expected} were expected")]
    Shape {
        /// Which signal.
        what: &'static str,
        /// Its entries.
        found: usize,
        /// What the others ask for.
        expected: usize,
    },
    /// Too little to learn from.
    #[error(
        "{rows} rows of {joints} joints cannot determine a chain: at least {needed} are needed"
    )]
    #[diagnostic(help("record a longer motion"))]
    TooFewRows {
        /// Rows at hand.
        rows: usize,
        /// Joints of the arm.
        joints: usize,
        /// Rows needed.
        needed: usize,
    },
    /// The normal equations have no solution in floating point.
    #[error("the normal equations of the chain cannot be solved")]
    #[diagnostic(help("look for joints that never move and for values that are not finite"))]
    Singular,
    /// Whoever watched stopped the work.
    #[error("stopped")]
    Stopped,
    /// More joints than the recursion holds.
    #[error("a chain of {joints} joints is too long; at most {most} joints")]
    TooManyJoints {
        /// Joints of the arm.
        joints: usize,
        /// Joints at most.
        most: usize,
    },
}
