//! From seed to rows whose sparse truth is known.

use faer::Mat;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use torquewise_regression::NormalEquations;

/// Rows y = X c + noise with few entries of c different from zero.
pub(crate) struct Rows {
    pub(crate) features: Mat<f64>,
    pub(crate) response: Vec<f64>,
    pub(crate) truth: Vec<f64>,
}

/// `columns` correlated columns, of which `terms` carry a weight of size 0.5 to 2.
pub(crate) fn rows(seed: u64, rows: usize, columns: usize, terms: usize, noise: f64) -> Rows {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let independent = Mat::from_fn(rows, columns + 1, |_, _| rng.random_range(-1.0..1.0_f64));
    let features =
        Mat::from_fn(rows, columns, |i, j| independent[(i, j)] + 0.3 * independent[(i, j + 1)]);
    let mut truth = vec![0.0; columns];
    for k in 0..terms {
        let sign = if rng.random::<bool>() { 1.0 } else { -1.0 };
        truth[k * columns / terms] = sign * rng.random_range(0.5..2.0);
    }
    let noisy = |y| y + noise * rng.random_range(-1.0..1.0_f64);
    let response = predict(&features, &truth).into_iter().map(noisy).collect();
    Rows { features, response, truth }
}

/// X c.
pub(crate) fn predict(features: &Mat<f64>, coefficients: &[f64]) -> Vec<f64> {
    let row = |i| (0..features.ncols()).map(|j| features[(i, j)] * coefficients[j]).sum();
    (0..features.nrows()).map(row).collect()
}

/// Normal equations, summed plainly.
pub(crate) fn problem(features: &Mat<f64>, response: &[f64]) -> NormalEquations {
    let y = Mat::from_fn(response.len(), 1, |i, _| response[i]);
    let cross = features.transpose() * &y;
    let energy = response.iter().map(|y| y * y).sum();
    let (gram, rows) = (features.transpose() * features, features.nrows() as f64);
    let problem = NormalEquations::new(gram, cross.col_as_slice(0), energy, rows);
    problem.expect("finite sums of matching shape")
}

impl Rows {
    pub(crate) fn problem(&self) -> NormalEquations {
        problem(&self.features, &self.response)
    }

    pub(crate) fn support(&self) -> Vec<usize> {
        (0..self.truth.len()).filter(|&j| self.truth[j] != 0.0).collect()
    }
}
