//! The fit: sums of the logs, then the steps of the paper or a learned chain.

use crate::estimate::refined_by_rollouts;
use crate::learn::against_axes;
use crate::rounds::{Request, Searched};
use crate::summary::Pass;
use crate::torque_sign::SignTest;
use crate::{
    ChainOptions, Fitted, Method, Plan, Progress, Reconstruction, Refine, Summary, Warning, Watch,
    score, summarise,
};
use std::ops::ControlFlow;
use torquewise_motion::Recording;
use torquewise_stepwise::{IdentifyError, Survey, find_patterns, reconstruct as stepwise};

/// What solving came to.
#[derive(Debug)]
pub enum Solution {
    /// The equations of motion.
    Model(Box<Reconstruction>),
    /// A chain asks for another pass over the rows of all logs.
    Request(Box<Request>),
}

/// Reconstructs the equations of motion from a recording: sums up its logs, and solves; for a chain
/// again and again, until nothing moves.
///
/// # Errors
/// [`IdentifyError`]: the reader's message, too few rows, a library too large, or missing torque.
pub fn reconstruct(
    recording: &(impl Recording + ?Sized),
    plan: &Plan,
    watch: Watch<'_>,
) -> Result<Reconstruction, IdentifyError> {
    reconstruct_from(recording, None, plan, watch)
}

/// The same where a chain may have been searched before, see [`tune`](crate::bandwidth::tune).
///
/// # Errors
/// As [`reconstruct`].
pub fn reconstruct_from(
    recording: &(impl Recording + ?Sized),
    request: Option<Request>,
    plan: &Plan,
    watch: Watch<'_>,
) -> Result<Reconstruction, IdentifyError> {
    let mut summary = summarise(recording, plan, "", watch)?;
    let request = request.map(|request| request.over(summary.rows()));
    summary.pass = request.map(|request| Pass::over(recording, request)).transpose()?;
    let refined =
        |fitted: Fitted, pass: &Pass| refined_by_rollouts(recording, fitted, &pass.sums, watch);
    loop {
        match solve_refined(summary.clone(), plan, &refined, watch)? {
            Solution::Model(mut found) => {
                if !summary.settings.friction().is_empty() {
                    // Rows near reversals were left out of the sums, but not of what is told.
                    let scores = score(&found.model, recording)?;
                    found.model.training.residual_rms =
                        scores.joints.into_iter().map(|joint| joint.rmse).collect();
                }
                return Ok(*found);
            }
            Solution::Request(request) => summary.pass = Some(Pass::over(recording, *request)?),
        }
    }
}

/// Reconstructs the equations of motion from what logs were summed up to, or says which sums are
/// wanted next.
///
/// How rows were told apart, and of a library its candidates and the number of regressions, were
/// settled when the logs were summed: these go before the plan.
///
/// # Errors
/// [`IdentifyError`]: too few rows, a library too large, missing torque, or a plan for a library of
/// which nothing was summed.
pub fn solve(summary: Summary, plan: &Plan, watch: Watch<'_>) -> Result<Solution, IdentifyError> {
    solve_refined(summary, plan, &|_, _| Err(IdentifyError::RolloutsOfSums), watch)
}

/// Refines a chain by what its sums were made of.
type Refined<'r> = dyn Fn(Fitted, &Pass) -> Result<Fitted, IdentifyError> + 'r;

fn solve_refined(
    summary: Summary,
    plan: &Plan,
    refined: &Refined<'_>,
    watch: Watch<'_>,
) -> Result<Solution, IdentifyError> {
    let survey = surveyed(&summary)?;
    match &plan.method {
        Method::Library(options) => {
            let sums = summary.library_sums()?;
            let fit = stepwise::reconstruct(&survey, sums, options, plan.seed, watch)?;
            let mut found = Reconstruction::of_library(survey, fit, plan.seed, watch)?;
            Warning::retain_founded(&mut found.warnings, &found.model);
            Ok(Solution::Model(Box::new(found)))
        }
        Method::Chain(options) => by_chain(&summary, survey, (options, refined), plan.seed, watch),
    }
}

/// Searches a chain on the sample, or takes the step that the last pass over all rows asks for
/// (E8) (E11).
fn by_chain(
    summary: &Summary,
    survey: Survey,
    (options, refined): (&ChainOptions, &Refined<'_>),
    seed: u64,
    watch: Watch<'_>,
) -> Result<Solution, IdentifyError> {
    let settings = &summary.settings;
    let Some(pass) = summary.pass.as_ref() else {
        let of_logs = (settings.filtered, seed);
        let searched = Searched::of(&survey, options, of_logs, None, watch)?;
        return Ok(Solution::Request(Box::new(searched.refined(watch)?)));
    };
    Progress::Refit.tell(watch)?;
    match pass.request.clone().take(&pass.sums)? {
        ControlFlow::Continue(request) => Ok(Solution::Request(Box::new(request))),
        ControlFlow::Break(fitted) => {
            let fitted = match options.refine {
                Some(Refine::Rollout) => refined(fitted, pass)?,
                None => fitted,
            };
            let patterns = find_patterns(&survey, &settings.patterns)?;
            let chain = SignTest::at(&fitted.solved.at, options.geometry.is_some());
            Progress::Judging.tell(watch)?;
            let mut found = fitted.report(survey, patterns, seed, watch)?;
            let (against, read) = against_axes(&found.model.choices).unzip();
            let is_turned = matches!(against, Some(Warning::Gravity { .. }));
            if against.is_some() {
                // Gravity that pulls elsewhere does nothing where it was said to.
                found.warnings.retain(|own| *own != Warning::Weightless);
            }
            found.warnings.extend(against);
            Warning::retain_founded(&mut found.warnings, &found.model);
            let given = options.geometry.as_ref();
            let other = given.and_then(|_| found.doubt_axes(read, seed, watch));
            if !is_turned || other.is_some() {
                // Under gravity from elsewhere the signs of right torques seem wrong.
                let chain = other.map_or(chain, |other| SignTest::at(&other, false));
                found.doubt_torque(seed, watch, |_| Ok(chain))?;
            }
            Progress::Done.tell(watch)?;
            Ok(Solution::Model(Box::new(found)))
        }
    }
}

/// Fewer rows cannot be told from chance.
const LEAST_ROWS: usize = 50;

/// The survey of enough rows with torque.
pub(crate) fn surveyed(summary: &Summary) -> Result<Survey, IdentifyError> {
    let survey = summary.survey.finish()?;
    survey.sample.require_tau()?;
    if survey.rows >= LEAST_ROWS {
        return Ok(survey);
    }
    let (rows, joints) = (survey.rows, survey.joints.len());
    Err(IdentifyError::TooFewRows { rows, needed: LEAST_ROWS, joints })
}
