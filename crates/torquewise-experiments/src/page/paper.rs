//! From results to the figures of the paper with what is seen in them.

use crate::page::Drawn;
use crate::page::cells::{columns, count, joints, listed, table, with_range};
use crate::results::Results;
use crate::study::cost::MethodCost;
use crate::study::patterns::PatternStudy;
use torquewise_report::html::number::significant;
use torquewise_report::html::{Column, Item, Section};

/// Fig. 1–3, 5, 6, 7, 8 and 10.
pub(super) fn sections(results: &Results, drawn: &Drawn) -> Vec<Section> {
    vec![
        patterns(results, drawn),
        section("Orders (Fig. 5)", drawn.items("fig5_orders"), vec![orders(results)]),
        section("Candidates and time (Fig. 6)", drawn.items("fig6_cost"), vec![costs(results)]),
        section("Active terms (Fig. 7)", drawn.items("fig7_terms"), vec![terms(results)]),
        torque(results, drawn),
        section("Step by step (Fig. 10)", drawn.items("fig10_steps"), vec![steps(results)]),
    ]
}

fn section(heading: &str, mut items: Vec<Item>, more: Vec<Item>) -> Section {
    items.extend(more);
    Section { heading: heading.into(), items }
}

fn patterns(results: &Results, drawn: &Drawn) -> Section {
    let mut items = drawn.items("fig1_activation");
    items.push(purities(&results.patterns.studies));
    items.push(Item::Text(
        "Why the printed index fails: it was made for motion in one direction. For motion the \
         other way the sum of the rates is negative and I = 1 − W‖a‖₁, which runs from 1 for slow \
         motion through 0 at ‖a‖₁ = 1/W down to negative values for fast motion. A distance in \
         that plane tells nothing about the pattern. Scaling each joint by its range and keeping \
         W below 1/n leaves the switch S(a) to decide."
            .into(),
    ));
    items.extend(drawn.items("fig2_elbow"));
    items.extend(drawn.items("fig3_patterns"));
    Section { heading: "Patterns (Fig. 1–3)".into(), items }
}

fn purities(studies: &[PatternStudy]) -> Item {
    let rows = studies.iter().flat_map(|study| {
        study.purities.iter().map(|purity| {
            vec![
                study.noise.name(),
                study.index.into(),
                study.elbow.to_string(),
                purity.pattern.into(),
                purity.rows.to_string(),
                purity.labelled.to_string(),
                significant(purity.percent(), 3),
                significant(purity.found_percent(), 3),
            ]
        })
    });
    let columns = columns(
        "noise on q/dq/ddq;index;#k at the elbow;pattern;#rows, true;\
         #rows, labelled;#purity [%];#found [%]",
    );
    let caption = "Purity: share of the labelled rows that truly show the pattern. Found: share of \
                   the true rows that are labelled so. Three clusters in every row of the table.";
    table(caption, columns, rows.collect())
}

fn orders(results: &Results) -> Item {
    let rows = results.orders.iter().flat_map(|orders| {
        orders.curves.iter().map(|curve| {
            let point = &curve.points[curve.chosen];
            let second =
                if point.motion_order > 0 { point.motion_order.to_string() } else { "–".into() };
            let worst = 100.0 * point.residual.iter().copied().fold(0.0, f64::max);
            vec![
                orders.noise.name(),
                curve.name.clone(),
                point.order.to_string(),
                second,
                point.candidates.to_string(),
                significant(worst, 2),
            ]
        })
    });
    let columns = columns(
        "noise;library;#N₁ or angles in a term;#N₂;#candidates;\
         #held-out residual, worst joint [%]",
    );
    table("The orders that the rule chooses.", columns, rows.collect())
}

fn costs(results: &Results) -> Item {
    let row = |cost: &MethodCost| {
        vec![
            cost.name.into(),
            cost.rule.into(),
            listed(&cost.candidates_by_step),
            with_range(&cost.seconds.regression),
            with_range(&cost.seconds.total),
            significant(cost.seconds.evaluated, 2),
        ]
    };
    let columns = columns(
        "method;which terms stay;candidates;regression [s];whole [s];\
         #normal equations, columns evaluated [s]",
    );
    let caption = "CPU time of one thread, median and range over the timed runs, done one by \
                   one. Compare rows with the same rule: the rule decides as much about the \
                   time as the steps do.";
    table(caption, columns, results.costs.iter().map(row).collect())
}

fn terms(results: &Results) -> Item {
    let truth = &results.true_terms;
    let mut rows: Vec<Vec<String>> = results
        .cases
        .iter()
        .flat_map(|case| {
            case.methods.iter().map(|found| {
                vec![
                    format!("case {}", case.case),
                    found.method.name().into(),
                    count(&found.active),
                    count(&found.terms),
                ]
            })
        })
        .collect();
    rows.push(vec![
        "truth".into(),
        "functions of M(q) and V(q)".into(),
        truth.active_energies.to_string(),
        truth.energies.to_string(),
    ]);
    rows.push(vec![
        "truth".into(),
        format!("products, joints {}", listed(&truth.products)),
        truth.active_products.iter().sum::<usize>().to_string(),
        truth.products.iter().sum::<usize>().to_string(),
    ]);
    let columns = columns(";;|coefficient| > 0.1;kept");
    table("Terms of all joints together, median and range over the seeds.", columns, rows)
}

fn torque(results: &Results, drawn: &Drawn) -> Section {
    let mut items = drawn.items("fig8_errors");
    let count = results.cases.first().map_or(0, |case| case.prediction.needed.len());
    let mut columns = columns("case;method");
    columns.push(Column::numbers("runs"));
    columns.extend(joints("error [%], joint", count));
    columns.extend(joints("RMSE [N·m], joint", count));
    let rows = results.cases.iter().flat_map(|case| {
        case.methods.iter().map(|found| {
            let mut row =
                vec![case.case.to_string(), found.method.name().into(), found.runs.to_string()];
            row.extend(found.nrmse_percent.iter().map(with_range));
            row.extend(found.rmse.iter().map(with_range));
            row
        })
    });
    items.push(table("Median and range over the seeds.", columns, rows.collect()));
    for case in &results.cases {
        items.push(Item::Heading(format!("Case {}", case.case)));
        items.extend(drawn.items(&format!("fig8_case{}", case.case)));
    }
    Section { heading: "Torque outside the training log (Fig. 8)".into(), items }
}

fn steps(results: &Results) -> Item {
    let count = results.steps.first().map_or(0, |steps| steps.refitted_nrmse_percent.len());
    let mut columns = columns("method;after");
    columns.extend(joints("error [%], joint", count));
    let mut rows = Vec::new();
    for steps in &results.steps {
        let stages = steps.names.iter().zip(&steps.nrmse_percent);
        let refitted = ("refit of all terms on all rows".to_owned(), &steps.refitted_nrmse_percent);
        let named = stages
            .enumerate()
            .map(|(place, (name, errors))| (format!("step {}: {name}", place + 1), errors));
        for (name, errors) in named.chain(std::iter::once(refitted)) {
            let mut row = vec![steps.method.name().into(), name];
            row.extend(errors.iter().map(|percent| significant(*percent, 2)));
            rows.push(row);
        }
    }
    table("Error outside the training log after each step, case 2, first seed.", columns, rows)
}
