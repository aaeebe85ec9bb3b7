//! Kept terms, a first fit → residuals and the spread of its scores.

use crate::factor::Fit;
use faer::Mat;
use torquewise_regression::SparseError;
use torquewise_regression::accumulate::Accumulate;
use torquewise_regression::products::add_gram;
use torquewise_regression::samples::Samples;

/// Residuals of a fit, and the spread of its scores: rows of all equations at one instant share the
/// noise of that instant, so they count as one.
pub(crate) struct ScoreSum<'a> {
    fit: &'a Fit<'a>,
    coefficients: &'a [f64],
    /// Squared residuals of each equation.
    pub(crate) squares: Vec<f64>,
    /// Scores Σ w y r, p.
    pub(crate) sum: Vec<f64>,
    /// Their products, p×p, lower triangle.
    pub(crate) spread: Mat<f64>,
    pub(crate) rows: usize,
}

impl<'a> ScoreSum<'a> {
    pub(crate) fn new(fit: &'a Fit<'a>, coefficients: &'a [f64]) -> Self {
        let p = fit.n_columns();
        Self {
            fit,
            coefficients,
            squares: vec![0.0; fit.kept.group.equations.len()],
            sum: vec![0.0; p],
            spread: Mat::zeros(p, p),
            rows: 0,
        }
    }
}

impl Accumulate for ScoreSum<'_> {
    fn add(&mut self, samples: &Samples) -> Result<(), SparseError> {
        let columns = self.fit.evaluator.columns(samples)?;
        let p = self.fit.n_columns();
        let mut scores = Mat::<f64>::zeros(samples.n_rows(), p);
        for ((y, tau, weight), squares) in
            self.fit.equations(&columns, samples).zip(&mut self.squares)
        {
            let mut residual = tau.to_vec();
            for (j, &coefficient) in self.coefficients.iter().enumerate() {
                for (r, y) in residual.iter_mut().zip(y.col_as_slice(j)) {
                    *r -= coefficient * y;
                }
            }
            *squares += residual.iter().map(|r| r * r).sum::<f64>();
            for j in 0..p {
                let terms = y.col_as_slice(j).iter().zip(&residual);
                for (score, (y, r)) in scores.col_as_slice_mut(j).iter_mut().zip(terms) {
                    *score += weight * y * r;
                }
            }
        }
        for (sum, column) in self.sum.iter_mut().zip(scores.col_iter()) {
            *sum += column.iter().sum::<f64>();
        }
        add_gram(&mut self.spread, scores.as_ref(), 1.0);
        self.rows += samples.n_rows();
        Ok(())
    }

    fn merge(&mut self, other: Self) -> Result<(), SparseError> {
        self.squares.iter_mut().zip(&other.squares).for_each(|(a, b)| *a += b);
        self.sum.iter_mut().zip(&other.sum).for_each(|(a, b)| *a += b);
        self.spread += &other.spread;
        self.rows += other.rows;
        Ok(())
    }
}
