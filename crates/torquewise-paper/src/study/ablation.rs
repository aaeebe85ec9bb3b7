//! What each choice buys: a method with one choice changed at a time, in case 3.

use crate::error::PaperError;
use crate::method::{Method, lasso, threshold};
use crate::results::{Study, Table};
use crate::scenario::{Decibels, outside};
use crate::settings::Settings;
use crate::spread::Spread;
use crate::trial::{TrialPlan, Trials, judge_steps};
use torquewise_identify::plan::{LibraryOptions, Regression};
use torquewise_identify::{PatternPlan, Plan};
use torquewise_stepwise::activation::Scaling;

/// The row with the paper's constants of the activation index.
const PRINTED: &str = "activation index as printed";
/// The row that is judged after the last step, before the refit.
const BEFORE_REFIT: &str = "no refit after the last step";

/// Family, what is changed, the equation that this puts to the test, the plan.
type Variant = (&'static str, &'static str, &'static str, Plan);

fn variants() -> Vec<Variant> {
    let mut variants = Vec::new();
    let uncorrected = |options| LibraryOptions { noise_correction: false, ..options };
    for method in [Method::Energy, Method::Product] {
        let (name, options) = (method.name(), method.options());
        let selecting = |selector| LibraryOptions { selector, ..options.clone() }.into();
        let patterns =
            PatternPlan { scaling: Scaling::Paper, clusters: Some(3), ..PatternPlan::default() };
        let one_step = LibraryOptions { regression: Regression::OneShot, ..options.clone() };
        let plan = Plan::from(options.clone());
        variants.extend([
            (name, "as it is", "", plan.clone()),
            (name, PRINTED, "[E1]", Plan { patterns, ..plan.clone() }),
            (name, "one step, all rows", "", one_step.into()),
            (name, "terms chosen by LASSO + BIC", "[E5]", selecting(lasso())),
            (name, "terms chosen by |c| > 0.1", "[E5]", selecting(threshold())),
            (name, BEFORE_REFIT, "[E6]", plan),
            (name, "no noise correction", "[E7]", uncorrected(options.clone()).into()),
        ]);
    }
    let (name, chosen) = ("one-shot SINDy", Method::SindyCriterion.options());
    variants.extend([
        (name, "terms chosen by |c| > 0.1", "", Method::Sindy.options().into()),
        (name, "terms chosen by LASSO + BIC", "", Method::SindyLasso.options().into()),
        (name, "terms chosen by the criterion", "[E5]", uncorrected(chosen.clone()).into()),
        (name, "criterion, noise correction", "[E7]", chosen.into()),
    ]);
    variants
}

/// The trials of a variant. The printed index leaves the product library with so many terms that
/// its refit takes longest of all: one seed says it.
fn seeds(settings: &Settings, (_, change, _, plan): &Variant) -> Vec<TrialPlan> {
    let scenario = settings.scenario(Decibels::case(3), settings.seed);
    let seeds = if *change == PRINTED { 1 } else { settings.sweep_seeds };
    TrialPlan::seeds(&scenario, plan.clone(), seeds)
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
        let runs = trials.runs(&seeds(settings, &variant))?;
        let (family, change, equation, _) = variant;
        let mut errors = runs.errors();
        if change == BEFORE_REFIT {
            let steps = runs.0.iter().map(|trial| judge_steps(&trial.model, &test));
            let steps = steps.collect::<Result<Vec<_>, _>>()?;
            errors = Spread::of_columns(steps.iter().filter_map(|s| s.last().map(Vec::as_slice)));
        }
        let (count, terms) = (runs.0.len().into(), runs.terms().into());
        table.push_with([family.into(), change.into(), equation.into(), count, terms], errors);
    }
    let text = "One choice of a stepwise method is changed at a time, in case 3. The two libraries \
                beside each other test [E4]; “one step” takes the steps away and leaves everything \
                else.";
    let heading = "What each choice buys";
    Ok(Study { heading, text, tables: vec![table], ..Study::default() })
}
