//! Log → Reconstruction: what was found, how, and what was said on the way.

use crate::form::Dropped;
use crate::patterns::Patterns;
use crate::warning::Warning;
use torquewise_model::Model;
use torquewise_regression::accumulate::Route;
use torquewise_survey::noise::NoiseFloor;
use torquewise_survey::survey::Survey;

pub use torquewise_survey::progress::Progress;

/// What was found, and how.
#[derive(Clone, Debug)]
pub struct Reconstruction {
    /// The equations of motion.
    pub model: Model,
    /// The log at a glance.
    pub survey: Survey,
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
    /// What the user should know.
    pub warnings: Vec<Warning>,
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
    /// How its normal equations were come by.
    pub route: Route,
}
