//! The method of the paper on one page.

use crate::active_set::ActiveSet;
use crate::candidates::{Candidates, Group};
use crate::error::IdentifyError;
use crate::fit::{LibraryFit, StepReport, dependent, dropped, form, friction_of};
use crate::library::Basis;
use crate::model_selection::{ModelSelection, select_model};
use crate::noise::NoiseFloor;
use crate::patterns::find_patterns;
use crate::plan::{LibraryOptions, Regression};
use crate::progress::Progress;
use crate::refit::{FittedTerm, RefitPlan, Refitted, refit};
use crate::step::{self, Step, plan_steps};
use crate::sums::LibrarySums;
use crate::survey::Survey;
use rayon::prelude::*;
use torquewise_model::model::Choice;
use torquewise_model::{Model, Stage, Weighted};
use torquewise_motion::Pattern;
use torquewise_regression::normal_equations::NormalEquations;
use torquewise_regression::select::Selector;

/// Reconstructs the equations of motion in the terms of a library: standstill, uniform and variable
/// velocity in turn, each explaining what the earlier ones leave (8)–(10), (14)–(16); last all kept
/// terms together on all rows (E6). One-shot SINDy is the same with a single step.
///
/// - `survey`: of all logs
/// - `sums`: what their rows were summed up to, pattern by pattern
///
/// # Errors
/// [`IdentifyError`]: a number of clusters out of range, a library too large, or a step whose
/// regression failed.
pub fn reconstruct(
    survey: &Survey,
    mut sums: LibrarySums,
    options: &LibraryOptions,
    seed: u64,
    progress: &mut dyn FnMut(Progress),
) -> Result<LibraryFit, IdentifyError> {
    // Activation index I(q̇), I(q̈), and clusters in their plane (6) (7).
    let mut patterns = find_patterns(survey, &sums.patterns)?;

    // Library of candidates (4) (13), and what the options leave open, chosen on held-out rows.
    let mut basis = sums.library.basis(survey.joints.len())?;
    let options = sums.library.applied_to(options);
    let chosen = select_model(survey, &options, (&sums.library.friction, &sums.choices))?;
    let ModelSelection { library, selector, choices, .. } = chosen;
    let options = LibraryOptions { selector, ..options };
    basis.candidates.limit_to(library);
    if options.regression == Regression::Stepwise {
        patterns.present = sums.assign_patterns(&basis, &patterns.present, survey.rows)?;
    }

    // Gravity at standstill (14), Coriolis at uniform velocity (15), inertia at variable one (16);
    // the last fits all terms of M(q) anew, of which the second had a part.
    let candidates = &basis.candidates;
    let (steps, unassigned) = plan_steps(candidates, options.regression, &patterns.present);
    let mut model = PartialModel::new(candidates, choices);
    for (number, step) in (1..).zip(&steps) {
        progress(Progress::Step(number));
        let rows = sums.of_step(step);
        let grams = rows.grams(&basis.prepared, &step.columns);
        model.take_step(step, rows.rows(), &grams, &options.selector)?;
    }

    // All kept terms on all rows (E6), less the bias that noise leaves (E7).
    progress(Progress::Refit);
    let noise = sums.still.clone().unwrap_or_else(|| survey.noise.clone());
    let bias =
        if options.noise_correction { noise.clone() } else { NoiseFloor::none(noise.q.len()) };
    let plan = RefitPlan { survey, options: &options, noise: &bias, seed };
    let refitted = model.refit(&sums, &basis, &plan)?;

    progress(Progress::Done);
    let missing = |pattern: &Pattern| !patterns.present.contains(pattern);
    let missing = match options.regression {
        Regression::Stepwise => Pattern::ALL.into_iter().filter(missing).collect(),
        Regression::OneShot => Vec::new(),
    };
    let (model, steps) = model.finish(survey, &refitted);
    Ok(LibraryFit {
        model,
        patterns,
        noise,
        candidates: candidates.len(),
        steps,
        dropped: dropped(candidates, &refitted),
        missing,
        unassigned: unassigned.len(),
        dependent: dependent(candidates, &refitted),
    })
}

/// The model as it grows.
struct PartialModel<'a> {
    candidates: &'a Candidates,
    groups: Vec<Group>,
    /// Weight of each candidate, per group.
    weights: Vec<Vec<f64>>,
    /// Weight of the rows of each equation, per group.
    row_weights: Vec<Vec<f64>>,
    stages: Vec<Stage>,
    reports: Vec<StepReport>,
    choices: Vec<Choice>,
}

impl<'a> PartialModel<'a> {
    fn new(candidates: &'a Candidates, choices: Vec<Choice>) -> Self {
        let groups = candidates.groups();
        let weights = vec![vec![0.0; candidates.len()]; groups.len()];
        let row_weights = groups.iter().map(|group| vec![1.0; group.joints.len()]).collect();
        let (stages, reports) = (Vec::new(), Vec::new());
        Self { candidates, groups, weights, row_weights, stages, reports, choices }
    }

    /// Regresses what is unexplained on the rows of a step, and adds what was found.
    fn take_step(
        &mut self,
        step: &Step,
        rows: usize,
        grams: &[NormalEquations],
        selector: &Selector,
    ) -> Result<(), IdentifyError> {
        // Joints with coefficients of their own are independent regressions.
        (self.groups.par_iter().zip(&mut self.weights).zip(&mut self.row_weights))
            .try_for_each(|((group, known), row_weights)| {
                step::take_step(step, grams, group, known, selector)?;
                let total: Vec<f64> = step.columns.iter().map(|&column| known[column]).collect();
                *row_weights = step::noise_weights(grams, group, &total);
                Ok(())
            })
            .map_err(|source| IdentifyError::Step { step: step.name().into(), source })?;
        let terms = self.terms();
        let form = form(self.candidates, &terms);
        let friction = friction_of(self.candidates, &terms);
        let mut active = form.active(self.candidates.n_joints);
        for (joint, count) in active.iter_mut().enumerate() {
            *count += friction.iter().filter(|law| law.term.acts_on(joint)).count();
        }
        self.reports.push(StepReport {
            name: step.name(),
            rows,
            candidates: step.offered.len(),
            active,
        });
        self.stages.push(Stage {
            name: step.name().into(),
            rows,
            candidates: step.offered.len(),
            form,
            friction,
        });
        Ok(())
    }

    /// What is found so far, per group; errors are not known yet.
    fn terms(&self) -> Vec<Vec<FittedTerm>> {
        let term = |(term, &coefficient): (usize, &f64)| {
            (coefficient != 0.0).then_some(Weighted {
                term,
                coefficient,
                std_error: 0.0,
                inclusion: None,
            })
        };
        let found = |weights: &Vec<f64>| weights.iter().enumerate().filter_map(term).collect();
        self.weights.iter().map(found).collect()
    }

    fn refit(
        &self,
        sums: &LibrarySums,
        basis: &Basis,
        plan: &RefitPlan<'_>,
    ) -> Result<Vec<Refitted>, IdentifyError> {
        let kept: Vec<ActiveSet> = self
            .terms()
            .iter()
            .zip(self.groups.iter().zip(&self.row_weights))
            .map(|(found, (group, weights))| ActiveSet {
                group: group.clone(),
                columns: found.iter().map(|term| term.term).collect(),
                weights: weights.clone(),
            })
            .collect();
        let all = sums.whole(basis)?;
        let whole = kept.iter().map(|kept| all.grams(&basis.prepared, &kept.columns));
        let whole: Vec<_> = whole.collect();
        refit(self.candidates, &kept, &whole, plan)
    }

    /// The model of refitted terms, and the steps that led to it.
    fn finish(self, survey: &Survey, refitted: &[Refitted]) -> (Model, Vec<StepReport>) {
        let terms: Vec<_> = refitted.iter().map(|group| group.terms.clone()).collect();
        let left = refitted.iter().flat_map(|group| group.residual_rms.iter().copied()).collect();
        let model = Model {
            joints: survey.joints.clone(),
            form: form(self.candidates, &terms),
            chain: None,
            friction: friction_of(self.candidates, &terms),
            stages: self.stages,
            training: survey.training(left),
            choices: self.choices,
        };
        (model, self.reports)
    }
}
