//! What every selector promises. A new selector is one line in `SELECTORS`.

use crate::planted;
use faer::Mat;
use proptest::prelude::*;
use torquewise_regression::select::criterion::Criterion;
use torquewise_regression::select::lasso::Lasso;
use torquewise_regression::select::stlsq::Stlsq;
use torquewise_regression::{KeptColumns, NormalEquations, SparseError};

struct Selector {
    name: &'static str,
    select: fn(&NormalEquations) -> Result<KeptColumns, SparseError>,
    /// Whether the unit of a column plays no part.
    unit_free: bool,
}

const SELECTORS: [Selector; 3] = [
    Selector { name: "lasso", select: |p| Lasso::default().select(p), unit_free: true },
    Selector { name: "stlsq", select: |p| Stlsq::default().select(p), unit_free: false },
    Selector { name: "criterion", select: |p| Criterion::default().select(p), unit_free: true },
];

/// What each of them selects, by its name.
fn selections(problem: &NormalEquations) -> [(&'static str, KeptColumns); 3] {
    SELECTORS.map(|selector| (selector.name, (selector.select)(problem).expect("sound settings")))
}

/// Refits through differently ordered factorisations of a well-conditioned matrix agree to some
/// hundred roundings.
const ROUNDING: f64 = 1e-12;

/// A selection is whole: ascending indices, zeros outside them, nothing infinite.
fn assert_whole(selection: &KeptColumns, columns: usize, name: &str) {
    assert_eq!(selection.coefficients.len(), columns, "{name}");
    assert!(selection.active.is_sorted(), "{name}");
    for (j, weight) in selection.coefficients.iter().enumerate() {
        assert!(weight.is_finite(), "{name}: column {j}");
        assert_eq!(*weight != 0.0, selection.active.contains(&j), "{name}: column {j}");
    }
}

fn assert_close(found: &[f64], expected: &[f64], tolerance: f64, name: &str) {
    for (j, (f, e)) in found.iter().zip(expected).enumerate() {
        assert!((f - e).abs() <= tolerance, "{name}: column {j} is {f}, expected {e}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn permuted_columns_give_permuted_weights(seed in 0..u64::MAX, shift in 1..15_usize) {
        let rows = planted::rows(seed, 200, 15, 4, 0.01);
        let origin = |j: usize| (j * 4 + shift) % 15;
        let permuted = Mat::from_fn(200, 15, |i, j| rows.features[(i, origin(j))]);
        let permuted = planted::problem(&permuted, &rows.response);
        let (before, after) = (selections(&rows.problem()), selections(&permuted));
        for ((name, before), (_, after)) in before.into_iter().zip(after) {
            let expected: Vec<f64> = (0..15).map(|j| before.coefficients[origin(j)]).collect();
            assert_whole(&after, 15, name);
            assert_close(&after.coefficients, &expected, ROUNDING, name);
        }
    }

    #[test]
    fn scaled_columns_give_inversely_scaled_weights(seed in 0..u64::MAX) {
        let rows = planted::rows(seed, 200, 15, 4, 0.01);
        let scale = |j: usize| 10.0_f64.powf(j as f64 / 2.0 - 4.0);
        let scaled = Mat::from_fn(200, 15, |i, j| rows.features[(i, j)] * scale(j));
        for Selector { name, select, .. } in SELECTORS.into_iter().filter(|s| s.unit_free) {
            let before = select(&rows.problem()).unwrap();
            let after = select(&planted::problem(&scaled, &rows.response)).unwrap();

            let unscaled: Vec<f64> = (0..15).map(|j| after.coefficients[j] * scale(j)).collect();
            assert_close(&unscaled, &before.coefficients, ROUNDING, name);
        }
    }

    #[test]
    fn a_truth_without_noise_is_found_exactly(seed in 0..u64::MAX) {
        let rows = planted::rows(seed, 300, 20, 4, 0.0);
        for (name, selection) in selections(&rows.problem()) {
            prop_assert_eq!(&selection.active, &rows.support(), "{}", name);
            assert_close(&selection.coefficients, &rows.truth, ROUNDING, name);
        }
    }

    #[test]
    fn a_truth_in_noise_is_found_within_the_noise(seed in 0..u64::MAX) {
        let rows = planted::rows(seed, 400, 20, 4, 0.1);
        for (name, selection) in selections(&rows.problem()) {
            // Deviation of a weight: 0.1/√3 of noise over √400 rows and a column of about 0.5.
            let deviation = 0.1 / 3.0_f64.sqrt() / 400.0_f64.sqrt() / 0.5;
            prop_assert!(rows.support().iter().all(|j| selection.active.contains(j)), "{}", name);
            assert_whole(&selection, 20, name);
            assert_close(&selection.coefficients, &rows.truth, 6.0 * deviation, name);
        }
    }

    #[test]
    fn a_column_of_zeros_is_never_selected(seed in 0..u64::MAX, empty in 0..10_usize) {
        let mut rows = planted::rows(seed, 100, 10, 3, 0.05);
        rows.features.col_mut(empty).fill(0.0);
        for (name, selection) in selections(&rows.problem()) {
            assert_whole(&selection, 10, name);
            prop_assert!(!selection.active.contains(&empty), "{}", name);
        }
    }

    #[test]
    fn of_equal_columns_one_is_selected(seed in 0..u64::MAX, factor in 0.1..10.0_f64) {
        let mut rows = planted::rows(seed, 100, 10, 2, 0.05);
        let first = rows.features.col(0).to_owned();
        rows.features.col_mut(7).copy_from(&first * faer::Scale(factor));
        for (name, selection) in selections(&rows.problem()) {
            assert_whole(&selection, 10, name);
            let kept = [0, 7].iter().filter(|j| selection.active.contains(j)).count();
            prop_assert_eq!(kept, 1, "{}: {:?}", name, selection.active);
        }
    }
}

#[test]
fn nothing_is_selected_for_a_response_of_zeros_or_without_columns() {
    let rows = planted::rows(1, 50, 6, 2, 0.0);
    let silent = planted::problem(&rows.features, &[0.0; 50]);
    let empty = NormalEquations::new(Mat::zeros(0, 0), &[], 1.0, 10.0).unwrap();
    for problem in [&silent, &empty] {
        for (name, selection) in selections(problem) {
            assert_whole(&selection, problem.n_columns(), name);
            assert!(selection.active.is_empty(), "{name}: {:?}", selection.active);
        }
    }
}

#[test]
fn an_overcorrected_gram_matrix_selects_finite_weights() {
    let rows = planted::rows(5, 100, 12, 3, 0.1);
    let exact = rows.problem();
    for share in [0.1, 0.5, 0.9, 1.1] {
        let kept = |i, j| if i == j { 1.0 - share } else { 1.0 };
        let gram = Mat::from_fn(12, 12, |i, j| exact.gram[(i, j)] * kept(i, j));
        let problem = NormalEquations::new(gram, exact.right(), exact.energy[0], exact.rows);
        for (name, selection) in selections(&problem.unwrap()) {
            assert_whole(&selection, 12, name);
        }
    }
}

#[test]
fn linear_algebra_is_not_cut_by_the_number_of_threads() {
    // A dependency that turns on the feature rayon of faer would change last digits.
    assert!(matches!(faer::get_global_parallelism(), faer::Par::Seq));
}

#[test]
fn the_criterion_finds_planted_terms_in_fewer_rows_than_columns_and_none_in_noise_alone() {
    let select = |rows: &planted::Rows| Criterion::default().select(&rows.problem()).unwrap();
    for seed in 0..10 {
        let rows = planted::rows(seed, 60, 150, 3, 0.01);
        let found = select(&rows);

        let kept = |column| found.active.contains(column);
        assert!(rows.support().iter().all(kept), "seed {seed}: {:?}", found.active);
        assert!(found.active.len() < 20, "seed {seed}: {:?}", found.active);
        let noise = planted::rows(seed, 300, 20, 0, 1.0);
        assert_eq!(select(&noise).active, [], "seed {seed}");
    }
}
