//! Positive definite matrices of any scale, factored.

use crate::{ChainError, Result};
use faer::linalg::solvers::{Llt, Solve};
use faer::{ColRef, Mat, Side};

/// A positive definite matrix, of which the lower triangle is read, scaled to a unit diagonal and
/// factored.
#[derive(Clone, Debug)]
pub struct Factored {
    scales: Vec<f64>,
    factor: Llt<f64>,
}

/// Jitters of the diagonal that are tried where rounding makes a matrix indefinite.
const JITTERS: [f64; 5] = [0.0, 1e-14, 1e-12, 1e-10, 1e-8];

impl Factored {
    /// # Errors
    /// [`ChainError::Singular`] if it is not positive definite.
    pub fn new(mut matrix: Mat<f64>) -> Result<Self> {
        let p = matrix.ncols();
        let scale = |j| if matrix[(j, j)] > 0.0 { 1.0 / matrix[(j, j)].sqrt() } else { 1.0 };
        let scales: Vec<f64> = (0..p).map(scale).collect();
        for j in 0..p {
            let below = matrix.col_as_slice_mut(j).iter_mut().zip(&scales).skip(j);
            below.for_each(|(x, own)| *x *= own * scales[j]);
        }
        let mut before = 0.0;
        for jitter in JITTERS {
            (0..p).for_each(|j| matrix[(j, j)] += jitter - before);
            before = jitter;
            if let Ok(factor) = matrix.llt(Side::Lower) {
                return Ok(Self { scales, factor });
            }
        }
        Err(ChainError::Singular)
    }

    /// A⁻¹ b.
    pub fn solve(&self, right: &[f64]) -> Vec<f64> {
        let scaled: Vec<f64> = right.iter().zip(&self.scales).map(|(b, s)| b * s).collect();
        let solution = self.factor.solve(ColRef::from_slice(&scaled));
        solution.iter().zip(&self.scales).map(|(x, s)| x * s).collect()
    }

    /// A⁻¹ B A⁻¹ of a symmetric B: the covariance of a solution whose scores scatter by B.
    pub fn sandwiched(&self, scatter: &Mat<f64>) -> Mat<f64> {
        let half = self.solve_matrix(scatter);
        self.solve_matrix(&half.transpose().to_owned())
    }

    /// A⁻¹ B.
    pub fn solve_matrix(&self, right: &Mat<f64>) -> Mat<f64> {
        let (p, n) = right.shape();
        let scaled = Mat::from_fn(p, n, |i, j| right[(i, j)] * self.scales[i]);
        let solution = self.factor.solve(&scaled);
        Mat::from_fn(p, n, |i, j| solution[(i, j)] * self.scales[i])
    }
}
