//! The stage that work under way is in, for whoever watches.

use std::fmt;

/// A stage of the work, told when it begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// The log is looked through.
    Survey,
    /// Rows are clustered.
    Patterns,
    /// The geometry of the arm is learned (E8).
    Geometry,
    /// Normal equations are summed.
    Sums,
    /// Terms are selected in a step, counted from 1.
    Step(usize),
    /// The kept terms are fitted on all rows.
    Refit,
    /// All is done.
    Done,
}

impl fmt::Display for Progress {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Survey => out.write_str("looking through the log"),
            Self::Patterns => out.write_str("clustering"),
            Self::Geometry => out.write_str("learning the geometry"),
            Self::Sums => out.write_str("summing"),
            Self::Step(step) => write!(out, "selecting terms, step {step}"),
            Self::Refit => out.write_str("fitting all rows"),
            Self::Done => out.write_str("done"),
        }
    }
}
