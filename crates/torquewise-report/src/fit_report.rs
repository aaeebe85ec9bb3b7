//! The report of a fit: what was found in a log, and how far to trust it.

use crate::html::Page;
use crate::{Origin, ReportError, Result, Section};
use torquewise_export::Cost;
use torquewise_identify::verdict::Verdict;
use torquewise_identify::{Diagnosis, Reconstruction};
use torquewise_model::Checks;

pub mod origin;
pub(crate) mod clock;
mod verdict;
mod torques;
mod geometry;
mod friction;
mod equations;
mod method;
pub mod call_cost;
mod residuals;
mod importance;
mod physics;
mod conditioning;

/// All that the sections of a report tell about.
#[derive(Clone, Copy, Debug)]
pub struct Findings<'a> {
    /// What was reconstructed from a log.
    pub found: &'a Reconstruction,
    /// Whether it may be used.
    pub verdict: &'a Verdict,
    /// The residuals of that same model over the log.
    pub diagnosis: &'a Diagnosis,
    /// Whether the model is physics, if that was looked at.
    pub checks: Option<&'a Checks>,
    /// Its residuals over a log of another motion, if there is one.
    pub test: Option<&'a Diagnosis>,
    /// Cost of its torque as it was after each step and as it is; empty if that was not counted.
    pub costs: &'a [Cost],
    /// Logs, command and date.
    pub origin: Origin<'a>,
}

/// The report of a fit as one HTML text, see [`Page::to_html`].
///
/// The verdict and the error of each joint come first, then what to do next; then torques, learned
/// geometry, friction, equations, residuals, importance of terms, physical checks, the log and what
/// was repaired in it, details of the method and cost in a controller. What a model does not have is
/// left out.
///
/// # Errors
/// [`ReportError::Empty`] if a diagnosis has no rows, [`ReportError::Joints`] if it is of another arm,
/// [`ReportError::Costs`] if they are of fewer or more models than steps and the whole,
/// [`ReportError::Step`] if the model after a step cannot be evaluated, [`ReportError::Page`] if the
/// page cannot be written.
pub fn fit_report(findings: &Findings<'_>) -> Result<String> {
    findings.check()?;
    let page = Page {
        title: findings.origin.title(),
        lead: verdict::lead(findings),
        sections: findings.sections()?,
        foot: findings.origin.foot(),
    };
    page.to_html()
}

impl<'a> Findings<'a> {
    fn sections(&self) -> Result<Vec<Section>> {
        let mut sections =
            vec![verdict::section(self), verdict::next(self), torques::section(self)];
        sections.extend(geometry::section(self));
        sections.extend(friction::section(self));
        sections.extend([equations::section(self), residuals::section(self)]);
        sections.extend(importance::section(self));
        sections.extend(self.checks.map(physics::section));
        sections.push(conditioning::section(self));
        if self.is_stepwise() {
            sections.push(method::section(self)?);
        }
        if !self.costs.is_empty() {
            sections.push(call_cost::section(self)?);
        }
        Ok(sections)
    }

    /// The diagnosis to judge the model by: that of another motion, where there is one.
    pub(crate) fn judged(&self) -> &'a Diagnosis {
        self.test.unwrap_or(self.diagnosis)
    }

    /// Whether patterns of motion had regressions of their own.
    pub(crate) fn is_stepwise(&self) -> bool {
        self.found.steps.len() > 1
    }

    pub(crate) fn n_joints(&self) -> usize {
        self.found.model.n_joints()
    }

    pub(crate) fn joints(&self) -> &[String] {
        &self.found.model.joints
    }

    fn check(&self) -> Result<()> {
        let expected = self.n_joints();
        for diagnosis in std::iter::once(self.diagnosis).chain(self.test) {
            let motion = &diagnosis.trace.motion;
            let (rows, found) = (motion.n_rows(), motion.n_joints());
            if rows < 2 || expected == 0 {
                return Err(ReportError::Empty { rows, joints: expected });
            }
            if found != expected {
                return Err(ReportError::Joints { found, expected });
            }
        }
        let (found, expected) = (self.costs.len(), self.found.model.stages.len() + 1);
        let is_counted = found == 0 || found == expected;
        if is_counted { Ok(()) } else { Err(ReportError::Costs { found, expected }) }
    }
}
