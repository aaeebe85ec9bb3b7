//! Elimination by significance against classical least squares and planted truths.

use crate::planted;
use faer::Mat;
use faer::linalg::solvers::DenseSolveCore;
use torquewise_regression::elimination::{Equations, Estimate};

/// Noise uniform within ±0.1.
const NOISE: f64 = 0.1;
const VARIANCE: f64 = NOISE * NOISE / 3.0;
/// t² of the extended criterion for 400 rows and 30 columns.
const THRESHOLD: f64 = 12.8;

/// White noise in the response alone: Ω = σ² XᵀX.
fn equations(rows: &planted::Rows) -> Equations {
    let information = rows.features.transpose() * &rows.features;
    let spread = &information * faer::Scale(VARIANCE);
    let problem = rows.problem();
    let floor = vec![0.0; problem.n_columns()];
    Equations { right: problem.right().to_vec(), information, spread, floor }
}

fn eliminate(equations: &Equations, threshold: f64) -> Estimate {
    let all: Vec<usize> = (0..equations.right.len()).collect();
    equations.eliminate(&all, threshold).expect("positive definite information")
}

#[test]
fn many_columns_leave_several_at_a_time_to_the_same_end() {
    let rows = planted::rows(3, 1_000, 200, 6, NOISE);

    let found = eliminate(&equations(&rows), 2.0 * THRESHOLD);

    assert_eq!(found.active, rows.support());
}

#[test]
fn under_white_noise_the_sandwich_is_the_classical_covariance() {
    let rows = planted::rows(5, 300, 8, 3, NOISE);
    let equations = equations(&rows);

    let found = eliminate(&equations, 0.0);

    let inverse = equations.information.partial_piv_lu().inverse();
    assert_eq!(found.active.len(), 8);
    for (j, std_error) in found.std_errors.iter().enumerate() {
        let classical = (VARIANCE * inverse[(j, j)]).sqrt();
        // Columns are correlated by 0.3: the condition is below ten.
        assert!((std_error / classical - 1.0).abs() < 1e-12, "{std_error} {classical}");
        let solved: f64 = (0..8).map(|i| inverse[(j, i)] * equations.right[i]).sum();
        assert!((found.coefficients[j] - solved).abs() < 1e-12);
    }
}

#[test]
fn a_coefficient_below_its_floor_is_dropped_however_significant() {
    let rows = planted::rows(8, 400, 30, 4, NOISE);
    let mut equations = equations(&rows);
    let support = rows.support();
    equations.floor[support[1]] = 3.0;
    equations.floor[support[2]] = 1e-3;

    let found = eliminate(&equations, THRESHOLD);

    assert!(!found.active.contains(&support[1]), "below its floor of 3");
    for place in [0, 2, 3] {
        assert!(found.active.contains(&support[place]), "above its floor");
    }
}

#[test]
fn units_of_the_columns_play_no_part() {
    let rows = planted::rows(9, 400, 12, 3, NOISE);
    let plain = equations(&rows);
    let units = [1e6, 1e-6, 1.0, 1e3];
    let unit = |j: usize| units[j % units.len()];
    let scaled = |x: &Mat<f64>| Mat::from_fn(12, 12, |i, j| x[(i, j)] * unit(i) * unit(j));
    let [information, spread] = [&plain.information, &plain.spread].map(scaled);
    let right = plain.right.iter().enumerate().map(|(j, x)| x * unit(j)).collect();
    let other = Equations { information, right, spread, floor: plain.floor.clone() };

    let (found, expected) = (eliminate(&other, THRESHOLD), eliminate(&plain, THRESHOLD));

    assert_eq!(found.active, expected.active);
    for (place, &column) in found.active.iter().enumerate() {
        let ratio = found.coefficients[place] * unit(column) / expected.coefficients[place];
        assert!((ratio - 1.0).abs() < 1e-10, "column {column}: {ratio}");
    }
}

fn small(information: [[f64; 2]; 2]) -> Equations {
    let (information, spread) = (Mat::from_fn(2, 2, |i, j| information[i][j]), Mat::identity(2, 2));
    Equations { information, right: vec![1.0; 2], spread, floor: vec![0.0; 2] }
}

#[test]
fn an_indefinite_matrix_has_no_estimate_and_a_column_without_information_is_left_out() {
    assert_eq!(small([[1.0, 2.0], [2.0, 1.0]]).eliminate(&[0, 1], 1.0), None);
    let found = eliminate(&small([[4.0, 0.0], [0.0, 0.0]]), 0.0);

    assert_eq!(found.active, [0]);
    assert_eq!(found.coefficients, [0.25]);
}
