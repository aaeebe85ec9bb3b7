//! Recording → Reconstruction: the whole method on one page.

use crate::candidates::{Candidates, Group};
use crate::evidence::{Evidence, Step, one_shot, plan_steps};
use crate::factor::Kept;
use crate::form::{dropped, form, friction_of};
use crate::found::{Progress, Reconstruction, StepReport};
use crate::patterns::{Patterns, find_patterns};
use crate::plan::{ChainOptions, LibraryOptions, Method, Plan, Regression};
use crate::refit::{FittedTerm, RefitPlan, Refitted, refit};
use crate::rounds::{Request, Round};
use crate::score::score;
use crate::settings::Basis;
use crate::settle::{Settled, settle};
use crate::step;
use crate::summary::{Pass, Summary, summarise};
use crate::warning::Warning;
use rayon::prelude::*;
use torquewise_model::model::Choice;
use torquewise_model::{Model, Stage};
use torquewise_motion::Recording;
use torquewise_regression::select::Selector;
use torquewise_survey::error::IdentifyError;
use torquewise_survey::noise::NoiseFloor;
use torquewise_survey::survey::Survey;

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
    progress: &mut dyn FnMut(Progress),
) -> Result<Reconstruction, IdentifyError> {
    let mut summary = summarise(recording, plan, "", progress)?;
    loop {
        match solve(summary.clone(), plan, progress)? {
            Solution::Model(mut found) => {
                if !summary.settings().friction().is_empty() {
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
pub fn solve(
    summary: Summary,
    plan: &Plan,
    progress: &mut dyn FnMut(Progress),
) -> Result<Solution, IdentifyError> {
    let survey = summary.survey()?;
    survey.sample.require_tau()?;
    require_rows(&survey)?;
    match &plan.method {
        Method::Library(options) => {
            let found = by_library(summary, survey, options, plan.seed, progress)?;
            Ok(Solution::Model(Box::new(found)))
        }
        Method::Chain(options) => by_chain(summary, survey, options, plan.seed, progress),
    }
}

/// Searches a chain on the sample, or takes the step that the last pass over all rows asks for
/// (E8) (E11).
fn by_chain(
    summary: Summary,
    survey: Survey,
    options: &ChainOptions,
    seed: u64,
    progress: &mut dyn FnMut(Progress),
) -> Result<Solution, IdentifyError> {
    let settings = summary.settings();
    let Some(Pass { request, sums }) = summary.pass.as_ref() else {
        // The noise of filtered rows is not white: it is not taken out row by row.
        let is_white = options.noise_correction && !settings.filtered;
        let none = NoiseFloor::none(survey.joints.len());
        let noise = if is_white { survey.noise.clone() } else { none };
        let request = Request::first(&survey, options, noise, seed, progress)?;
        return Ok(Solution::Request(Box::new(request)));
    };
    progress(Progress::Refit);
    match request.clone().take(sums)? {
        Round::Again(request) => Ok(Solution::Request(request)),
        Round::Done(fitted) => {
            let patterns = find_patterns(&survey, &settings.patterns)?;
            let found = fitted.report(survey, patterns, seed)?;
            progress(Progress::Done);
            Ok(Solution::Model(Box::new(found)))
        }
    }
}

/// Standstill, uniform and variable velocity in turn, each explaining what the earlier ones leave
/// (8)–(10), (14)–(16); last all kept terms together on all rows (E6). One-shot SINDy is the same
/// with a single step.
fn by_library(
    mut summary: Summary,
    survey: Survey,
    options: &LibraryOptions,
    seed: u64,
    progress: &mut dyn FnMut(Progress),
) -> Result<Reconstruction, IdentifyError> {
    let mut patterns = find_patterns(&survey, &summary.settings().patterns)?;
    let (mut basis, options) = summary.settings().basis_for(options)?;
    let Settled { library, selector, choices, .. } = settle(&survey, &options, summary.friction())?;
    let options = LibraryOptions { selector, ..options };
    basis.candidates.limit_to(library);
    if options.regression == Regression::Stepwise {
        patterns.present = summary.settle(&basis, &patterns.present)?;
    }
    let candidates = &basis.candidates;
    let (steps, orphans) = match options.regression {
        Regression::Stepwise => plan_steps(candidates, &patterns.present),
        Regression::OneShot => (one_shot(candidates), Vec::new()),
    };
    let noise = summary.still().unwrap_or_else(|| survey.noise.clone());

    let mut found = Found::new(candidates, survey.rows, choices);
    for (place, step) in steps.iter().enumerate() {
        progress(Progress::Step(place + 1));
        found.take_step(step, &summary.evidence(&basis, step), &options.selector)?;
    }

    progress(Progress::Refit);
    let bias =
        if options.noise_correction { noise.clone() } else { NoiseFloor::none(noise.q.len()) };
    let refitted =
        found.refit(&summary, &basis, &survey, &found.refit_plan(&options, seed, &bias))?;

    progress(Progress::Done);
    let regression = options.regression;
    let warnings = Warning::all(&survey, &patterns, regression, candidates, &orphans, &refitted);
    Ok(found.report(survey, patterns, noise, refitted, warnings))
}

/// Fewer rows cannot be told from chance.
const LEAST_ROWS: usize = 50;

fn require_rows(survey: &Survey) -> Result<(), IdentifyError> {
    let joints = survey.joints.len();
    if survey.rows >= LEAST_ROWS {
        return Ok(());
    }
    Err(IdentifyError::TooFewRows { rows: survey.rows, needed: LEAST_ROWS, joints })
}

/// The model as it grows.
struct Found<'a> {
    candidates: &'a Candidates,
    groups: Vec<Group>,
    /// Weight of each candidate, per group.
    weights: Vec<Vec<f64>>,
    /// Weight of the rows of each equation, per group.
    row_weights: Vec<Vec<f64>>,
    stages: Vec<Stage>,
    reports: Vec<StepReport>,
    /// Rows of the log.
    rows: usize,
    choices: Vec<Choice>,
}

impl<'a> Found<'a> {
    fn new(candidates: &'a Candidates, rows: usize, choices: Vec<Choice>) -> Self {
        let groups = candidates.groups();
        let weights = vec![vec![0.0; candidates.len()]; groups.len()];
        let row_weights = groups.iter().map(|group| vec![1.0; group.equations.len()]).collect();
        let (stages, reports) = (Vec::new(), Vec::new());
        Self { candidates, groups, weights, row_weights, stages, reports, rows, choices }
    }

    /// Regresses what is unexplained on the rows of a step, and adds what was found.
    fn take_step(
        &mut self,
        step: &Step,
        evidence: &Evidence,
        selector: &Selector,
    ) -> Result<(), IdentifyError> {
        // Joints with coefficients of their own are independent regressions.
        let found: Vec<_> = (self.groups.par_iter().zip(&self.weights))
            .map(|(group, known)| step::select(step, evidence, group, known, selector))
            .collect::<Result<_, _>>()
            .map_err(|source| IdentifyError::Step { step: step.name().into(), source })?;
        for (place, found) in found.into_iter().enumerate() {
            let known = &mut self.weights[place];
            for &column in &step.offered {
                known[column] = 0.0;
            }
            for (column, weight) in found {
                known[column] = weight;
            }
            let total: Vec<f64> = step.columns.iter().map(|&column| known[column]).collect();
            self.row_weights[place] = step::noise_weights(evidence, &self.groups[place], &total);
        }
        let terms = self.terms();
        let form = form(self.candidates, &terms);
        let friction = friction_of(self.candidates, &terms);
        let mut active = form.active(self.candidates.design.n_angles());
        for (joint, count) in active.iter_mut().enumerate() {
            *count += friction.iter().filter(|law| law.term.acts_on(joint)).count();
        }
        self.reports.push(StepReport {
            name: step.name(),
            rows: evidence.rows,
            candidates: step.offered.len(),
            active,
            route: evidence.route,
        });
        self.stages.push(Stage {
            name: step.name().into(),
            rows: evidence.rows,
            candidates: step.offered.len(),
            form,
            friction,
        });
        Ok(())
    }

    /// What is found so far, per group; errors are not known yet.
    fn terms(&self) -> Vec<Vec<FittedTerm>> {
        let term = |(column, &coefficient): (usize, &f64)| FittedTerm {
            column,
            coefficient,
            std_error: 0.0,
            inclusion: None,
        };
        let found = |weights: &Vec<f64>| -> Vec<FittedTerm> {
            weights.iter().enumerate().filter(|(_, weight)| **weight != 0.0).map(term).collect()
        };
        self.weights.iter().map(found).collect()
    }

    /// What the last fit is asked, whose noise is taken out.
    fn refit_plan<'n>(
        &self,
        options: &LibraryOptions,
        seed: u64,
        noise: &'n NoiseFloor,
    ) -> RefitPlan<'n> {
        let rows = self.rows;
        let least_t_squared = match options.selector {
            Selector::Criterion(criterion) => {
                criterion.threshold(rows as f64, self.candidates.len())
            }
            _ => 0.0,
        };
        let least_size = options.threshold.unwrap_or(0.0);
        RefitPlan { noise, seed, least_t_squared, least_size, bags: options.bags, rows }
    }

    fn refit(
        &self,
        summary: &Summary,
        basis: &Basis,
        survey: &Survey,
        plan: &RefitPlan<'_>,
    ) -> Result<Vec<Refitted>, IdentifyError> {
        let kept: Vec<Kept> = self
            .terms()
            .iter()
            .zip(self.groups.iter().zip(&self.row_weights))
            .map(|(found, (group, weights))| Kept {
                group: group.clone(),
                columns: found.iter().map(|term| term.column).collect(),
                weights: weights.clone(),
            })
            .collect();
        let all = summary.whole(basis)?;
        let whole: Vec<_> = kept.iter().map(|kept| basis.grams(&all, &kept.columns)).collect();
        refit(&survey.sample, self.candidates, &kept, &whole, plan)
    }

    fn report(
        self,
        survey: Survey,
        patterns: Patterns,
        noise: NoiseFloor,
        refitted: Vec<Refitted>,
        warnings: Vec<Warning>,
    ) -> Reconstruction {
        let terms: Vec<_> = refitted.iter().map(|group| group.terms.clone()).collect();
        let dropped = dropped(self.candidates, &refitted);
        let left = refitted.into_iter().flat_map(|group| group.residual_rms).collect();
        let training = survey.training(left);
        let form = form(self.candidates, &terms);
        let friction = friction_of(self.candidates, &terms);
        let joints = survey.joints.clone();
        let (stages, choices) = (self.stages, self.choices);
        let chain = None;
        let model = Model { joints, form, chain, friction, stages, training, choices };
        let candidates = self.candidates.len();
        Reconstruction {
            model,
            survey,
            patterns,
            noise,
            candidates,
            steps: self.reports,
            dropped,
            warnings,
        }
    }
}
