//! What each choice buys: a method with one choice changed at a time, in case 3.

use crate::error::PaperError;
use crate::method::{
    Method, MethodPlan, correcting_noise, in_one_step, lasso, selecting, threshold,
    with_printed_index,
};
use crate::results::{Cell, Study, Table};
use crate::scenario::{Decibels, outside};
use crate::settings::Settings;
use crate::spread::Spread;
use crate::trial::{TrialPlan, Trials, judge_steps};

/// The row with the paper's constants of the activation index.
const PRINTED: &str = "activation index as printed";
/// The row that is judged after the last step, before the refit.
const BEFORE_REFIT: &str = "no refit after the last step";

/// Family, what is changed, the equation that this puts to the test, the plan.
type Variant = (&'static str, &'static str, &'static str, MethodPlan);

fn variants() -> Vec<Variant> {
    let mut variants = Vec::new();
    for method in [Method::Energy, Method::Product] {
        let (name, plan) = (method.name(), method.plan());
        variants.extend([
            (name, "as it is", "", plan.clone()),
            (name, PRINTED, "[E1]", with_printed_index(plan.clone())),
            (name, "one step, all rows", "", in_one_step(plan.clone())),
            (name, "terms chosen by LASSO + BIC", "[E5]", selecting(&plan, lasso())),
            (name, "terms chosen by |c| > 0.1", "[E5]", selecting(&plan, threshold())),
            (name, BEFORE_REFIT, "[E6]", plan.clone()),
            (name, "no noise correction", "[E7]", correcting_noise(plan, false)),
        ]);
    }
    let (name, chosen) = ("one-shot SINDy", Method::SindyCriterion.plan());
    let uncorrected = correcting_noise(chosen.clone(), false);
    variants.extend([
        (name, "terms chosen by |c| > 0.1", "", Method::Sindy.plan()),
        (name, "terms chosen by LASSO + BIC", "", Method::SindyLasso.plan()),
        (name, "terms chosen by the criterion", "[E5]", uncorrected),
        (name, "criterion, noise correction", "[E7]", chosen),
    ]);
    variants
}

/// The trials of a variant. The printed index leaves the product library with so many terms that
/// its refit takes longest of all: one seed says it.
fn seeds(settings: &Settings, (_, change, _, plan): &Variant) -> Vec<TrialPlan> {
    let scenario = settings.scenario(Decibels::case(3), settings.seed);
    let seeds = if *change == PRINTED { 1 } else { settings.sweep_seeds };
    TrialPlan::seeds(&scenario, plan, seeds)
}

/// All trials.
pub(crate) fn plans(settings: &Settings) -> Vec<TrialPlan> {
    variants().iter().flat_map(|variant| seeds(settings, variant)).collect()
}

/// The error of every variant.
pub(crate) fn study(settings: &Settings, trials: &Trials) -> Result<Study, PaperError> {
    let test = outside(settings.arm, settings.seed)?;
    let mut table = Table::new(
        "Error outside the training log, median and range over the seeds.",
        "method;changed;tests;runs;terms",
    )
    .with_joints("error [%]", test.n_joints());
    for variant in variants() {
        let done = trials.all(&seeds(settings, &variant))?;
        let (family, change, equation, _) = variant;
        let mut errors = Vec::new();
        for trial in &done {
            let steps =
                if change == BEFORE_REFIT { judge_steps(&trial.model, &test)? } else { vec![] };
            errors.push(steps.last().unwrap_or(&trial.nrmse_percent).clone());
        }
        let terms = Spread::of(done.iter().map(|trial| trial.terms as f64));
        let head: [Cell; 5] =
            [family.into(), change.into(), equation.into(), done.len().into(), terms.into()];
        let errors = Spread::of_columns(errors.iter().map(Vec::as_slice));
        table.push(head.into_iter().chain(errors.into_iter().map(Cell::from)));
    }
    let text = "One choice of a stepwise method is changed at a time, in case 3. The two libraries \
                beside each other test [E4]; “one step” takes the steps away and leaves everything \
                else.";
    let heading = "What each choice buys";
    Ok(Study { heading, text, tables: vec![table], ..Study::default() })
}
