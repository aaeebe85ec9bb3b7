//! Normal equations against sums over the rows they stand for.

use crate::planted;
use faer::Mat;
use proptest::prelude::*;
use torquewise_regression::{NormalEquations, SparseError};

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn a_refit_leaves_a_residual_orthogonal_to_its_columns(
        seed in 0..u64::MAX,
        active in prop::collection::btree_set(0..12_usize, 0..12),
    ) {
        let rows = planted::rows(seed, 60, 12, 4, 0.2);
        let active: Vec<usize> = active.into_iter().collect();

        let refit = rows.problem().refit(&active).unwrap();

        prop_assert_eq!(&refit.active, &active);
        let fitted = planted::predict(&rows.features, &refit.coefficients);
        let residual: Vec<f64> = rows.response.iter().zip(fitted).map(|(y, f)| y - f).collect();
        for j in active {
            let column = rows.features.col_as_slice(j);
            let slope: f64 = column.iter().zip(&residual).map(|(x, r)| x * r).sum();
            prop_assert!(slope.abs() < 1e-11, "column {}: {}", j, slope);
        }
        let expected: f64 = residual.iter().map(|r| r * r).sum();
        prop_assert!((refit.residual_energy - expected).abs() <= 1e-11 * expected.max(1.0));
    }

    #[test]
    fn responses_refitted_together_get_the_weights_of_each_alone(seed in 0..u64::MAX) {
        let one = planted::rows(seed, 60, 8, 3, 0.2);
        let mut other = planted::rows(seed, 60, 8, 3, 0.2);
        other.response.reverse();
        let alone = [one.problem(), other.problem()];
        let cross = Mat::from_fn(8, 2, |j, response| alone[response].right()[j]);
        let energy = alone.iter().map(|own| own.energy[0]).collect();

        let both = NormalEquations { cross, energy, ..alone[0].clone() };
        let found = both.weights();

        for (response, alone) in alone.iter().enumerate() {
            let alone = alone.refit(&[0, 1, 2, 3, 4, 5, 6, 7]).unwrap().coefficients;
            // The same operations on the same numbers, in another order at most.
            for (found, alone) in found.col_as_slice(response).iter().zip(alone) {
                prop_assert!((found - alone).abs() < 1e-13, "{} {}", found, alone);
            }
        }
    }

    #[test]
    fn a_sum_of_other_columns_is_dropped_and_the_fit_stays(seed in 0..u64::MAX) {
        let mut rows = planted::rows(seed, 60, 8, 3, 0.2);
        let sum = rows.features.col(1) + rows.features.col(2) * faer::Scale(3.0);
        rows.features.col_mut(6).copy_from(&sum);
        let with: Vec<usize> = (0..8).collect();
        let without: Vec<usize> = (0..8).filter(|&j| j != 6).collect();

        let refit = rows.problem().refit(&with).unwrap();
        let reduced = rows.problem().refit(&without).unwrap();

        prop_assert_eq!(refit.dependent.len(), 1);
        prop_assert!([1, 2, 6].contains(&refit.dependent[0]), "{:?}", refit.dependent);
        let difference = (refit.residual_energy - reduced.residual_energy).abs();
        prop_assert!(difference <= 1e-10 * reduced.residual_energy);
    }
}

#[test]
fn only_the_lower_triangle_is_read() {
    let rows = planted::rows(1, 40, 70, 3, 0.1);
    let whole = rows.problem();
    let half = Mat::from_fn(70, 70, |i, j| if i < j { f64::NAN } else { whole.gram[(i, j)] });

    let problem = NormalEquations::new(half, whole.right(), whole.energy[0], 40.0).unwrap();

    assert_eq!(problem.gram, whole.gram);
}

#[test]
fn joined_sums_hold_the_same() {
    let whole = planted::rows(3, 40, 5, 2, 0.1).problem();

    let joined = whole.joined();
    let again = NormalEquations::of_joined(&joined, 40.0).unwrap();

    assert_eq!((joined.ncols(), joined[(5, 5)].to_bits()), (6, whole.energy[0].to_bits()));
    assert_eq!((again.gram, again.cross), (whole.gram, whole.cross));
}

#[test]
fn what_weights_leave_is_what_the_other_columns_explain() {
    let rows = planted::rows(4, 60, 6, 3, 0.2);
    let known = [0.5, -1.0, 0.0, 0.25, 0.0, 0.0];
    let fitted = planted::predict(&rows.features, &known);
    let left: Vec<f64> = rows.response.iter().zip(fitted).map(|(y, f)| y - f).collect();

    let found = rows.problem().left_by(&known, 0, &[2, 4]);

    let expected = planted::problem(&rows.features, &left).restricted(&[2, 4]);
    let difference = (&found.cross - &expected.cross).norm_max();
    assert!(difference < 1e-12, "some roundings of sums over 60 rows: {difference:e}");
    assert!((found.energy[0] - expected.energy[0]).abs() < 1e-11);
}

#[test]
fn malformed_equations_are_refused() {
    let one = || Mat::from_fn(2, 2, |i, j| f64::from(i == j));
    let broken = Mat::from_fn(2, 2, |i, _| if i == 1 { f64::INFINITY } else { 1.0 });

    let lopsided = NormalEquations::new(Mat::zeros(2, 3), &[0.0; 2], 1.0, 5.0);
    let long = NormalEquations::new(one(), &[0.0; 3], 1.0, 5.0);
    let infinite = NormalEquations::new(broken, &[0.0; 2], 1.0, 5.0);
    let not_a_number = NormalEquations::new(one(), &[0.0, f64::NAN], 1.0, 5.0);
    let negative = NormalEquations::new(one(), &[0.0; 2], -1.0, 5.0);
    let rowless = NormalEquations::new(one(), &[0.0; 2], 1.0, 0.0);
    let beyond = NormalEquations::new(one(), &[0.0; 2], 1.0, 5.0).unwrap().refit(&[0, 2]);

    assert!(matches!(lopsided, Err(SparseError::Shape { found: 3, expected: 2, .. })));
    assert!(matches!(long, Err(SparseError::Shape { found: 2, expected: 3, .. })));
    assert!(matches!(infinite, Err(SparseError::NotFinite { entry: 2, .. })));
    assert!(matches!(not_a_number, Err(SparseError::NotFinite { entry: 1, .. })));
    assert!(matches!(negative, Err(SparseError::Setting { found: -1.0, .. })));
    assert!(matches!(rowless, Err(SparseError::Setting { found: 0.0, .. })));
    assert_eq!(beyond, Err(SparseError::Column { column: 2, columns: 2 }));
}
