//! Test vectors as CSV: states, and what the functions of a model return there.

use crate::{Quantity, Result};
use faer::Mat;
use faer::linalg::solvers::DenseSolveCore;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;
use std::fmt::Write;
use torquewise_model::{Model, Torque};

/// States and expected values, one row each, computed by the model and not by exported code.
///
/// Columns `q1…qn`, `dq1…`, `ddq1…`, then of each function in order `torque1…`, `gravity1…`,
/// `coriolis1…`, `inertia1_1, inertia1_2, …`, `friction1…`, `step1_1…`, `coriolis_matrix1_1…`,
/// `inverse_inertia1_1…`, and `forward_dynamics1…` of that torque; SI units, all digits.
/// States are drawn evenly from what the model was fitted on; where that is not known, from a turn,
/// ±1 rad/s and ±1 rad/s².
///
/// # Errors
/// `ExportError::Model` if the parts of the model do not fit together.
pub fn test_vectors(model: &Model, rows: usize, seed: u64) -> Result<String> {
    let (n, training) = (model.n_joints(), &model.training);
    let whole = Torque::new(model);
    let first = match model.stages.len() {
        0 => whole.clone(),
        _ => Torque::new(&model.after_step(1)?),
    };
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut text = header(n);
    for _ in 0..rows {
        let mut between = |[low, high]: [f64; 2]| low + (high - low) * rng.random::<f64>();
        let (mut q, mut dq, mut ddq) = (Vec::new(), Vec::new(), Vec::new());
        for joint in 0..n {
            let known = |peaks: &[f64]| peaks.get(joint).copied().unwrap_or(1.0);
            let (speed, acceleration) = (known(&training.dq_peak), known(&training.ddq_peak));
            q.push(between(training.q_range.get(joint).copied().unwrap_or([-PI, PI])));
            dq.push(between([-speed, speed]));
            ddq.push(between([-acceleration, acceleration]));
        }
        let listed = |matrix: Mat<f64>| -> Vec<f64> {
            (0..n * n).map(|place| matrix[(place / n, place % n)]).collect()
        };
        let matrix = whole.mass_matrix(&q)?;
        let tau = whole.at(&q, &dq, &ddq)?;
        let mut row = [q.clone(), dq.clone(), ddq.clone()].concat();
        row.extend(&tau);
        row.extend(whole.gravity(&q)?);
        row.extend(whole.coriolis(&q, &dq)?);
        row.extend(listed(matrix.clone()));
        row.extend(whole.friction(&q, &dq)?);
        row.extend(first.gravity(&q)?);
        row.extend(listed(whole.coriolis_matrix(&q, &dq)?));
        row.extend(listed(matrix.partial_piv_lu().inverse()));
        row.extend(whole.forward_dynamics([&q, &dq, &tau])?);
        let row: Vec<String> = row.iter().map(|x| format!("{x:?}")).collect();
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{}", row.join(","));
    }
    Ok(text)
}

fn header(n: usize) -> String {
    let mut names = Vec::new();
    for signal in ["q", "dq", "ddq"] {
        names.extend((1..=n).map(|joint| format!("{signal}{joint}")));
    }
    for quantity in Quantity::ALL {
        let name = quantity.name();
        match quantity {
            _ if quantity.is_matrix() => {
                let places = (0..n * n).map(|place| (place / n + 1, place % n + 1));
                names.extend(places.map(|(row, column)| format!("{name}{row}_{column}")));
            }
            Quantity::Step1 => names.extend((1..=n).map(|joint| format!("{name}_{joint}"))),
            _ => names.extend((1..=n).map(|joint| format!("{name}{joint}"))),
        }
    }
    names.join(",") + "\n"
}
