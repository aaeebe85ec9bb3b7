//! From log to Reconstruction: what was found, how, and what was said on the way.

use crate::warning::Warning;
use torquewise_diagnose::clipped::clipped;
use torquewise_diagnose::excitation::Finding;
use torquewise_diagnose::signs::backward;
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

/// Part of the spread of a torque.
const MUCH: f64 = 0.2;

impl Reconstruction {
    /// What the steps found in a library, with what the user should know of it.
    pub(crate) fn of_library(survey: Survey, fit: LibraryFit) -> Self {
        let warnings = Warning::of_library(&survey, &fit);
        let LibraryFit { model, patterns, noise, candidates, steps, dropped, .. } = fit;
        let mut found =
            Self { model, survey, patterns, noise, candidates, steps, dropped, warnings };
        found.doubt_torque();
        found
    }

    /// Where a model misses much of a torque, looks whether that was cut off, or a motor wired the
    /// wrong way round.
    pub(crate) fn doubt_torque(&mut self) {
        let training = &self.model.training;
        let left = training.residual_rms.iter().zip(&training.torque_std).enumerate();
        let missed: Vec<usize> =
            left.filter(|(_, (rms, std))| **rms > MUCH * **std).map(|(joint, _)| joint).collect();
        for &joint in &missed {
            if let Some(share) = clipped(&self.survey.sample, joint) {
                let joint = self.survey.joints[joint].clone();
                self.warnings.push(Warning::Excitation(Finding::Clipped { joint, share }));
            }
        }
        let is_explained = |warning: &Warning| {
            let Warning::Excitation(finding) = warning else { return false };
            matches!(finding, Finding::Backward { .. } | Finding::Clipped { .. })
        };
        if missed.is_empty() || self.warnings.iter().any(is_explained) {
            return;
        }
        for joint in backward(&self.survey.sample) {
            let joint = self.survey.joints[joint].clone();
            self.warnings.push(Warning::Excitation(Finding::Contrary { joint }));
        }
    }
}
