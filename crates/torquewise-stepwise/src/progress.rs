//! How far work under way is, for whoever watches it and may stop it.

use crate::IdentifyError;
use std::fmt;
use std::ops::ControlFlow;

/// A stage of the work, reported when it begins, or its progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// The log is looked through.
    Survey,
    /// Rows are clustered.
    Patterns,
    /// The geometry of the arm is learned (E8).
    Geometry,
    /// Starts of a search for the geometry were made.
    Starts {
        /// So many.
        made: usize,
        /// So many at most: fewer where enough of them agree.
        most: usize,
        /// So many of them led to the best arm.
        agreeing: usize,
    },
    /// Offers of friction, springs and shared shafts were decided (E13).
    Choices {
        /// So many.
        made: usize,
        /// So many at most: fewer where they no longer change.
        most: usize,
    },
    /// Cut-offs of a filter were tried (E12).
    Bandwidth {
        /// So many.
        made: usize,
        /// So many at most.
        most: usize,
    },
    /// A model was simulated along the log, to be refined by where it drifts (E23).
    Rollouts {
        /// So often.
        made: usize,
        /// So often at most: fewer where it drifts no less any more.
        most: usize,
    },
    /// Normal equations are summed.
    Sums,
    /// Terms are selected in a step, counted from 1.
    Step(usize),
    /// The kept terms are fitted on all rows.
    Refit,
    /// The model is judged on rows held out.
    Judging,
    /// The stage goes on: reported often, so that work can be stopped.
    Working,
    /// All is done.
    Done,
}

/// Is told how far work is, and stops it by breaking, from then on whenever it is called. It is
/// called from several threads.
pub type Watch<'a> = &'a (dyn Fn(Progress) -> ControlFlow<()> + Sync + 'a);

/// Nobody watches.
pub const UNWATCHED: Watch<'static> = &|_| ControlFlow::Continue(());

impl Progress {
    /// Reports to the observer.
    ///
    /// # Errors
    /// [`IdentifyError::Stopped`] if the work is not wanted any more.
    pub fn tell(self, watch: Watch<'_>) -> Result<(), IdentifyError> {
        if watch(self).is_continue() { Ok(()) } else { Err(IdentifyError::Stopped) }
    }

    /// What is done of how much, at most, where that is known.
    pub fn share(self) -> Option<(usize, usize)> {
        match self {
            Self::Starts { made, most, .. }
            | Self::Choices { made, most }
            | Self::Bandwidth { made, most }
            | Self::Rollouts { made, most } => Some((made, most)),
            _ => None,
        }
    }

    /// What is done, without how far it is.
    pub fn doing(self) -> &'static str {
        match self {
            Self::Survey => "looking through the log",
            Self::Patterns => "clustering",
            Self::Geometry | Self::Starts { .. } => "learning the geometry",
            Self::Choices { .. } => "choosing friction",
            Self::Bandwidth { .. } => "trying cut-offs of the filter",
            Self::Rollouts { .. } => "refining by rollouts",
            Self::Sums => "summing",
            Self::Step(_) => "selecting terms",
            Self::Refit => "fitting all rows",
            Self::Judging => "judging on rows held out",
            Self::Working => "working",
            Self::Done => "done",
        }
    }
}

impl fmt::Display for Progress {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.doing())?;
        match self {
            Self::Starts { made, most, agreeing } => {
                write!(out, ", {made} of at most {most} starts, best found {agreeing} times")
            }
            Self::Step(step) => write!(out, ", step {step}"),
            _ => self
                .share()
                .map_or(Ok(()), |(made, most)| write!(out, ", {made} of at most {most}")),
        }
    }
}
