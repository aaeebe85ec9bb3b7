//! From log to Reconstruction: what was found, how, and what was said on the way.

use crate::warning::Warning;
use torquewise_model::Model;
use torquewise_stepwise::fit::LibraryFit;
use torquewise_stepwise::form::Dropped;
use torquewise_stepwise::patterns::Patterns;
use torquewise_survey::noise::NoiseFloor;
use torquewise_survey::survey::Survey;

pub use torquewise_stepwise::fit::StepReport;
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

impl Reconstruction {
    /// What the steps found in a library, with what the user should know of it.
    pub(crate) fn of_library(survey: Survey, fit: LibraryFit) -> Self {
        let warnings = Warning::of_library(&survey, &fit);
        let LibraryFit { model, patterns, noise, candidates, steps, dropped, .. } = fit;
        Self { model, survey, patterns, noise, candidates, steps, dropped, warnings }
    }
}
