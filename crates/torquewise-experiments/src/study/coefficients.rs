//! From energy models over many seeds to coefficients beside the truth, and how often intervals
//! hold.

use crate::agenda::Trials;
use crate::error::ExperimentError;
use crate::method::Method;
use crate::settings::Settings;
use crate::study::cases::CasePlan;
use crate::truth::true_energies;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use torquewise_model::{EnergyTerm, Form, Model};
use torquewise_sim::Arm;

/// A normal variable is within this many standard deviations in 90 of 100 cases.
pub(crate) const NINETY_PERCENT: f64 = 1.645;

/// The coefficients of one case.
#[derive(Clone, Debug, Serialize)]
pub struct CoefficientResults {
    /// 1, 2 or 3.
    pub case: u8,
    pub runs: usize,
    /// Runs in which exactly the true terms were found.
    pub exact_runs: usize,
    /// True terms missed, over all runs.
    pub missed: usize,
    /// Terms found that are not true, over all runs.
    pub extra: usize,
    /// True terms found, over all runs.
    pub found: usize,
    /// Those of them whose 90 % interval holds the truth.
    pub covered: usize,
    /// The true terms.
    pub terms: Vec<CoefficientRow>,
}

impl CoefficientResults {
    /// Share of the 90 % intervals that hold the truth \[%\].
    pub fn coverage_percent(&self) -> f64 {
        100.0 * self.covered as f64 / self.found.max(1) as f64
    }
}

/// One true term.
#[derive(Clone, Debug, Serialize)]
pub struct CoefficientRow {
    pub name: String,
    /// Its true coefficient, SI units.
    pub truth: f64,
    /// What the first seed found; `None` if it missed the term.
    pub estimate: Option<f64>,
    /// Its standard error.
    pub std_error: Option<f64>,
    /// Runs that found it.
    pub found: usize,
    /// Runs whose 90 % interval holds the truth.
    pub covered: usize,
}

type Found = BTreeMap<EnergyTerm, (f64, f64)>;

/// Judges the coefficients of the energy models of a case.
pub(crate) fn judge_coefficients(
    case: &CasePlan,
    settings: &Settings,
    trials: &Trials,
) -> Result<CoefficientResults, ExperimentError> {
    let truth = true_energies(&Arm::builtin(settings.arm)?);
    let done = trials.all(case.trials(Method::Energy))?;
    let runs: Vec<Found> = done.iter().map(|trial| coefficients_of(&trial.model)).collect();
    let terms: Vec<CoefficientRow> =
        truth.iter().map(|(term, &truth)| row(term, truth, &runs)).collect();
    let true_terms: BTreeSet<&EnergyTerm> = truth.keys().collect();
    let extra = |run: &Found| run.keys().filter(|term| !true_terms.contains(term)).count();
    let missed = |run: &Found| truth.keys().filter(|term| !run.contains_key(term)).count();
    Ok(CoefficientResults {
        case: case.case,
        runs: runs.len(),
        exact_runs: runs.iter().filter(|run| extra(run) + missed(run) == 0).count(),
        missed: runs.iter().map(missed).sum(),
        extra: runs.iter().map(extra).sum(),
        found: terms.iter().map(|row| row.found).sum(),
        covered: terms.iter().map(|row| row.covered).sum(),
        terms,
    })
}

fn coefficients_of(model: &Model) -> Found {
    let Form::Energy(terms) = &model.form else { return Found::new() };
    terms.iter().map(|w| (w.term.clone(), (w.coefficient, w.std_error))).collect()
}

fn row(term: &EnergyTerm, truth: f64, runs: &[Found]) -> CoefficientRow {
    let first = runs.first().and_then(|run| run.get(term));
    let found: Vec<&(f64, f64)> = runs.iter().filter_map(|run| run.get(term)).collect();
    let holds = |(estimate, std_error): &&&(f64, f64)| {
        (estimate - truth).abs() <= NINETY_PERCENT * std_error
    };
    CoefficientRow {
        name: term.name(),
        truth,
        estimate: first.map(|(estimate, _)| *estimate),
        std_error: first.map(|(_, std_error)| *std_error),
        found: found.len(),
        covered: found.iter().filter(holds).count(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::agenda::Agenda;
    use crate::study::cases::ask_methods;
    use torquewise_model::library::energy_library;

    #[test]
    fn an_interval_holds_the_truth_within_1_645_standard_errors() {
        let term = energy_library(1, None).remove(0);
        let run = |estimate| Found::from([(term.clone(), (estimate, 0.1))]);
        let runs = [run(1.16), run(0.84), run(1.17), Found::new()];

        let row = row(&term, 1.0, &runs);

        assert_eq!((row.found, row.covered, row.estimate), (3, 2, Some(1.16)));
    }

    /// The energy model of the reference arm over five logs: terms, error and intervals.
    #[test]
    fn in_noise_the_true_terms_are_found_and_the_intervals_hold_the_truth() {
        let settings = Settings { seconds: 200.0, seeds: 5, ..Settings::full(1) };
        let mut agenda = Agenda::default();
        let cases = ask_methods(&mut agenda, &settings, &[Method::Energy]);
        let trials = agenda.run(settings.seed).unwrap();

        for case in cases.iter().filter(|case| case.case > 1) {
            let found = judge_coefficients(case, &settings, &trials).unwrap();
            assert_eq!((found.runs, found.exact_runs), (5, 5), "case {}", case.case);
            // 115 intervals of 90 %, 23 of each log sharing its noise.
            let share = found.coverage_percent();
            assert!((80.0..=98.0).contains(&share), "case {}: {share}", case.case);

            let errors = case.results(&settings, &trials).unwrap().methods[0].nrmse_percent.clone();
            for (error, limit) in errors.iter().zip([0.3, 0.1, 0.1]) {
                assert!(error.median < limit, "case {}: {errors:?}", case.case);
            }
        }
    }
}
