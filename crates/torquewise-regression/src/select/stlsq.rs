//! Sequentially thresholded least squares, the selector of SINDy.

use crate::error::SparseError;
use crate::problem::{Problem, Ridge, Selection, require};
use faer::MatRef;
use rayon::prelude::*;

/// Fit, drop the small weights, fit again, until none is small; then least squares on the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stlsq {
    /// Weights not above this are dropped; zero or more, in the unit of the weight, or of the
    /// response if `standardise` is set.
    pub threshold: f64,
    /// Ridge ρ ≥ 0 of the fits that choose: ½/m‖y − X c‖² + ½ρ Σ (sⱼ cⱼ)², sⱼ being the root mean
    /// square of column j. The last fit has none.
    pub ridge: f64,
    /// Ridge α ≥ 0 of the same fits on the weights themselves: ‖y − X c‖² + α Σ cⱼ², as PySINDy has
    /// it.
    pub plain_ridge: f64,
    /// Bound on the number of fits that choose.
    pub max_iterations: usize,
    /// Compare what a term contributes, sⱼ|cⱼ|, with the threshold, not |cⱼ|.
    pub standardise: bool,
}

impl Default for Stlsq {
    /// The paper's threshold of 0.1 on the weights themselves, no ridge, at most 20 fits.
    fn default() -> Self {
        let (threshold, max_iterations) = (0.1, 20);
        Self { threshold, ridge: 0.0, plain_ridge: 0.0, max_iterations, standardise: false }
    }
}

impl Stlsq {
    /// Columns that survive the threshold, with their least-squares weights.
    ///
    /// A column dropped once does not return, whether it was small or said what others say.
    ///
    /// # Errors
    /// [`SparseError::Setting`] if threshold or ridge are negative or not finite.
    pub fn select(&self, problem: &Problem) -> Result<Selection, SparseError> {
        let cross = MatRef::from_column_major_slice(problem.cross(), problem.n_columns(), 1);
        let mut selected = self.select_each(problem, cross)?.into_iter();
        selected.next().ok_or(SparseError::Shape { what: "responses", found: 0, expected: 1 })
    }

    /// The same for several responses of the same rows: one factorisation serves their first fits.
    ///
    /// - `cross`: Xᵀ of the responses, p×r
    ///
    /// # Errors
    /// As [`Self::select`], and [`SparseError::Shape`] if `cross` does not have p rows.
    pub fn select_each(
        &self,
        problem: &Problem,
        cross: MatRef<'_, f64>,
    ) -> Result<Vec<Selection>, SparseError> {
        require("threshold", self.threshold, self.threshold >= 0.0, "zero or more")?;
        require("ridge", self.ridge, self.ridge >= 0.0, "zero or more")?;
        require("plain_ridge", self.plain_ridge, self.plain_ridge >= 0.0, "zero or more")?;
        let (found, expected) = (cross.nrows(), problem.n_columns());
        if found != expected {
            return Err(SparseError::Shape { what: "the cross products", found, expected });
        }
        let usable: Vec<usize> = (0..expected).filter(|&j| problem.column_scale(j) > 0.0).collect();
        if self.max_iterations == 0 {
            let refit = |r| Self::finish(problem, cross.subcols(r, 1), &usable, Vec::new());
            return (0..cross.ncols()).map(refit).collect();
        }
        let first = problem.solve(&usable, cross, self.added())?;
        (0..cross.ncols())
            .into_par_iter()
            .map(|r| {
                let own = cross.subcols(r, 1);
                let mut dependent = first.dependent.clone();
                let mut active = self.survivors(problem, &usable, first.weights.as_ref(), r);
                let mut before = usable.len();
                for _ in 1..self.max_iterations {
                    if active.len() == before {
                        break;
                    }
                    let fit = problem.solve(&active, own, self.added())?;
                    dependent.extend(fit.dependent);
                    before = active.len();
                    active = self.survivors(problem, &active, fit.weights.as_ref(), 0);
                }
                Self::finish(problem, own, &active, dependent)
            })
            .collect()
    }

    fn added(&self) -> Ridge {
        Ridge { part: self.ridge, plain: self.plain_ridge }
    }

    /// The columns of `active` whose weight in a fit is large enough.
    fn survivors(
        &self,
        problem: &Problem,
        active: &[usize],
        weights: MatRef<'_, f64>,
        response: usize,
    ) -> Vec<usize> {
        let large = |&&j: &&usize| self.size(problem, weights[(j, response)], j) > self.threshold;
        active.iter().filter(large).copied().collect()
    }

    /// Least squares on what stays.
    fn finish(
        problem: &Problem,
        cross: MatRef<'_, f64>,
        active: &[usize],
        mut dependent: Vec<usize>,
    ) -> Result<Selection, SparseError> {
        let fit = problem.solve(active, cross, Ridge::default())?;
        let active =
            active.iter().copied().filter(|j| fit.dependent.binary_search(j).is_err()).collect();
        dependent.extend(fit.dependent);
        dependent.sort_unstable();
        let coefficients = fit.weights.col_as_slice(0).to_vec();
        Ok(Selection { coefficients, active, dependent, certificate: None })
    }

    /// What the threshold is compared with.
    fn size(&self, problem: &Problem, weight: f64, j: usize) -> f64 {
        let scale = if self.standardise { problem.column_scale(j) } else { 1.0 };
        scale * weight.abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    fn diagonal(weights: &[f64]) -> Problem {
        let gram = Mat::from_fn(weights.len(), weights.len(), |i, j| f64::from(i == j) * 100.0);
        let cross = weights.iter().map(|c| 100.0 * c).collect();
        let energy = weights.iter().map(|c| 100.0 * c * c).sum();
        Problem::new(gram, cross, energy, 100.0).unwrap()
    }

    #[test]
    fn weights_above_the_threshold_stay() {
        let problem = diagonal(&[0.3, -0.05, 0.11, -0.4]);

        let selection = Stlsq::default().select(&problem).unwrap();

        assert_eq!(selection.active, [0, 2, 3]);
    }

    #[test]
    fn the_weights_kept_carry_no_ridge() {
        let problem = diagonal(&[0.3, -0.05]);

        let selection = Stlsq { ridge: 0.5, ..Stlsq::default() }.select(&problem).unwrap();

        assert!((selection.coefficients[0] - 0.3).abs() < 1e-15);
    }

    #[test]
    fn a_negative_threshold_is_refused() {
        let refused = Stlsq { threshold: -1.0, ..Stlsq::default() }.select(&diagonal(&[1.0]));

        assert!(matches!(refused, Err(SparseError::Setting { setting: "threshold", .. })));
    }
}
