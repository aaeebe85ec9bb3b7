//! The LASSO path against its optimality conditions, computed on the rows themselves.

use crate::planted;
use proptest::prelude::*;
use torquewise_regression::select::lasso::{Lasso, lasso_path};
use torquewise_regression::{NormalEquations, SparseError};

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn every_point_meets_the_optimality_conditions(seed in 0..u64::MAX, few in any::<bool>()) {
        let rows = planted::rows(seed, if few { 25 } else { 150 }, 40, 5, 0.3);
        // Root mean square of each column.
        let size = |x: faer::ColRef<'_, f64>| (x.squared_norm_l2() / x.nrows() as f64).sqrt();
        let sizes: Vec<f64> = rows.features.col_iter().map(size).collect();

        let path = lasso_path(&rows.problem(), &Lasso::default()).unwrap();

        let hasty = Lasso { max_sweeps: 2, ..Lasso::default() };
        let hasty = lasso_path(&rows.problem(), &hasty).unwrap();
        prop_assert!(hasty.iter().all(|point| point.sweeps <= 2));
        prop_assert_eq!(path.len(), 100);
        let energy: f64 = rows.response.iter().map(|y| y * y).sum();
        let done = 1e-9 * energy / rows.response.len() as f64;
        prop_assert!(path.iter().all(|point| point.gap <= done), "{:?}", path);
        // A gap bounds what is missing, however large it is.
        for point in path.iter().chain(&hasty) {
            let fitted = planted::predict(&rows.features, &point.coefficients);
            let r: Vec<f64> = rows.response.iter().zip(fitted).map(|(y, f)| y - f).collect();
            for (j, &weight) in point.coefficients.iter().enumerate() {
                let column = rows.features.col_as_slice(j);
                let slope: f64 = column.iter().zip(&r).map(|(x, r)| x * r).sum::<f64>()
                    / (sizes[j] * r.len() as f64);
                let wanted = if weight == 0.0 {
                    slope.clamp(-point.lambda, point.lambda)
                } else {
                    point.lambda * weight.signum()
                };
                // Along one column of unit mean square, violation v, the objective can fall by
                // v²/2, or by v sⱼ|cⱼ|/2 if the weight reaches zero first: at most the gap.
                let gain = point.gap.max(1e-14);
                let to_zero = sizes[j] * weight.abs();
                let crossing = if weight == 0.0 { 0.0 } else { 2.0 * gain / to_zero };
                let slack = crossing.max((2.0 * gain).sqrt());
                prop_assert!((slope - wanted).abs() <= slack, "{} at {:?}", j, point.lambda);
            }
        }
    }
}

#[test]
fn a_path_ends_where_an_indefinite_gram_matrix_loses_its_meaning() {
    let gram = faer::mat![[1.0, 0.9, 0.0], [0.9, 0.1, 0.0], [0.0, 0.0, 1.0]];
    let problem = NormalEquations::new(gram, &[1.0, 1.0, 0.5], 2.0, 1.0).unwrap();

    let path = lasso_path(&problem, &Lasso::default()).unwrap();

    assert!(path.len() < 100, "{} points", path.len());
}

#[test]
fn the_threshold_of_the_paper_drops_small_weights() {
    let rows = planted::rows(6, 200, 10, 3, 0.1);
    let mut problem = rows.problem();
    // So many rows that the criterion keeps every term.
    problem.add(&problem.clone(), 1e6).unwrap();
    problem.rows = 2e8;

    let everything = Lasso::default().select(&problem).unwrap();
    let selection = Lasso { threshold: 0.1, ..Lasso::default() }.select(&problem).unwrap();

    assert_eq!(everything.active.len(), 10);
    assert_eq!(selection.active, rows.support());
}

#[test]
fn settings_out_of_range_are_refused() {
    let problem = planted::rows(1, 20, 3, 1, 0.0).problem();
    let cases = [
        ("ratio", Lasso { ratio: 1.0, ..Lasso::default() }),
        ("gap_tolerance", Lasso { gap_tolerance: f64::NAN, ..Lasso::default() }),
        ("threshold", Lasso { threshold: -0.1, ..Lasso::default() }),
    ];
    for (expected, lasso) in cases {
        let refused = lasso.select(&problem).unwrap_err();

        let is_told =
            matches!(refused, SparseError::Setting { setting, .. } if setting == expected);
        assert!(is_told, "{expected}: {refused}");
    }
}
