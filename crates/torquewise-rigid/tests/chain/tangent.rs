//! What a chain leaves of rows, and its slopes, against its torque at moved parameters.

use crate::twins::{arm, drawn, sines};
use faer::Mat;
use torquewise_rigid::search::all_parameters;
use torquewise_rigid::{Chain, ChainRows, Geometry};

const JOINTS: usize = 3;
const WEIGHTS: [f64; JOINTS] = [0.5, 2.0, 4.0];

/// Share of an equation: an odd joint counts less in every third row.
fn share(row: usize, joint: usize) -> f64 {
    if row.is_multiple_of(3) && joint == 1 { 0.1 } else { 1.0 }
}

/// Rows of another arm than the chain, with two columns beside it.
fn rows() -> ChainRows {
    let motion = sines(&arm(&drawn(JOINTS, 8)), 2.0, 5);
    let (m, tau) = (motion.n_rows(), motion.require_tau().unwrap());
    let drive = Mat::from_fn(m * JOINTS, 2, |place, k| {
        (0.01 * (place % m * (k + place / m + 1)) as f64).cos()
    });
    let rows = ChainRows::new([motion.q(), motion.dq(), motion.ddq(), tau], drive).unwrap();
    rows.with_shares(share)
}

fn other() -> Chain {
    Chain { drive: vec![0.7, -1.3], ..drawn(JOINTS, 4) }
}

/// Weighted torque of a chain, all rows of joint 1 first.
fn weighted(chain: &Chain, rows: &ChainRows) -> Vec<f64> {
    let m = rows.len();
    let torque = chain.torque(rows).into_iter().enumerate();
    torque.map(|(k, tau)| WEIGHTS[k / m] * share(k % m, k / m) * tau).collect()
}

/// The chain with one of its parameters moved, in the order of the columns of a tangent.
fn moved(chain: &Chain, parameter: usize, step: f64) -> Chain {
    let mut moved = chain.clone();
    let (masses, drive) = (moved.inertial.len(), moved.drive.len());
    if parameter < masses {
        moved.inertial[parameter] += step;
    } else if parameter < masses + drive {
        moved.drive[parameter - masses] += step;
    } else {
        let mut parameters = moved.geometry.parameters().to_vec();
        parameters[parameter - masses - drive] += step;
        moved.geometry = Geometry::new(&parameters).unwrap();
    }
    moved
}

#[test]
fn a_residual_is_measured_less_predicted_and_columns_are_the_slopes_of_the_torque() {
    let (rows, chain) = (rows(), other());

    let tangent = chain.tangent(&rows, &WEIGHTS, &all_parameters(JOINTS)).unwrap();

    let m = rows.len();
    let predicted = weighted(&chain, &rows);
    let largest = predicted.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    for (k, residual) in tangent.residual.iter().enumerate() {
        let weight = WEIGHTS[k / m] * share(k % m, k / m);
        let expected = weight * rows.torque_of(k / m)[k % m] - predicted[k];
        assert!((tangent.weights[k] - weight).abs() < 1e-15);
        assert!((residual - expected).abs() < 1e-12 * largest, "{k}: {residual} {expected}");
    }
    assert_eq!(tangent.columns.ncols(), 10 * JOINTS + 2 + 2 + 4 * (JOINTS - 1));
    let step = 1e-5;
    for parameter in 0..tangent.columns.ncols() {
        let ahead = weighted(&moved(&chain, parameter, step), &rows);
        let behind = weighted(&moved(&chain, parameter, -step), &rows);
        let column = tangent.columns.col_as_slice(parameter);
        let largest = column.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
        for (k, (a, b)) in ahead.iter().zip(&behind).enumerate() {
            let slope = (a - b) / (2.0 * step);
            // Both are central differences: rounding over the step, and the step squared.
            assert!((slope - column[k]).abs() < 1e-6 * largest, "{parameter} {k}: {slope}");
        }
    }
}

#[test]
fn rows_of_another_arm_are_refused() {
    let chain = Chain { drive: vec![], ..other() };

    assert!(chain.tangent(&rows(), &WEIGHTS, &[]).is_err());
    assert!(other().tangent(&rows(), &WEIGHTS[1..], &[]).is_err());
}
