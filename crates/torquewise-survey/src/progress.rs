//! From work under way to the stage it is in, for whoever watches.

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
    /// Terms that were not offered are tried (E10).
    OmittedTerms,
    /// All is done.
    Done,
}
