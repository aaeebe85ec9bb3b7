//! Logs that cannot be learned from are errors: no panic, no NaN.

use crate::twins::{drawn, rows, sines};
use faer::{Mat, MatRef};
use miette::Diagnostic;
use torquewise_rigid::search::{UNWATCHED, all_parameters};
use torquewise_rigid::{ChainError, ChainRows, Search, refine, search};
use torquewise_sim::Arm;

fn plan() -> Search {
    Search { starts: 2, rounds: 4, weighings: 1, ..Search::default() }
}

/// Rows of which every signal is `of(row, joint)`.
fn made(m: usize, n: usize, of: impl Fn(usize, usize) -> f64) -> ChainRows {
    let x = Mat::from_fn(m, n, of);
    ChainRows::new([x.as_ref(); 4], Mat::zeros(m * n, 0)).unwrap()
}

#[test]
fn too_few_rows_are_named() {
    for m in [0, 1, 29] {
        let error = search(&made(m, 3, |row, _| row as f64), &plan(), UNWATCHED).unwrap_err();

        let known = ChainError::TooFewRows { rows: m, joints: 3, needed: 30 };
        assert_eq!(error.to_string(), known.to_string());
        assert!(error.help().is_some_and(|help| help.to_string() == "record a longer motion"));
    }
}

#[test]
fn signals_of_different_shapes_are_refused() {
    let (right, wrong) = (Mat::<f64>::zeros(5, 2), Mat::<f64>::zeros(4, 2));
    for (place, name) in [(1, "dq"), (2, "ddq"), (3, "tau")] {
        let mut signals: [MatRef<'_, f64>; 4] = [right.as_ref(); 4];
        signals[place] = wrong.as_ref();

        let error = ChainRows::new(signals, Mat::zeros(10, 0)).unwrap_err();

        assert_eq!(error.to_string(), format!("{name} has 8 entries where 10 were expected"));
    }
}

#[test]
fn columns_beside_the_chain_of_other_shapes_no_joint_and_too_many_are_refused() {
    let x = Mat::<f64>::zeros(5, 2);
    for rows in [0, 5, 9, 11] {
        let error = ChainRows::new([x.as_ref(); 4], Mat::zeros(rows, 1)).unwrap_err();

        let known = format!("a column of extras has {rows} entries where 10 were expected");
        assert_eq!(error.to_string(), known);
    }
    for n in [0, 17] {
        let x = Mat::<f64>::zeros(5, n);

        let error = ChainRows::new([x.as_ref(); 4], Mat::zeros(5 * n, 0)).unwrap_err();

        assert!(matches!(error, ChainError::TooManyJoints { joints, .. } if joints == n));
    }
}

#[test]
fn values_that_are_no_numbers_and_a_search_of_nothing_find_no_chain() {
    for (odd, plan) in [
        (Some(f64::NAN), plan()),
        (Some(f64::INFINITY), plan()),
        (Some(1e300), plan()),
        (None, Search { starts: 0, ..plan() }),
        (None, Search { weighings: 0, ..plan() }),
        (None, Search { ridge: f64::NAN, ..plan() }),
    ] {
        let of = |row: usize, joint: usize| {
            odd.filter(|_| row == 7).unwrap_or((row as f64 * 0.1 + joint as f64).sin())
        };

        let result = search(&made(60, 2, of), &plan, UNWATCHED);

        assert!(matches!(result, Err(ChainError::Singular)), "{odd:?} {plan:?}: {result:?}");
    }
}

#[test]
fn a_start_of_another_arm_and_parameters_that_no_geometry_has_are_refused() {
    let cases = [("planar-2", all_parameters(2), "geometry"), ("puma560-3", vec![10], "free")];
    for (arm, free, shape) in cases {
        let rows = rows(&sines(&Arm::builtin(arm).unwrap(), 4.0, 1));

        let result = refine(&rows, &drawn(3, 1), &free, &plan(), UNWATCHED);

        let is_told = matches!(result, Err(ChainError::Shape { what, .. }) if what == shape);
        assert!(is_told, "{result:?}");
    }
}
