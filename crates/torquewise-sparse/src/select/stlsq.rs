//! Problem → Selection by sequentially thresholded least squares, the selector of SINDy.

use crate::error::SparseError;
use crate::problem::{Problem, Selection, require};

/// Fit, drop the small weights, fit again, until none is small; then least squares on the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stlsq {
    /// Weights not above this are dropped; zero or more, in the unit of the weight, or of the
    /// response if `standardise` is set.
    pub threshold: f64,
    /// Ridge ρ ≥ 0 of the fits that choose: ½/m‖y − X c‖² + ½ρ Σ (sⱼ cⱼ)², sⱼ being the root mean
    /// square of column j. The last fit has none.
    pub ridge: f64,
    /// Bound on the number of fits that choose.
    pub max_iterations: usize,
    /// Compare what a term contributes, sⱼ|cⱼ|, with the threshold, not |cⱼ|.
    pub standardise: bool,
}

impl Default for Stlsq {
    /// The paper's threshold of 0.1 on the weights themselves, no ridge, at most 20 fits.
    fn default() -> Self {
        Self { threshold: 0.1, ridge: 0.0, max_iterations: 20, standardise: false }
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
        require("threshold", self.threshold, self.threshold >= 0.0, "zero or more")?;
        require("ridge", self.ridge, self.ridge >= 0.0, "zero or more")?;
        let mut active: Vec<usize> =
            (0..problem.n_columns()).filter(|&j| problem.column_scale(j) > 0.0).collect();
        let mut dependent = Vec::new();

        for _ in 0..self.max_iterations {
            let fit = problem.ridge(&active, self.ridge)?;
            let before = active.len();
            dependent.extend(fit.dependent);
            active = fit.active;
            active.retain(|&j| self.size(problem, &fit.coefficients, j) > self.threshold);
            if active.len() == before {
                break;
            }
        }

        let mut selection = problem.refit(&active)?.into_selection(None);
        selection.dependent.append(&mut dependent);
        selection.dependent.sort_unstable();
        Ok(selection)
    }

    /// What the threshold is compared with.
    fn size(&self, problem: &Problem, coefficients: &[f64], j: usize) -> f64 {
        let scale = if self.standardise { problem.column_scale(j) } else { 1.0 };
        scale * coefficients[j].abs()
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
