//! From timed trials to candidates and computing time of each method (Fig. 6).

use crate::agenda::{Agenda, TrialId, Trials};
use crate::error::{ExperimentError, within};
use crate::method::{Method, MethodPlan, lasso, selecting, threshold};
use crate::scenario::{Decibels, Scenario};
use crate::settings::Settings;
use crate::spread::Spread;
use crate::trial::{Cost, now};
use serde::Serialize;
use torquewise_identify::plan::{LibraryOptions, Regression};
use torquewise_motion::{Motion, Pattern};
use torquewise_regression::accumulate::{Prepared, Route};
use torquewise_regression::samples::Samples;
use torquewise_stepwise::candidates::Candidates;
use torquewise_stepwise::step_equations::{one_shot, plan_steps};

/// A method whose time is measured.
#[derive(Clone, Debug)]
pub(crate) struct CostPlan {
    name: &'static str,
    rule: &'static str,
    plan: MethodPlan,
    trials: Vec<TrialId>,
}

/// Size and time of one method.
#[derive(Clone, Debug, Serialize)]
pub struct MethodCost {
    /// Its library and steps.
    pub name: &'static str,
    /// How it chooses terms.
    pub rule: &'static str,
    /// Candidates offered in each step.
    pub candidates_by_step: Vec<usize>,
    pub candidates: usize,
    /// CPU time on one thread.
    pub seconds: SecondsOf,
}

/// CPU time on one thread \[s\].
#[derive(Clone, Debug, Serialize)]
pub struct SecondsOf {
    pub runs: usize,
    /// Normal equations and selection.
    pub regression: Spread,
    /// The whole reconstruction, from the survey to the refit.
    pub total: Spread,
    /// Normal equations only, if every column is evaluated on every row, as the paper does; from a
    /// tenth of the rows, once.
    pub evaluated: f64,
}

/// The three methods of the figure, and LASSO and the threshold for all, like with like.
pub(crate) fn ask(agenda: &mut Agenda, settings: &Settings) -> Vec<CostPlan> {
    let [energy, product, sindy] =
        [Method::Energy, Method::Product, Method::Sindy].map(Method::plan);
    let rows = [
        (ENERGY, CRITERION, energy),
        (PRODUCT, CRITERION, product.clone()),
        (PRODUCT, LASSO, selecting(&product, lasso())),
        (PRODUCT, THRESHOLD, selecting(&product, threshold())),
        (SINDY, CRITERION, Method::SindyCriterion.plan()),
        (SINDY, LASSO, Method::SindyLasso.plan()),
        (SINDY, THRESHOLD, sindy),
    ];
    rows.into_iter()
        .map(|(name, rule, plan)| {
            let scenario = settings.scenario(Decibels::case(3), settings.seed);
            let trials = agenda.ask_seeds(&scenario, &plan, settings.timed_seeds);
            agenda.time(&trials);
            CostPlan { name, rule, plan, trials }
        })
        .collect()
}

/// Name of the energy library in these results.
pub(crate) const ENERGY: &str = "stepwise, energy";
/// Name of the product library.
pub(crate) const PRODUCT: &str = "stepwise, product";
/// Name of one-shot SINDy.
pub(crate) const SINDY: &str = "one-shot SINDy";
/// A term stays for what it explains \[E5\].
pub(crate) const CRITERION: &str = "criterion";
/// LASSO, information criterion, refit.
pub(crate) const LASSO: &str = "LASSO";
/// |coefficient| > 0.1.
pub(crate) const THRESHOLD: &str = "|c| > 0.1";

/// The part of the log on which every column is evaluated.
const PART: f64 = 10.0;

/// CPU time \[s\] of the normal equations of each plan, column by column: what the shortcut over
/// moments \[E3\] saves. Measured on a part of the log in a pool of one thread; plans of one
/// library share it. The time is proportional to the rows.
pub(crate) fn evaluate(
    plans: &[CostPlan],
    settings: &Settings,
) -> Result<Vec<f64>, ExperimentError> {
    let whole = settings.scenario(Decibels::case(3), settings.seed);
    let scenario = Scenario { seconds: (whole.seconds / PART).max(10.0), ..whole };
    let times = settings.seconds / scenario.seconds;
    let simulation = scenario.simulate()?;
    let log = scenario.record(&simulation)?;
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut seconds: Vec<f64> = Vec::with_capacity(plans.len());
    for CostPlan { name, plan, .. } in plans {
        let known = plans.iter().zip(&seconds).find(|(known, _)| known.name == *name);
        seconds.push(match known {
            Some((_, &seconds)) => seconds,
            None => {
                times
                    * one_thread.install(|| evaluate_all(&log, &simulation.truth, &plan.options))?
            }
        });
    }
    Ok(seconds)
}

/// The costs, once the trials are done.
///
/// - `evaluated`: what [`evaluate`] measured
pub(crate) fn costs(
    plans: &[CostPlan],
    evaluated: &[f64],
    trials: &Trials,
) -> Result<Vec<MethodCost>, ExperimentError> {
    let mut costs = Vec::with_capacity(plans.len());
    for (CostPlan { name, rule, trials: ids, .. }, &evaluated) in plans.iter().zip(evaluated) {
        let done = trials.all(ids)?;
        let Some(first) = done.first() else { continue };
        let spread =
            |part: fn(&Cost) -> f64| Spread::of(done.iter().map(|trial| part(&trial.cost)));
        costs.push(MethodCost {
            name,
            rule,
            candidates_by_step: first.candidates_by_step.clone(),
            candidates: first.candidates,
            seconds: SecondsOf {
                runs: done.len(),
                regression: spread(|cost| cost.regression),
                total: spread(Cost::total),
                evaluated,
            },
        });
    }
    Ok(costs)
}

/// CPU time \[s\] of the normal equations of all steps, every column evaluated on its rows.
fn evaluate_all(
    log: &Motion,
    truth: &[Pattern],
    options: &LibraryOptions,
) -> Result<f64, ExperimentError> {
    let n = log.n_joints();
    let LibraryOptions { library, regression, .. } = *options;
    let candidates = Candidates::new(n, library, regression).map_err(within("cost"))?;
    let steps = match regression {
        Regression::Stepwise => plan_steps(&candidates, &Pattern::ALL).0,
        Regression::OneShot => one_shot(&candidates),
    };
    let start = now();
    for step in steps {
        let design = candidates.design.subset(&step.columns)?;
        let prepared = Prepared::new(&design, Route::Direct);
        let mut sum = prepared.start(n);
        let asked = |row: &usize| step.pattern.is_none_or(|pattern| truth[*row] == pattern);
        let rows: Vec<usize> = (0..log.n_rows()).filter(asked).collect();
        for rows in rows.chunks(torquewise_motion::BLOCK_ROWS) {
            sum.add(&samples_of(&log.select(rows))?)?;
        }
        sum.grams();
    }
    Ok(now().saturating_sub(start).as_secs_f64())
}

/// The rows of a motion in the words of a regression.
pub(super) fn samples_of(motion: &Motion) -> Result<Samples, ExperimentError> {
    let (n, dq, ddq) = (motion.n_joints(), motion.dq(), motion.ddq());
    let rate = |row, j| if j < n { dq[(row, j)] } else { ddq[(row, j - n)] };
    Ok(Samples {
        angles: motion.q().to_owned(),
        variables: faer::Mat::from_fn(motion.n_rows(), 2 * n, rate),
        responses: motion.require_tau()?.to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_is_timed_and_the_smaller_library_costs_less() {
        let settings = Settings { seconds: 30.0, timed_seeds: 2, ..Settings::quick(1) };
        let mut agenda = Agenda::default();
        let plans = ask(&mut agenda, &settings);

        let trials = agenda.run(1).unwrap();
        let costs = costs(&plans, &evaluate(&plans, &settings).unwrap(), &trials).unwrap();

        assert_eq!(costs.len(), 7);
        assert!(costs.iter().all(|cost| cost.seconds.runs == 2 && cost.candidates > 0));
        let of = |name: &str| costs.iter().rfind(|cost| cost.name == name).unwrap();
        assert!(of(ENERGY).candidates < of(PRODUCT).candidates);
        assert!(of(PRODUCT).candidates < of(SINDY).candidates);
        assert!(of(ENERGY).seconds.total.median < of(SINDY).seconds.total.median);
    }
}
