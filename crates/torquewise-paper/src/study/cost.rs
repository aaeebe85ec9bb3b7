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

/// The three methods of the figure, and LASSO and the threshold for all, like with like.
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

/// A method, its rule for which terms stay, and what came of it.
type Row<'a> = (&'static str, &'static str, Runs<'a>);

/// What each method costs.
pub(crate) fn study(settings: &Settings, trials: &Trials) -> Result<Study, PaperError> {
    let mut rows: Vec<Row<'_>> = Vec::new();
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
        rows.push((name, rule, runs));
    }
    Ok(Study {
        heading: "Candidates and time (Fig. 6)",
        claims: vec![candidates(&rows)],
        tables: vec![sizes],
        timed: Timed { claims: vec![time(&rows)], tables: vec![times] },
        ..Study::default()
    })
}

/// Candidates in each step.
fn listed(runs: &Runs<'_>, divider: &str) -> String {
    let steps = runs.first().candidates_by_step.iter().map(usize::to_string);
    steps.collect::<Vec<_>>().join(divider)
}

fn find<'a, 'b>(rows: &'a [Row<'b>], name: &str, rule: &str) -> &'a Runs<'b> {
    &rows.iter().find(|row| (row.0, row.1) == (name, rule)).unwrap_or(&rows[0]).2
}

fn candidates(rows: &[Row<'_>]) -> Claim {
    let (stepwise, sindy) = (find(rows, PRODUCT, CRITERION), find(rows, SINDY, THRESHOLD));
    let largest = |runs: &Runs<'_>| runs.first().candidates_by_step.iter().max().copied();
    Claim::new(
        "Fig. 6(a)",
        "Stepwise reconstruction reduces the size of the library.",
        format!(
            "{} candidates in the three steps, {} in one shot; {} in the energy library [E4].",
            listed(stepwise, ", "),
            sindy.first().candidates_by_step[0],
            find(rows, ENERGY, CRITERION).first().candidates
        ),
        [largest(stepwise) < largest(sindy), false],
    )
}

fn time(rows: &[Row<'_>]) -> Claim {
    let pairs =
        [(CRITERION, THRESHOLD), (CRITERION, CRITERION), (LASSO, LASSO), (THRESHOLD, THRESHOLD)];
    let (mut parts, mut faster) = (Vec::new(), Vec::new());
    for (rule, baseline) in pairs {
        let both = [find(rows, PRODUCT, rule), find(rows, SINDY, baseline)];
        let median =
            |part: fn(&Cost) -> f64| both.map(|runs| runs.spread(|trial| part(&trial.cost)).median);
        let ([own, other], [own_total, other_total]) =
            (median(|cost| cost.regression), median(|cost| cost.total));
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
