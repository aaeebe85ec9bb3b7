//! Candidates and computing time of each method (Fig. 6).

use crate::error::PaperError;
use crate::method::{Method, lasso, threshold};
use crate::results::{Claim, Study, Table, Timed};
use crate::scenario::{Decibels, Settings};
use crate::trial::{Cost, Runs, TrialPlan, Trials};
use torquewise_identify::plan::LibraryOptions;
use torquewise_report::html::number::significant;

const ENERGY: &str = "stepwise, energy";
const PRODUCT: &str = "stepwise, product";
const SINDY: &str = "one-shot SINDy";
/// A term stays for what it explains \[E5\].
const CRITERION: &str = "criterion";
/// LASSO, information criterion, refit.
const LASSO: &str = "LASSO";
/// |coefficient| > 0.1.
const THRESHOLD: &str = "|c| > 0.1";

/// The three methods of the figure (0, 1 and 6), and LASSO and the threshold for all, like with
/// like.
fn methods() -> [(&'static str, &'static str, LibraryOptions); 7] {
    let product = |selector| LibraryOptions { selector, ..Method::Product.options() };
    [
        (ENERGY, CRITERION, Method::Energy.options()),
        (PRODUCT, CRITERION, Method::Product.options()),
        (PRODUCT, LASSO, product(lasso())),
        (PRODUCT, THRESHOLD, product(threshold())),
        (SINDY, CRITERION, Method::SindyCriterion.options()),
        (SINDY, LASSO, Method::SindyLasso.options()),
        (SINDY, THRESHOLD, Method::Sindy.options()),
    ]
}

fn seeds(settings: &Settings, options: LibraryOptions) -> Vec<TrialPlan> {
    let scenario = settings.scenario(Decibels::case(3), settings.seed);
    TrialPlan::seeds(&scenario, options, settings.timed_seeds)
}

/// The trials that are timed.
pub(crate) fn plans(settings: &Settings) -> Vec<TrialPlan> {
    methods().into_iter().flat_map(|(_, _, options)| seeds(settings, options)).collect()
}

/// What each method costs.
pub(crate) fn study(settings: &Settings, trials: &Trials) -> Result<Study, PaperError> {
    let mut all = Vec::new();
    let mut sizes = Table::new("Candidates.", "method;which terms stay;in each step;in all");
    let mut times = Table::new(
        "CPU time of one thread, median and range over the timed runs, done one by one. Compare \
         rows with the same rule: the rule decides as much about the time as the steps do.",
        "method;which terms stay;regression [s];with clustering and refit [s]",
    );
    for (name, rule, options) in methods() {
        let runs = trials.runs(&seeds(settings, options))?;
        let steps = listed(&runs, " + ");
        sizes.push([name.into(), rule.into(), steps.into(), runs.first().candidates.into()]);
        let costs = [|cost: &Cost| cost.regression, |cost: &Cost| cost.total];
        let costs = costs.map(|part| runs.spread(|trial| part(&trial.cost)));
        times.push_with([name.into(), rule.into()], costs);
        all.push(runs);
    }
    Ok(Study {
        heading: "Candidates and time (Fig. 6)",
        claims: vec![candidates(&all)],
        tables: vec![sizes],
        timed: Timed { claims: vec![time(&all)], tables: vec![times] },
        ..Study::default()
    })
}

/// Candidates in each step.
fn listed(runs: &Runs<'_>, divider: &str) -> String {
    let steps = runs.first().candidates_by_step.iter().map(usize::to_string);
    steps.collect::<Vec<_>>().join(divider)
}

fn candidates(all: &[Runs<'_>]) -> Claim {
    let [energy, stepwise, sindy] = [0, 1, 6].map(|row| &all[row]);
    let largest = |runs: &Runs<'_>| runs.first().candidates_by_step.iter().max().copied();
    Claim::new(
        "Fig. 6(a)",
        "Stepwise reconstruction reduces the size of the library.",
        format!(
            "{} candidates in the three steps, {} in one shot; {} in the energy library [E4].",
            listed(stepwise, ", "),
            sindy.first().candidates_by_step[0],
            energy.first().candidates
        ),
        [largest(stepwise) < largest(sindy), false],
    )
}

fn time(all: &[Runs<'_>]) -> Claim {
    let methods = methods();
    let (mut parts, mut faster) = (Vec::new(), Vec::new());
    for pair in [[1, 6], [1, 4], [2, 5], [3, 6]] {
        let [rule, baseline] = pair.map(|row| methods[row].1);
        let median = |part: fn(&Cost) -> f64| {
            pair.map(|row| all[row].spread(|trial| part(&trial.cost)).median)
        };
        let [own, other] = median(|cost| cost.regression);
        let [own_total, other_total] = median(|cost| cost.total);
        faster.push(other > own);
        parts.push(format!(
            "{rule} beside {baseline}: {} s and {} s, ratio {} (with clustering and refit {})",
            significant(own, 2),
            significant(other, 2),
            significant(other / own, 2),
            significant(other_total / own_total, 2),
        ));
    }
    Claim::new(
        "Fig. 6(b)",
        "Stepwise reconstruction computes faster.",
        format!("CPU time of the regression, stepwise {}.", parts.join("; ")),
        [faster.iter().all(|faster| *faster), faster.contains(&true)],
    )
}
