//! What exported functions must return, by the model itself, and how far they are off.

use crate::models::State;
use crate::run::{OBSERVED, RESET};
use faer::Mat;
use faer::linalg::solvers::DenseSolveCore;
use std::fmt::Write;
use torquewise_model::momentum_observer::MomentumObserver;
use torquewise_model::{Model, Torque};

/// Values of all functions at all states, in their order; forward dynamics of the numbers of q̈ as
/// torques.
pub(crate) fn expected(model: &Model, states: &[State]) -> Vec<Vec<f64>> {
    let whole = Torque::new(model);
    let first = model.after_step(1).unwrap_or_else(|_| model.clone());
    let first = Torque::new(&first);
    let values = |[q, dq, ddq]: &State| {
        let n = q.len();
        let listed = |matrix: &Mat<f64>| -> Vec<f64> {
            (0..n * n).map(|place| matrix[(place / n, place % n)]).collect()
        };
        let matrix = whole.mass_matrix(q).unwrap();
        let mut row = whole.at(q, dq, ddq).unwrap();
        row.extend(whole.gravity(q).unwrap());
        row.extend(whole.coriolis(q, dq).unwrap());
        row.extend(listed(&matrix));
        row.extend(whole.friction(q, dq).unwrap());
        row.extend(first.gravity(q).unwrap());
        row.extend(listed(&whole.coriolis_matrix(q, dq).unwrap()));
        // Exported code solves without pivots, which is for matrices that are positive definite.
        let solvable = model.chain.is_some();
        let solved =
            |values: Vec<f64>| values.into_iter().map(move |x| if solvable { x } else { f64::NAN });
        row.extend(solved(listed(&matrix.partial_piv_lu().inverse())));
        row.extend(solved(whole.forward_dynamics([q, dq, ddq]).unwrap()));
        row
    };
    states.iter().map(values).collect()
}

/// Torque, friction, external torque where the motors give the numbers of q̈, and q̈ of the torque,
/// along a path that begins anew every [`RESET`] samples.
pub(crate) fn expected_along(model: &Model, way: &[State]) -> Vec<Vec<f64>> {
    let torque = Torque::new(model);
    let mut path = torque.path();
    let [gain, dt] = OBSERVED;
    let mut observer = MomentumObserver::new(model, gain);
    let values = |(row, [q, dq, ddq]): (usize, &State)| {
        if row % RESET == 0 {
            path.reset();
            observer.reset();
        }
        path.step(q);
        let tau = torque.after(&path, dq, ddq).unwrap();
        let whole = torque.at(path.q(), dq, ddq).unwrap();
        let friction = torque.friction(path.q(), dq).unwrap();
        // Friction alone changes with the path.
        let after = (0..q.len()).map(|joint| tau[joint] - whole[joint] + friction[joint]);
        let external = observer.step(dt, [q, dq, ddq]).unwrap().to_vec();
        let ddq = ddq.iter().map(|x| if model.chain.is_some() { *x } else { f64::NAN });
        [tau.clone(), after.collect(), external, ddq.collect()].concat()
    };
    way.iter().enumerate().map(values).collect()
}

/// Part of the largest output that an output is rounding below.
const ROUNDING: f64 = 1e-3;

/// Largest difference of an output from what is expected, beside the value, or beside the output's
/// root mean square where it passes through zero; an output that is always zero is rounded as the
/// others are, one of which nothing is expected is left out.
pub(crate) fn worst(found: &[Vec<f64>], expected: &[Vec<f64>]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let (m, outputs) = (expected.len(), expected[0].len());
    let mut worst: f64 = 0.0;
    let most = expected
        .iter()
        .flatten()
        .filter(|x| !x.is_nan())
        .fold(0.0_f64, |most, x| most.max(x.abs()));
    for output in 0..outputs {
        if expected.iter().all(|row| row[output].is_nan()) {
            continue;
        }
        let square: f64 = expected.iter().map(|row| row[output].powi(2)).sum();
        let usual = (square / m as f64).sqrt();
        for (found, expected) in found.iter().zip(expected) {
            assert_eq!(found.len(), outputs);
            let scale = expected[output].abs().max(usual).max(ROUNDING * most);
            let error = (found[output] - expected[output]).abs() / scale;
            assert!(error.is_finite(), "output {output}: {}", found[output]);
            worst = worst.max(error);
        }
    }
    worst
}

/// States as lines of numbers, q, q̇, q̈.
pub(crate) fn lines(states: &[State]) -> String {
    let mut text = String::new();
    for state in states {
        for x in state.iter().flatten() {
            write!(text, "{x:?} ").unwrap();
        }
        text.push('\n');
    }
    text
}

pub(crate) fn parsed(text: &str) -> Vec<Vec<f64>> {
    let line = |line: &str| line.split_whitespace().map(|x| x.parse().unwrap()).collect();
    text.lines().map(line).collect()
}
