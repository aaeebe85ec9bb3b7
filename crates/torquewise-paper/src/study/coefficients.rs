//! Coefficients of the energy models beside the truth, and how often their intervals hold it.

use crate::error::PaperError;
use crate::method::Method;
use crate::results::{Cell, Study, Table};
use crate::scenario::Settings;
use crate::study::cases;
use crate::trial::{Trial, Trials};
use crate::truth::true_energies;
use std::collections::BTreeMap;
use torquewise_model::{EnergyTerm, Form};
use torquewise_report::html::number::significant;
use torquewise_sim::Arm;

/// A normal variable is within this many standard deviations in 90 of 100 cases.
const NINETY_PERCENT: f64 = 1.645;

/// Coefficient and standard error of each term of a model.
type Found = BTreeMap<EnergyTerm, (f64, f64)>;

/// Cases 2 and 3.
pub(crate) fn study(settings: &Settings, trials: &Trials) -> Result<Study, PaperError> {
    let truth = true_energies(&Arm::builtin(settings.arm)?);
    let mut coverage = Table::new(
        "Energy models of all seeds: are the true terms found, and do the intervals of ±1.645 \
         standard errors hold the true coefficients in 90 % of the cases, as they should?",
        "case;runs with exactly the true terms;true terms missed;other terms found;\
         intervals that hold the truth;share [%]",
    );
    let mut terms = Table::new(
        "Coefficients of M(q) [kg·m²] and V(q) [J], case 3.",
        "term;truth;found, first seed;standard error;intervals that hold",
    );
    for case in [2, 3] {
        let runs = trials.runs(&cases::seeds(settings, case, Method::Energy))?;
        let coefficients = |trial: &&Trial| match &trial.model.form {
            Form::Energy(terms) => {
                terms.iter().map(|w| (w.term.clone(), (w.coefficient, w.std_error))).collect()
            }
            Form::Torque(_) => Found::new(),
        };
        let runs: Vec<Found> = runs.0.iter().map(coefficients).collect();
        let extra = |run: &Found| run.keys().filter(|term| !truth.contains_key(term)).count();
        let missed = |run: &Found| truth.keys().filter(|term| !run.contains_key(term)).count();
        let exact = runs.iter().filter(|run| extra(run) + missed(run) == 0).count();
        let counts = truth.iter().map(|(term, &truth)| count(term, truth, &runs));
        let (covered, found) = counts.fold((0, 0), |sum, row| (sum.0 + row.0, sum.1 + row.1));
        coverage.push([
            usize::from(case).into(),
            format!("{exact} of {}", runs.len()).into(),
            runs.iter().map(missed).sum::<usize>().into(),
            runs.iter().map(extra).sum::<usize>().into(),
            format!("{covered} of {found}").into(),
            (100.0 * covered as f64 / found.max(1) as f64).into(),
        ]);
        for (term, &truth) in truth.iter().filter(|_| case == 3) {
            let (covered, found) = count(term, truth, &runs);
            let first = runs[0].get(term).map(|(estimate, std_error)| {
                [significant(*estimate, 6), significant(*std_error, 2)]
            });
            let [estimate, std_error] = first.unwrap_or(["–".to_owned(), "–".to_owned()]);
            let held = format!("{covered} of {found}");
            let cells = [term.name(), significant(truth, 6), estimate, std_error, held];
            terms.push(cells.map(Cell::from));
        }
    }
    let heading = "Coefficients and their errors";
    Ok(Study { heading, tables: vec![coverage, terms], ..Study::default() })
}

/// Runs whose 90 % interval holds the truth, and runs that found the term at all.
fn count(term: &EnergyTerm, truth: f64, runs: &[Found]) -> (usize, usize) {
    let found = runs.iter().filter_map(|run| run.get(term));
    let holds = |(estimate, std_error): &&(f64, f64)| {
        (estimate - truth).abs() <= NINETY_PERCENT * std_error
    };
    (found.clone().filter(holds).count(), found.count())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The energy model of the reference arm over five logs: terms, error and intervals.
    #[test]
    fn in_noise_the_true_terms_are_found_and_the_intervals_hold_the_truth() {
        let settings = Settings { seconds: 200.0, seeds: 5, ..Settings::full(1) };
        let plans = [2, 3].map(|case| cases::seeds(&settings, case, Method::Energy)).concat();
        let trials = Trials::run(&[], &plans, settings.seed, &|_| {}).unwrap();

        let found = study(&settings, &trials).unwrap();

        for row in &found.tables[0].rows {
            assert_eq!(row[1], "5 of 5".into(), "{row:?}");
            // 115 intervals of 90 %, 23 of each log sharing its noise.
            let Cell::Number(share) = row[5] else { panic!("{row:?}") };
            assert!((80.0..=98.0).contains(&share), "{row:?}");
        }
        for trial in trials.runs(&plans).unwrap().0 {
            assert!(trial.nrmse_percent.iter().all(|error| *error < 0.6), "{trial:?}");
        }
    }
}
