//! The method of the paper on one page.

use crate::active_set::ActiveSet;
use crate::fit::{LibraryFit, dropped, model_terms};
use crate::library::{LibrarySums, SummedLibrary};
use crate::model_selection::{ModelSelection, select_model};
use crate::progress::Watch;
use crate::refit::{FittedTerm, RefitPlan, Refitted, refit};
use crate::step::{self, Step, plan_steps};
use crate::{
    Candidates, IdentifyError, LibraryOptions, NoiseFloor, Progress, Regression, StepReport,
    Survey, find_patterns,
};
use rayon::prelude::*;
use std::collections::BTreeSet;
use torquewise_model::{Choice, Model, Stage, Weighted};
use torquewise_motion::Pattern;
use torquewise_regression::{NormalEquations, RowSums, Selector};

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
    watch: Watch<'_>,
) -> Result<LibraryFit, IdentifyError> {
    // Activation index I(q̇), I(q̈), and clusters in their plane (6) (7).
    let mut patterns = find_patterns(survey, &sums.patterns)?;

    // Library of candidates (4) (13), and what the options leave open, chosen on held-out rows.
    let mut basis = sums.library.basis(survey.joints.len())?;
    let SummedLibrary { kind: library, kinds, regression, friction } = &sums.library;
    let (library, kinds, regression) = (*library, kinds.clone(), *regression);
    let mut options = LibraryOptions { library, kinds, regression, ..options.clone() };
    let chosen = select_model(survey, &options, (friction, &sums.choices))?;
    let ModelSelection { library, selector, choices, .. } = chosen;
    options.selector = selector;
    basis.candidates.limit_to(library);
    let is_stepwise = options.regression == Regression::Stepwise;
    if is_stepwise {
        patterns.present = sums.assign_patterns(&basis, &patterns.present, survey.rows)?;
    }

    // Gravity at standstill (14), Coriolis at uniform velocity (15), inertia at variable one (16);
    // the last fits all terms of M(q) anew, of which the second had a part.
    let candidates = &basis.candidates;
    let (steps, unassigned) = plan_steps(candidates, options.regression, &patterns.present);
    let mut found = PartialModel::new(survey, candidates, choices);
    for (number, step) in (1..).zip(&steps) {
        Progress::Step(number).tell(watch)?;
        let rows = &sums.sums[step.pattern.map_or(0, |pattern| pattern as usize)];
        let grams = rows.grams(&basis.prepared, &step.columns);
        found.take_step(step, rows.rows, &grams, &options.selector)?;
    }

    // All kept terms on all rows (E6), less the bias that noise leaves (E7).
    Progress::Refit.tell(watch)?;
    let noise = sums.still.clone().unwrap_or_else(|| survey.noise.clone());
    let bias =
        if options.noise_correction { noise.clone() } else { NoiseFloor::none(noise.q.len()) };
    let kept = found.kept();
    let mut all = RowSums::new(&basis.prepared);
    sums.sums.iter().try_for_each(|own| all.merge(own))?;
    let whole: Vec<_> = kept.iter().map(|kept| all.grams(&basis.prepared, &kept.columns)).collect();
    let plan = RefitPlan { survey, options: &options, noise: &bias, seed };
    let refitted = refit(candidates, &kept, &whole, &plan)?;

    Progress::Done.tell(watch)?;
    let is_missing = |pattern: &Pattern| is_stepwise && !patterns.present.contains(pattern);
    let missing = Pattern::ALL.into_iter().filter(is_missing).collect();
    let dependent: BTreeSet<usize> =
        refitted.iter().flat_map(|group| group.dependent.iter().copied()).collect();
    let (mut model, steps) = found.finish(survey, &refitted);
    model.training.kinds = options.kinds;
    Ok(LibraryFit {
        model,
        patterns,
        noise,
        candidates: candidates.n_columns(),
        steps,
        dropped: dropped(candidates, &refitted),
        missing,
        unassigned: unassigned.len(),
        dependent: dependent.into_iter().map(|column| candidates.name(column)).collect(),
    })
}

struct PartialModel<'a> {
    candidates: &'a Candidates,
    /// Joints whose torque is explained by the same coefficients.
    groups: Vec<Vec<usize>>,
    /// Weight of each candidate, per group.
    weights: Vec<Vec<f64>>,
    /// Weight of the rows of each joint, per group.
    row_weights: Vec<Vec<f64>>,
    model: Model,
    reports: Vec<StepReport>,
}

impl<'a> PartialModel<'a> {
    fn new(survey: &Survey, candidates: &'a Candidates, choices: Vec<Choice>) -> Self {
        let groups = candidates.groups();
        let weights = vec![vec![0.0; candidates.n_columns()]; groups.len()];
        let row_weights = groups.iter().map(|group| vec![1.0; group.len()]).collect();
        let model = Model { joints: survey.joints.clone(), choices, ..Model::default() };
        Self { candidates, groups, weights, row_weights, model, reports: Vec::new() }
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
                step::take_step(step, grams, (self.candidates, group), known, selector)?;
                let total: Vec<f64> = step.columns.iter().map(|&column| known[column]).collect();
                *row_weights = step::noise_weights(grams, group, &total);
                Ok(())
            })
            .map_err(|source| IdentifyError::Step { step: step.name().into(), source })?;
        let (model, name, candidates) = (&mut self.model, step.name(), step.offered.len());
        let terms: Vec<Vec<FittedTerm>> = self.weights.iter().map(|own| nonzero(own)).collect();
        let (form, friction) = model_terms(self.candidates, &terms);
        (model.form, model.friction) = (form.clone(), friction.clone());
        self.reports.push(StepReport { name, rows, candidates, active: model.active() });
        model.stages.push(Stage { name: name.into(), rows, candidates, form, friction });
        Ok(())
    }

    /// The model of refitted terms, and the steps that led to it.
    fn finish(mut self, survey: &Survey, refitted: &[Refitted]) -> (Model, Vec<StepReport>) {
        let terms: Vec<_> = refitted.iter().map(|group| group.terms.clone()).collect();
        let left = refitted.iter().flat_map(|group| group.residual_rms.iter().copied());
        (self.model.form, self.model.friction) = model_terms(self.candidates, &terms);
        self.model.training = survey.training(left.collect());
        (self.model, self.reports)
    }

    /// What is found so far, to be fitted together.
    fn kept(&self) -> Vec<ActiveSet<'a>> {
        let groups = self.groups.iter().zip(&self.weights).zip(&self.row_weights);
        let kept = groups.map(|((group, found), weights)| {
            let columns = nonzero(found).into_iter().map(|term| term.term).collect();
            ActiveSet::new(self.candidates, group.clone(), columns, weights)
        });
        kept.collect()
    }
}

/// Terms that carry a weight; errors are not known yet.
fn nonzero(weights: &[f64]) -> Vec<FittedTerm> {
    let found = weights.iter().enumerate().filter(|(_, weight)| **weight != 0.0);
    found.map(|(term, &weight)| Weighted::new(term, weight)).collect()
}
