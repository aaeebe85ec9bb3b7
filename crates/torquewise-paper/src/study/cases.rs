//! Cases 1–3: candidates and time (Fig. 6), terms kept (Fig. 7), torque outside the training log
//! (Fig. 8), step by step (Fig. 10), coefficients.

use crate::method::{ACTIVE, Method};
use crate::scenario::outside;
use crate::trial::{self, Row, Runs, Trial, Trials, step_lines};
use crate::truth::{true_energies, true_products};
use crate::{Cell, Result, Settings, Spread, Study};
use std::collections::BTreeMap;
use torquewise_identify::LibraryOptions;
use torquewise_model::{EnergyTerm, Model, Torque, Weighted};
use torquewise_report::{significant, torque_charts};
use torquewise_sim::{Arm, Noise};

/// Rows of a prediction that are shown: every fifth of 20 s at 100 Hz.
const STRIDE: usize = 5;
/// A joint is predicted if its error is below this \[%\].
const PREDICTED: f64 = 10.0;
/// Prediction fails where the error of a joint is above this \[%\].
const FAILED: f64 = 15.0;
/// Two counts are about the same within this part of each other.
const ABOUT: f64 = 0.2;
/// Clearly fewer: less than this part.
const FEWER: f64 = 0.5;

/// A method in a case. Without noise one run says all.
pub(crate) fn row(settings: &Settings, case: u8, method: Method) -> Row {
    let seeds = if case == 1 { 1 } else { settings.seeds };
    let scenario = settings.scenario(Noise::CASES[usize::from(case) - 1]);
    Row::new(&[usize::from(case).into(), method.name().into()], &scenario, method.options(), seeds)
}

pub(crate) fn rows(settings: &Settings) -> Vec<Row> {
    let of_case = |case| Method::ALL.map(|method| row(settings, case, method));
    [1, 2, 3].into_iter().flat_map(of_case).collect()
}

/// The three methods of the figure (0, 1 and 6), and LASSO and the threshold for all, like with
/// like: each with its rule for terms.
pub(crate) fn timed_rows(settings: &Settings) -> Vec<Row> {
    let scenario = settings.scenario(Noise::CASES[2]);
    let row = |method: &str, rule: &str, options: LibraryOptions| {
        Row::new(&[method.into(), rule.into()], &scenario, options, settings.timed_seeds)
    };
    let one_shot = [Method::SindyCriterion, Method::SindyLasso, Method::Sindy];
    let stepwise = one_shot.map(|other| Method::Product.with_rule_of(other));
    let mut rows = vec![row("stepwise, energy", "criterion", Method::Energy.options())];
    let one_shot = one_shot.map(Method::options);
    for (method, all) in [("stepwise, product", stepwise), ("one-shot SINDy", one_shot)] {
        let rules = ["criterion", "LASSO", "|c| > 0.1"].into_iter().zip(all);
        rows.extend(rules.map(|(rule, options)| row(method, rule, options)));
    }
    rows
}

pub(crate) fn cost(settings: &Settings, trials: &Trials) -> Study {
    let mut study = Study::described("cost", 0);
    let Study { claims, tables, timed, .. } = &mut study;
    let listed = |trial: &Trial, divider: &str| {
        let steps = trial.candidates_by_step.iter().map(usize::to_string);
        steps.collect::<Vec<_>>().join(divider)
    };
    let costs = |runs: &Runs<'_>| [0, 1].map(|part: usize| runs.spread(|trial| trial.cost[part]));
    let rows = timed_rows(settings);
    let all: Vec<Runs<'_>> = rows.iter().map(|row| trials.of(row)).collect();
    for (row, runs) in rows.iter().zip(&all) {
        let size: [Cell; 2] = [listed(runs.first(), " + ").into(), runs.first().candidates.into()];
        tables[0].push(&row.head, size);
        timed.tables[0].push(&row.head, costs(runs));
    }
    let [energy, stepwise, sindy] = [0, 1, 6].map(|row: usize| all[row].first());
    let largest = |trial: &Trial| trial.candidates_by_step.iter().max().copied();
    let in_all = [sindy, energy].map(|trial| trial.candidates.to_string());
    let values = [[listed(stepwise, ", ")].as_slice(), &in_all].concat();
    claims[0].judge(values, &[largest(stepwise) < largest(sindy)]);
    let (mut values, mut faster) = (Vec::new(), Vec::new());
    for pair in [[1, 6], [1, 4], [2, 5], [3, 6]] {
        let medians = pair.map(|row: usize| costs(&all[row]).map(|cost| cost.median));
        let [[own, own_total], [other, other_total]] = medians;
        faster.push(other > own);
        values
            .extend([own, other, other / own, other_total / own_total].map(|x| significant(x, 2)));
    }
    timed.claims[0].judge(values, &faster);
    study
}

/// Fig. 7: coefficients kept, and those above 0.1, which the paper calls active.
pub(crate) fn terms(settings: &Settings, trials: &Trials) -> Result<Study> {
    let mut study = Study::described("terms", 0);
    let table = &mut study.tables[0];
    for row in rows(settings) {
        let runs = trials.of(&row);
        let head = [format!("case {}", row.head[0].text()).into(), row.head[1].clone()];
        table.push(&head, [runs.spread(|trial| trial.active), runs.spread(|trial| trial.terms)]);
    }
    let arm = Arm::builtin(settings.arm)?;
    let energies: Vec<f64> = true_energies(&arm).into_values().collect();
    let products = true_products(&arm);
    let active = |weights: &[f64]| weights.iter().filter(|weight| weight.abs() > ACTIVE).count();
    for (name, weights) in [("functions of M(q) and V(q)", &energies), ("products", &products)] {
        table.push(&["truth".into(), name.into()], [active(weights), weights.len()]);
    }
    let medians = |case| {
        [Method::Product, Method::Sindy, Method::SindyLasso].map(|method| {
            trials.of(&row(settings, case, method)).spread(|trial| trial.active).median
        })
    };
    let [stepwise, sindy, _] = medians(1);
    let about = (stepwise - sindy).abs() <= ABOUT * sindy.max(stepwise);
    study.claims[0].judge([stepwise, sindy, active(&products) as f64], &[about]);
    let noisy = [medians(2), medians(3)];
    let fewer_than = |other: usize| noisy.iter().all(|case| case[0] < FEWER * case[other]);
    let [sindy, lasso] = [1, 2].map(fewer_than);
    study.claims[1].judge(noisy.concat(), &[sindy, sindy && lasso]);
    Ok(study)
}

/// Fig. 8: torque outside the training log.
pub(crate) fn torque(settings: &Settings, trials: &Trials) -> Result<Study> {
    let test = outside(settings.arm, settings.seed)?;
    let mut study = Study::described("torque", test.n_joints());
    for (case, figure) in (1..).zip(&mut study.figures) {
        let mut predicted = Vec::new();
        for method in Method::ALL {
            let row = row(settings, case, method);
            let runs = trials.of(&row);
            let rmse = Spread::of_columns(runs.0.iter().map(|trial| trial.rmse.as_slice()));
            let head = [&row.head[..], &[runs.0.len().into()]].concat();
            study.tables[0].push(&head, runs.errors().into_iter().chain(rmse));
            let torque = Torque::new(&runs.first().model).over(&test)?;
            predicted.push((method.name().to_owned(), method.colour(), torque));
        }
        // The method to look at lies on top.
        predicted.reverse();
        let linked = format!("case {case}");
        figure.charts = torque_charts(("needed", &test), STRIDE, &predicted, Some(&linked))?;
    }
    let worst = |case, method| trials.of(&row(settings, case, method)).worst().median;
    let both = |method| [2, 3].map(|case| worst(case, method));
    let (product, energy) = (both(Method::Product), both(Method::Energy));
    let values = [product, energy].concat().into_iter().map(|error| significant(error, 2));
    study.claims[0].judge(values, &product.map(|error| error < PREDICTED));
    let ([second, third], lasso) = (both(Method::Sindy), worst(3, Method::SindyLasso));
    let values = [third, second, lasso].map(|error| significant(error, 2));
    study.claims[1].judge(values, &[third, lasso].map(|error| error > FAILED));
    Ok(study)
}

/// Fig. 10, simulated: both libraries after each step, on the first log of case 2.
pub(crate) fn steps(settings: &Settings, trials: &Trials) -> Result<Study> {
    let test = outside(settings.arm, settings.seed)?;
    let mut study = Study::described("steps", test.n_joints());
    let (mut parts, mut falls) = (Vec::new(), Vec::new());
    for method in [Method::Energy, Method::Product] {
        let trial = trials.of(&row(settings, 2, method)).first();
        let steps = trial::steps(&trial.model, Model::clone, &test)?;
        let refit = ("refit of all terms on all rows", &trial.nrmse_percent);
        let all = steps.iter().map(|step| (step.name.as_str(), &step.nrmse_percent));
        for (name, errors) in all.chain([refit]) {
            study.tables[0].push(&[method.name().into(), name.into()], errors.clone());
        }
        let mean = |errors: &[f64]| errors.iter().sum::<f64>() / errors.len() as f64;
        let means: Vec<f64> = steps.iter().map(|step| mean(&step.nrmse_percent)).collect();
        falls.push(means.windows(2).all(|pair| pair[1] < pair[0]));
        let means: Vec<String> = means.iter().map(|mean| significant(*mean, 3)).collect();
        parts.push(means.join(", "));
        if method == Method::Energy {
            study.figures[0].charts =
                torque_charts(("needed", &test), STRIDE, &step_lines(steps), Some("steps"))?;
        }
    }
    study.claims[0].judge(parts, &falls);
    Ok(study)
}

/// A normal variable is within this many standard deviations in 90 of 100 cases.
const NINETY_PERCENT: f64 = 1.645;

/// Coefficient and standard error of each term of a model.
type Found = BTreeMap<EnergyTerm, (f64, f64)>;

/// Coefficients of the energy models beside the truth, and how often their intervals hold it.
pub(crate) fn coefficients(settings: &Settings, trials: &Trials) -> Result<Study> {
    let truth = true_energies(&Arm::builtin(settings.arm)?);
    let mut study = Study::described("coefficients", 0);
    for case in [2, 3] {
        let runs = trials.of(&row(settings, case, Method::Energy));
        let term = |w: &Weighted<EnergyTerm>| (w.term.clone(), (w.coefficient, w.std_error));
        let runs: Vec<Found> =
            runs.0.iter().map(|trial| trial.energies().iter().map(term).collect()).collect();
        let exact = runs.iter().filter(|run| run.keys().eq(truth.keys())).count();
        let kept: usize = runs.iter().map(BTreeMap::len).sum();
        let counts = truth.iter().map(|(term, &truth)| count(term, truth, &runs));
        let (covered, found) = counts.fold((0, 0), |sum, row| (sum.0 + row.0, sum.1 + row.1));
        let of_runs = format!("{exact} of {}", runs.len()).into();
        let wrong = [truth.len() * runs.len() - found, kept - found].map(Cell::from);
        let share = 100.0 * covered as f64 / found.max(1) as f64;
        let held = [format!("{covered} of {found}").into(), share.into()];
        study.tables[0].push(&[usize::from(case).into(), of_runs], wrong.into_iter().chain(held));
        for (term, &truth) in truth.iter().filter(|_| case == 3) {
            let (covered, found) = count(term, truth, &runs);
            let first = runs[0].get(term).map(|(estimate, std_error)| {
                [significant(*estimate, 6), significant(*std_error, 2)]
            });
            let [estimate, std_error] = first.unwrap_or(["–".to_owned(), "–".to_owned()]);
            let held = format!("{covered} of {found}");
            let cells = [significant(truth, 6), estimate, std_error, held];
            study.tables[1].push(&[term.name().into()], cells);
        }
    }
    Ok(study)
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
        let rows = [2, 3].map(|case| row(&settings, case, Method::Energy));
        let trials = Trials::run(&[], &rows, settings.seed, &|_| {}).unwrap();

        let found = coefficients(&settings, &trials).unwrap();

        for row in &found.tables[0].rows {
            assert_eq!(row[1], "5 of 5".into(), "{row:?}");
            // 115 intervals of 90 %, 23 of each log sharing its noise.
            let Cell::Number(share) = row[5] else { panic!("{row:?}") };
            assert!((80.0..=98.0).contains(&share), "{row:?}");
        }
        for trial in rows.iter().flat_map(|row| trials.of(row).0) {
            assert!(trial.nrmse_percent.iter().all(|error| *error < 0.6), "{trial:?}");
        }
    }
}
