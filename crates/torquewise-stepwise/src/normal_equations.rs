//! Normal equations of all rows and their plain least squares: where the refit begins (E6).

use crate::factor::ActiveSet;
use crate::step::{residual_energy, response_index};
use faer::Mat;
use torquewise_regression::SparseError;
use torquewise_regression::gram::Gram;
use torquewise_regression::problem::Problem;

/// Where least squares leaves less than this part of the torque, squared, normal equations cannot
/// say how much less: they keep about 13 digits.
const EXPLAINED: f64 = 1e-10;

/// The normal equations of a group over all rows, its equations weighted and added up, with their
/// plain least-squares fit.
pub(crate) struct NormalEquations {
    /// \[Y τ\]ᵀ\[Y τ\], (p+1)×(p+1).
    pub(crate) gram: Mat<f64>,
    rows: f64,
    /// Least-squares weights, p.
    pub(crate) coefficients: Vec<f64>,
    /// Columns that depend on others.
    pub(crate) dependent: Vec<usize>,
    /// Whether the torque is explained but for rounding.
    pub(crate) is_explained: bool,
}

impl NormalEquations {
    /// - `grams`: of each equation over all rows
    pub(crate) fn new(kept: &ActiveSet, grams: &[Gram]) -> Result<Self, SparseError> {
        let p = kept.columns.len();
        let mut gram = Mat::<f64>::zeros(p + 1, p + 1);
        let mut rows = 0.0;
        for (&(equation, response), &weight) in kept.group.equations.iter().zip(&kept.weights) {
            let (own, part) = (response_index(grams.len(), response), &grams[equation]);
            for j in 0..p {
                for i in 0..p {
                    gram[(i, j)] += weight * part.gram[(i, j)];
                }
                gram[(j, p)] += weight * part.cross[(j, own)];
                gram[(p, j)] = gram[(j, p)];
            }
            gram[(p, p)] += weight * part.energy[own];
            rows += part.rows as f64;
        }
        let (coefficients, dependent) = solved(&gram, rows)?;
        let explained = |&(equation, response): &(usize, usize)| {
            let (own, part) = (response_index(grams.len(), response), &grams[equation]);
            residual_energy(part, own, &coefficients) <= EXPLAINED * part.energy[own]
        };
        let is_explained = kept.group.equations.iter().all(explained);
        Ok(Self { gram, rows, coefficients, dependent, is_explained })
    }

    /// A step of iterative refinement: least squares of what the coefficients leave of a sample,
    /// from \[Y e\]ᵀ\[Y e\] of all it stands for.
    pub(crate) fn refine(&mut self, left: &Mat<f64>) -> Result<(), SparseError> {
        self.gram = with_response(left, &self.coefficients);
        let (change, dependent) = solved(left, self.rows)?;
        self.coefficients.iter_mut().zip(change).for_each(|(weight, change)| *weight += change);
        self.dependent = dependent;
        Ok(())
    }
}

/// Least-squares weights and dependent columns of \[Y τ\]ᵀ\[Y τ\].
fn solved(gram: &Mat<f64>, rows: f64) -> Result<(Vec<f64>, Vec<usize>), SparseError> {
    let p = gram.ncols().saturating_sub(1);
    let right = (0..p).map(|j| gram[(j, p)]).collect();
    let plain = Mat::from_fn(p, p, |i, j| gram[(i, j)]);
    let problem = Problem::new(plain, right, gram[(p, p)], rows.max(1.0))?;
    let fit = problem.refit(&(0..p).collect::<Vec<_>>())?;
    Ok((fit.coefficients, fit.dependent))
}

/// Sums in \[Y e\], e = τ − Yβ, as they are in \[Y τ\].
pub(crate) fn with_response(sums: &Mat<f64>, coefficients: &[f64]) -> Mat<f64> {
    let p = coefficients.len();
    let mut change = Mat::<f64>::identity(p + 1, p + 1);
    coefficients.iter().enumerate().for_each(|(j, c)| change[(j, p)] = *c);
    change.transpose() * (sums * &change)
}
