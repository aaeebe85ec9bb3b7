//! From method with one choice changed to what that choice buys.

use crate::agenda::{Agenda, TrialId, Trials};
use crate::error::ExperimentError;
use crate::method::{
    Method, MethodPlan, correcting_noise, in_one_step, lasso, selecting, threshold,
    with_printed_index,
};
use crate::scenario::{Decibels, outside};
use crate::settings::Settings;
use crate::spread::Spread;
use crate::trial::judge_steps;
use serde::Serialize;

/// One row of the ablation.
#[derive(Clone, Debug)]
pub(crate) struct VariantPlan {
    family: &'static str,
    change: &'static str,
    equation: &'static str,
    trials: Vec<TrialId>,
    /// Judge the model as it is after the last step, before the refit.
    before_refit: bool,
}

/// A method with one choice changed.
#[derive(Clone, Debug, Serialize)]
pub struct Variant {
    /// The method it comes from.
    pub family: &'static str,
    /// What is changed; `as it is` for nothing.
    pub change: &'static str,
    /// Which of our equations is put to the test; may be empty.
    pub equation: &'static str,
    /// Runs, each with another motion and other noise.
    pub runs: usize,
    /// Coefficients kept.
    pub terms: Spread,
    /// Error outside the training log \[%\], per joint.
    pub nrmse_percent: Vec<Spread>,
}

/// A row that changes nothing.
pub(crate) const AS_IT_IS: &str = "as it is";
/// The row with the paper's constants of the activation index.
const PRINTED: &str = "activation index as printed";

/// Family, change, equation, plan and whether it is judged before the refit.
type Row = (&'static str, &'static str, &'static str, MethodPlan, bool);

fn rows() -> Vec<Row> {
    let mut rows = Vec::new();
    for method in [Method::Energy, Method::Product] {
        let (name, plan) = (method.name(), method.plan());
        let row = |change, equation, plan| (name, change, equation, plan, false);
        rows.extend([
            row(AS_IT_IS, "", plan.clone()),
            row(PRINTED, "[E1]", with_printed_index(plan.clone())),
            row("one step, all rows", "", in_one_step(plan.clone())),
            row("terms chosen by LASSO + BIC", "[E5]", selecting(&plan, lasso())),
            row("terms chosen by |c| > 0.1", "[E5]", selecting(&plan, threshold())),
            (name, "no refit after the last step", "[E6]", plan.clone(), true),
            row("no noise correction", "[E7]", correcting_noise(plan, false)),
        ]);
    }
    let (name, plan) = ("one-shot SINDy", Method::Sindy.plan());
    let chosen = Method::SindyCriterion.plan();
    let uncorrected = correcting_noise(chosen.clone(), false);
    rows.extend([
        (name, "terms chosen by |c| > 0.1", "", plan, false),
        (name, "terms chosen by LASSO + BIC", "", Method::SindyLasso.plan(), false),
        (name, "terms chosen by the criterion", "[E5]", uncorrected, false),
        (name, "criterion, noise correction", "[E7]", chosen, false),
    ]);
    rows
}

/// Every variant in case 3. The printed index leaves the product library with so many terms that
/// its refit takes longest of all: one seed says it.
pub(crate) fn ask(agenda: &mut Agenda, settings: &Settings) -> Vec<VariantPlan> {
    rows()
        .into_iter()
        .map(|(family, change, equation, plan, before_refit)| {
            let scenario = settings.scenario(Decibels::case(3), settings.seed);
            let count = if change == PRINTED { 1 } else { settings.sweep_seeds };
            let trials = agenda.ask_seeds(&scenario, &plan, count);
            VariantPlan { family, change, equation, trials, before_refit }
        })
        .collect()
}

impl VariantPlan {
    /// How the variant does, once its trials are done.
    pub(crate) fn result(
        &self,
        settings: &Settings,
        trials: &Trials,
    ) -> Result<Variant, ExperimentError> {
        let test = outside(settings.arm, settings.seed)?;
        let (mut errors, mut terms) = (Vec::new(), Vec::new());
        for &id in &self.trials {
            let trial = trials.get(id)?;
            terms.push(trial.terms as f64);
            let steps = if self.before_refit { judge_steps(&trial.model, &test)? } else { vec![] };
            errors.push(steps.last().unwrap_or(&trial.nrmse_percent).clone());
        }
        Ok(Variant {
            family: self.family,
            change: self.change,
            equation: self.equation,
            runs: errors.len(),
            terms: Spread::of(terms),
            nrmse_percent: Spread::of_columns(errors.iter().map(Vec::as_slice)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_step_over_products_is_one_shot_sindy_and_all_others_differ() {
        let mut agenda = Agenda::default();

        let variants = ask(&mut agenda, &Settings { sweep_seeds: 1, ..Settings::quick(1) });

        let mut ids: Vec<TrialId> =
            variants.iter().filter(|v| !v.before_refit).flat_map(|v| v.trials.clone()).collect();
        let all = ids.len();
        ids.sort();
        ids.dedup();
        assert_eq!((all, ids.len()), (16, 15));
    }
}
