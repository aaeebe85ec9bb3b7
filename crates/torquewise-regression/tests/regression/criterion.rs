//! The information criterion against planted truths.

use crate::planted;
use torquewise_regression::normal_equations::Selection;
use torquewise_regression::select::criterion::Criterion;

fn select(rows: &planted::Rows) -> Selection {
    Criterion::default().select(&rows.problem()).expect("γ is in range")
}

#[test]
fn the_planted_terms_are_found_among_correlated_columns() {
    for seed in 0..20 {
        let rows = planted::rows(seed, 400, 30, 4, 0.1);
        let found = select(&rows);

        assert_eq!(found.active, rows.support(), "seed {seed}");
        for (c, truth) in found.coefficients.iter().zip(&rows.truth) {
            // A standard error is 0.06 / √(400 / 3), so five are below 0.03.
            assert!((c - truth).abs() < 0.03, "seed {seed}: {c} {truth}");
        }
    }
}

#[test]
fn more_columns_than_rows_still_give_the_planted_terms() {
    for seed in 0..10 {
        let rows = planted::rows(seed, 60, 150, 3, 0.01);
        let found = select(&rows);

        let kept = |column| found.active.contains(column);
        assert!(rows.support().iter().all(kept), "seed {seed}: {:?}", found.active);
        assert!(found.active.len() < 20, "seed {seed}: {:?}", found.active);
    }
}

#[test]
fn a_response_of_noise_alone_keeps_nothing() {
    for seed in 0..10 {
        let rows = planted::rows(seed, 300, 20, 0, 1.0);

        assert_eq!(select(&rows).active, [], "seed {seed}");
    }
}
