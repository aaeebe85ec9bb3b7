//! Candidates and computing time of each method (Fig. 6).

use crate::error::PaperError;
use crate::method::{Method, MethodPlan, lasso, selecting, threshold};
use crate::results::{Claim, Study, Table, Timed, Verdict};
use crate::scenario::Decibels;
use crate::settings::Settings;
use crate::spread::Spread;
use crate::trial::{Cost, Trial, TrialPlan, Trials};
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
fn methods() -> [(&'static str, &'static str, MethodPlan); 7] {
    let product = Method::Product.plan();
    [
        (ENERGY, CRITERION, Method::Energy.plan()),
        (PRODUCT, CRITERION, product.clone()),
        (PRODUCT, LASSO, selecting(&product, lasso())),
        (PRODUCT, THRESHOLD, selecting(&product, threshold())),
        (SINDY, CRITERION, Method::SindyCriterion.plan()),
        (SINDY, LASSO, Method::SindyLasso.plan()),
        (SINDY, THRESHOLD, Method::Sindy.plan()),
    ]
}

fn seeds(settings: &Settings, plan: &MethodPlan) -> Vec<TrialPlan> {
    let scenario = settings.scenario(Decibels::case(3), settings.seed);
    TrialPlan::seeds(&scenario, plan, settings.timed_seeds)
}

/// The trials that are timed.
pub(crate) fn plans(settings: &Settings) -> Vec<TrialPlan> {
    methods().iter().flat_map(|(_, _, plan)| seeds(settings, plan)).collect()
}

/// Size and time of one method.
struct Row<'a> {
    name: &'static str,
    rule: &'static str,
    trials: Vec<&'a Trial>,
}

impl Row<'_> {
    fn time(&self, part: fn(&Cost) -> f64) -> Spread {
        Spread::of(self.trials.iter().map(|trial| part(&trial.cost)))
    }

    fn regression(&self) -> Spread {
        self.time(|cost| cost.regression)
    }

    fn candidates_by_step(&self) -> &[usize] {
        &self.trials[0].candidates_by_step
    }
}

/// What each method costs.
pub(crate) fn study(settings: &Settings, trials: &Trials) -> Result<Study, PaperError> {
    let mut rows = Vec::new();
    for (name, rule, plan) in methods() {
        rows.push(Row { name, rule, trials: trials.all(&seeds(settings, &plan))? });
    }
    let mut sizes = Table::new("Candidates.", "method;which terms stay;in each step;in all");
    let mut times = Table::new(
        "CPU time of one thread, median and range over the timed runs, done one by one. Compare \
         rows with the same rule: the rule decides as much about the time as the steps do.",
        "method;which terms stay;regression [s];with clustering and refit [s]",
    );
    for row in &rows {
        let steps: Vec<String> = row.candidates_by_step().iter().map(usize::to_string).collect();
        let steps = steps.join(" + ");
        let (name, rule) = (row.name.into(), row.rule.into());
        sizes.push([name, rule, steps.into(), row.trials[0].candidates.into()]);
        let (regression, total) = (row.regression().into(), row.time(Cost::total).into());
        times.push([row.name.into(), row.rule.into(), regression, total]);
    }
    Ok(Study {
        heading: "Candidates and time (Fig. 6)",
        claims: vec![candidates(&rows)],
        tables: vec![sizes],
        timed: Timed { claims: vec![time(&rows)], tables: vec![times] },
        ..Study::default()
    })
}

fn find<'a, 'b>(rows: &'a [Row<'b>], name: &str, rule: &str) -> &'a Row<'b> {
    rows.iter().find(|row| (row.name, row.rule) == (name, rule)).unwrap_or(&rows[0])
}

fn candidates(rows: &[Row<'_>]) -> Claim {
    let [stepwise, sindy] =
        [find(rows, PRODUCT, CRITERION), find(rows, SINDY, THRESHOLD)].map(Row::candidates_by_step);
    let steps: Vec<String> = stepwise.iter().map(usize::to_string).collect();
    Claim {
        claim: "Stepwise reconstruction reduces the size of the library.",
        source: "Fig. 6(a)",
        measured: format!(
            "{} candidates in the three steps, {} in one shot; {} in the energy library [E4].",
            steps.join(", "),
            sindy[0],
            rows[0].trials[0].candidates
        ),
        verdict: Verdict::when(stepwise.iter().max() < sindy.iter().max(), false),
    }
}

fn time(rows: &[Row<'_>]) -> Claim {
    let pairs =
        [(CRITERION, THRESHOLD), (CRITERION, CRITERION), (LASSO, LASSO), (THRESHOLD, THRESHOLD)];
    let (mut parts, mut faster) = (Vec::new(), Vec::new());
    for (rule, baseline) in pairs {
        let (stepwise, sindy) = (find(rows, PRODUCT, rule), find(rows, SINDY, baseline));
        let [own, other] = [stepwise, sindy].map(|row| row.regression().median);
        let [own_total, other_total] = [stepwise, sindy].map(|row| row.time(Cost::total).median);
        faster.push(other > own);
        parts.push(format!(
            "{rule} beside {baseline}: {} s and {} s, ratio {} (with clustering and refit {})",
            significant(own, 2),
            significant(other, 2),
            significant(other / own, 2),
            significant(other_total / own_total, 2),
        ));
    }
    Claim {
        claim: "Stepwise reconstruction computes faster.",
        source: "Fig. 6(b)",
        measured: format!("CPU time of the regression, stepwise {}.", parts.join("; ")),
        verdict: Verdict::when(faster.iter().all(|faster| *faster), faster.contains(&true)),
    }
}
