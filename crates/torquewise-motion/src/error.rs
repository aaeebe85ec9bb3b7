//! Errors of a motion and of conditioning what was recorded of it.
#![expect(missing_docs, reason = "each message explains its fields")]

use faer::MatRef;

/// What fails by [`MotionError`].
pub type Result<T, E = MotionError> = std::result::Result<T, E>;

/// Why a set of signals is not a motion, or raw signals cannot be conditioned.
#[derive(Debug, thiserror::Error, miette::Diagnostic, PartialEq)]
#[non_exhaustive]
pub enum MotionError {
    #[error("cannot condition {signal} of joint {joint}")]
    #[diagnostic(forward(source))]
    Joint { signal: &'static str, joint: String, source: Box<MotionError> },
    #[error("{signal} is {}x{}, expected {}x{}", found[0], found[1], expected[0], expected[1])]
    #[diagnostic(help("every signal has one row per time stamp and one column per joint"))]
    Shape { signal: &'static str, found: [usize; 2], expected: [usize; 2] },
    #[error("a motion needs at least one joint")]
    NoJoints,
    #[error("{signal}{} is not finite at row {row}", joint + 1)]
    #[diagnostic(help("drop the row or repair the signal"))]
    NotFinite { signal: &'static str, joint: usize, row: usize },
    #[error("{0} is missing, and this work needs it")]
    Missing(&'static str),
    #[error("{rows} rows are too few, at least {needed} are needed")]
    #[diagnostic(help("record longer or record the derivatives, or raise the cut-off"))]
    TooFewRows { rows: usize, needed: usize },
    #[error("t does not increase at row {row}")]
    #[diagnostic(help("sort the rows and drop repeated ones"))]
    TimeOrder { row: usize },
    #[error(
        "t has a gap of {gap:?} s at row {row}, with a usual step of {step:?} s the even grid would \
         have {rows:?} rows"
    )]
    #[diagnostic(help("cut the trajectory there"))]
    Gap { row: usize, gap: f64, step: f64, rows: f64 },
    #[error("the first part of the log is evenly stamped, but not the part around row {row}")]
    #[diagnostic(help("plan from a part that shows it, or cut the trajectory at gaps"))]
    Uneven { row: usize },
    #[error("no low-pass filter with a cut-off of {cutoff:?} Hz at {rate:?} Hz")]
    #[diagnostic(help("the cut-off must be above 0 and below half the rate"))]
    Cutoff { cutoff: f64, rate: f64 },
    #[error("{what} is {value:?}")]
    #[diagnostic(help("it must be {expected}"))]
    Setting { what: &'static str, value: f64, expected: &'static str },
    #[error("nothing is left of {rows} rows after trimming")]
    #[diagnostic(help("record longer, or trim less"))]
    NothingLeft { rows: usize },
    #[error("a block has other joints or signals than the first")]
    #[diagnostic(help("feed the blocks of one trajectory to one conditioner"))]
    Block,
}

impl MotionError {
    /// Whether a trajectory is too short to be filtered.
    pub fn is_too_short(&self) -> bool {
        match self {
            Self::TooFewRows { .. } | Self::NothingLeft { .. } => true,
            Self::Joint { source, .. } => source.is_too_short(),
            _ => false,
        }
    }

    /// Refuses a signal that has not one row per time stamp and one column per joint.
    pub(crate) fn check_shape(
        signal: &'static str,
        values: MatRef<'_, f64>,
        expected: [usize; 2],
    ) -> Result<(), Self> {
        let found = [values.nrows(), values.ncols()];
        if found == expected { Ok(()) } else { Err(Self::Shape { signal, found, expected }) }
    }

    /// Refuses a signal with a number that is not finite.
    pub(crate) fn check_all_finite(
        signal: &'static str,
        values: MatRef<'_, f64>,
    ) -> Result<(), Self> {
        let mut columns = values.col_iter().enumerate();
        columns.try_for_each(|(joint, column)| Self::check_finite(signal, joint, column.iter()))
    }

    /// Refuses values of a signal of a joint of which one is not finite.
    pub(crate) fn check_finite<'x>(
        signal: &'static str,
        joint: usize,
        values: impl IntoIterator<Item = &'x f64>,
    ) -> Result<(), Self> {
        let row = values.into_iter().position(|x| !x.is_finite());
        row.map_or(Ok(()), |row| Err(Self::NotFinite { signal, joint, row }))
    }

    /// Refuses stamps that stand still or go back.
    pub(crate) fn check_order(t: &[f64]) -> Result<()> {
        let before = t.windows(2).position(|pair| pair[1] <= pair[0]);
        before.map_or(Ok(()), |before| Err(Self::TimeOrder { row: before + 1 }))
    }

    pub(crate) fn of(self, signal: &'static str, joint: &str) -> Self {
        Self::Joint { signal, joint: joint.to_owned(), source: Box::new(self) }
    }
}
