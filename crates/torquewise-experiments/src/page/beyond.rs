//! From sweeps, arms, coefficients to sections beyond the paper.

use crate::page::Drawn;
use crate::page::cells::{columns, count, table, with_range};
use crate::results::Results;
use crate::study::arms::ArmResults;
use crate::study::coefficients::{CoefficientResults, CoefficientRow};
use crate::study::sweeps::Point;
use torquewise_report::html::number::significant;
use torquewise_report::html::{Item, Section};

/// Noise and data, arms, coefficients.
pub(super) fn sections(results: &Results, drawn: &Drawn) -> Vec<Section> {
    let mut sweeps = drawn.items("beyond_sweeps");
    sweeps.push(Item::Details {
        summary: "The numbers".into(),
        items: vec![
            points("Noise.", &results.noise_sweep),
            points("Length of the log, noise of case 3.", &results.length_sweep),
        ],
    });
    let mut arms = drawn.items("beyond_arms");
    arms.push(arm_table(&results.arms));
    let mut coefficients: Vec<Item> = vec![coverage(&results.coefficients)];
    coefficients.extend(drawn.items("beyond_coefficients"));
    coefficients.extend(results.coefficients.last().map(coefficient_table));
    [
        ("More noise, less data", sweeps),
        ("More joints", arms),
        ("Coefficients and their errors", coefficients),
    ]
    .map(|(heading, items)| Section { heading: heading.into(), items })
    .into()
}

fn points(caption: &str, points: &[Point]) -> Item {
    let row = |point: &Point| {
        let mut row = vec![
            point.method.name().into(),
            point.noise.name(),
            point.log_length.to_string(),
            point.runs.to_string(),
            count(&point.terms),
        ];
        row.push(point.nrmse_percent.iter().map(with_range).collect::<Vec<_>>().join(" / "));
        row
    };
    let columns = columns("method;noise;#log [s];#runs;terms;error [%], joint 1 / 2 / …");
    table(caption, columns, points.iter().map(row).collect())
}

fn arm_table(arms: &[ArmResults]) -> Item {
    let row = |arm: &ArmResults| {
        let errors: Vec<String> =
            arm.nrmse_percent.iter().map(|percent| significant(*percent, 2)).collect();
        vec![
            arm.arm.into(),
            arm.log_length.to_string(),
            arm.energy_candidates.to_string(),
            arm.product_candidates.to_string(),
            arm.sindy_candidates.to_string(),
            format!("{} of {}", arm.right_terms, arm.true_terms),
            (arm.terms - arm.right_terms).to_string(),
            errors.join(" / "),
            significant(arm.seconds, 2),
        ]
    };
    let columns = columns(
        "arm;#log [s];#energy library;#product library;#one-shot SINDy;\
         true terms found;#other terms;error [%], joint 1 / 2 / …;\
         #CPU time [s]",
    );
    let caption = "Candidates of each library, and what the energy library finds in one log with \
                   the noise of case 3. Where terms are missed or false, the error says \
                   how much they matter.";
    table(caption, columns, arms.iter().map(row).collect())
}

fn coverage(results: &[CoefficientResults]) -> Item {
    let row = |found: &CoefficientResults| {
        vec![
            found.case.to_string(),
            format!("{} of {}", found.exact_runs, found.runs),
            found.missed.to_string(),
            found.extra.to_string(),
            format!("{} of {}", found.covered, found.found),
            significant(found.coverage_percent(), 3),
        ]
    };
    let columns = columns(
        "#case;runs with exactly the true terms;#true terms missed;\
         #other terms found;intervals that hold the truth;#share [%]",
    );
    let caption = "Energy models of all seeds: are the true terms found, and do the intervals of \
                   ±1.645 standard errors hold the true coefficients in 90 % of the cases, as they \
                   should?";
    table(caption, columns, results.iter().map(row).collect())
}

fn coefficient_table(results: &CoefficientResults) -> Item {
    let number = |x: Option<f64>, digits| x.map_or_else(|| "–".into(), |x| significant(x, digits));
    let row = |row: &CoefficientRow| {
        vec![
            row.name.clone(),
            significant(row.truth, 6),
            number(row.estimate, 6),
            number(row.std_error, 2),
            format!("{} of {}", row.covered, row.found),
        ]
    };
    let columns = columns("term;#truth;#found, first seed;#standard error;intervals that hold");
    let caption = format!(
        "Coefficients of M(q) [kg·m²] and V(q) [J], case {}: what is true and what is found.",
        results.case
    );
    table(&caption, columns, results.terms.iter().map(row).collect())
}
