//! What the steps found in the terms of a library, and how.

use crate::form::Dropped;
use crate::noise::NoiseFloor;
use crate::patterns::Patterns;
use torquewise_model::Model;
use torquewise_motion::Pattern;

/// What the steps found in the terms of a library, and how.
#[derive(Clone, Debug)]
pub struct LibraryFit {
    /// The equations of motion.
    pub model: Model,
    /// The patterns its rows fall into.
    pub patterns: Patterns,
    /// The white noise in its signals, from standstill where there is one.
    pub noise: NoiseFloor,
    /// Candidates in all.
    pub candidates: usize,
    /// The steps taken.
    pub steps: Vec<StepReport>,
    /// Terms that did not stay though resampled logs kept them, the likeliest first.
    pub dropped: Vec<Dropped>,
    /// Patterns that the log does not show, whose terms were fitted with the rows of the next.
    pub missing: Vec<Pattern>,
    /// Candidates that the motion of the log does not excite.
    pub unassigned: usize,
    /// Names of the terms left out of the last fit because they depend linearly on others in this log.
    pub dependent: Vec<String>,
}

/// One step of the reconstruction.
#[derive(Clone, Debug)]
pub struct StepReport {
    /// Name of its pattern.
    pub name: &'static str,
    /// Its rows.
    pub rows: usize,
    /// Candidates offered.
    pub candidates: usize,
    /// Terms found so far that act on each joint, n.
    pub active: Vec<usize>,
}
