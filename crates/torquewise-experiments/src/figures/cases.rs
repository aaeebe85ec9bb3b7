//! From cases to Fig. 7 and 8: terms kept, torque outside the training log, its error.

use crate::figures::Figure;
use crate::figures::looks::{beside, colour, places, spread_series, torque_chart};
use crate::results::Results;
use crate::spread::Spread;
use crate::study::cases::{CaseResults, MethodResults, Prediction};
use torquewise_report::html::{Axis, Chart, Guide, Mark, Series};

/// Terms, then the torque of each case, then the errors.
pub(crate) fn figures(results: &Results) -> Vec<Figure> {
    let mut figures = vec![terms(results)];
    figures.extend(results.cases.iter().map(torque));
    figures.push(errors(results));
    figures
}

fn terms(results: &Results) -> Figure {
    let truth = &results.true_terms;
    let products = |counts: &[usize]| counts.iter().sum::<usize>() as f64;
    let guides = |products: f64, energies: usize| {
        vec![Guide::at_y(products, "true products"), Guide::at_y(energies as f64, "true energies")]
    };
    Figure {
        name: "fig7_terms".into(),
        title: "Fig. 7: terms of the models".into(),
        caption: "Left: coefficients above 0.1, which the paper calls active. Right: all \
                  coefficients kept. Medians with ranges over the seeds; dashed lines are the \
                  number of terms of the true arm, in products of sines and cosines for the \
                  product library and SINDy, in functions of M(q) and V(q) for the energy library."
            .into(),
        charts: vec![
            counts(
                results,
                "Active, |coefficient| > 0.1",
                |method| method.active,
                guides(products(&truth.active_products), truth.active_energies),
            ),
            counts(
                results,
                "Kept",
                |method| method.terms,
                guides(products(&truth.products), truth.energies),
            ),
        ],
        columns: 2,
    }
}

fn counts(
    results: &Results,
    title: &str,
    count: fn(&MethodResults) -> Spread,
    guides: Vec<Guide>,
) -> Chart {
    Chart {
        title: title.into(),
        x: places("", results.cases.iter().map(|case| format!("case {}", case.case))),
        y: Axis::log("terms, all joints"),
        series: by_method(&results.cases, |place, series, methods| {
            vec![(beside(place, series, methods.len()), count(&methods[series]))]
        }),
        guides,
        ..Chart::default()
    }
}

/// One series per method over the cases.
fn by_method(
    cases: &[CaseResults],
    points: impl Fn(usize, usize, &[MethodResults]) -> Vec<(f64, Spread)>,
) -> Vec<Series> {
    let methods = cases.first().map_or(&[][..], |case| &case.methods);
    let series = |(place, method): (usize, &MethodResults)| {
        let of_cases = cases.iter().enumerate();
        let points = of_cases.flat_map(|(case, found)| points(case, place, &found.methods));
        let method = method.method;
        spread_series(method.name(), colour(method), Mark::Rings, points)
    };
    methods.iter().enumerate().map(series).collect()
}

fn torque(case: &CaseResults) -> Figure {
    let Prediction { t, needed, predicted } = &case.prediction;
    let chart = |joint: usize| {
        // The method to look at lies on top.
        let others = case.methods.iter().zip(predicted).rev().map(|(method, torque)| {
            (method.method.name().into(), colour(method.method), torque[joint].as_slice())
        });
        let title = format!("Joint {}", joint + 1);
        torque_chart(title, t, ("needed", &needed[joint]), others, &format!("case {}", case.case))
    };
    Figure {
        name: format!("fig8_case{}", case.case),
        title: format!("Fig. 8, case {}: torque outside the training log", case.case),
        caption: format!(
            "Smooth motion that no training log holds, without noise. Models of the first seed; \
             noise in the log they are learned from: {}. The axes are those of the torque that is \
             needed; a prediction that leaves them is cut off.",
            case.noise.name()
        ),
        charts: (0..needed.len()).map(chart).collect(),
        columns: 1,
    }
}

fn errors(results: &Results) -> Figure {
    let chart = |case: &CaseResults| {
        let joints = case.methods.first().map_or(0, |method| method.nrmse_percent.len());
        let series = case.methods.iter().enumerate().map(|(place, method)| {
            let spreads = method.nrmse_percent.iter().enumerate();
            let points =
                spreads.map(|(joint, error)| (beside(joint, place, case.methods.len()), *error));
            spread_series(method.method.name(), colour(method.method), Mark::Rings, points)
        });
        Chart {
            title: format!("Case {}, noise {}", case.case, case.noise.name()),
            x: places("", (1..=joints).map(|joint| format!("joint {joint}"))),
            y: Axis::log("RMSE / std(torque) [%]"),
            series: series.collect(),
            ..Chart::default()
        }
    };
    let noisy = results.cases.iter().filter(|case| case.case > 1);
    Figure {
        name: "fig8_errors".into(),
        title: "Fig. 8 in numbers: error outside the training log".into(),
        caption: "Medians with ranges over the seeds, each another motion and other noise. Both \
                  axes of error are logarithmic: a line is a factor of ten."
            .into(),
        charts: noisy.map(chart).collect(),
        columns: 2,
    }
}
