//! Sequentially thresholded least squares, the selector of SINDy.

use crate::normal_equations::require;
use crate::{KeptColumns, NormalEquations, Result};

/// Fit, drop the small weights, fit again, until none is small; then least squares on the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stlsq {
    /// Weights not above this are dropped; zero or more, in the unit of the weight.
    pub threshold: f64,
    /// Ridge α ≥ 0 of the fits that choose: ‖y − Y c‖² + α Σ cⱼ², as PySINDy has it. The last fit
    /// has none.
    pub ridge: f64,
}

const MOST_FITS: usize = 20;

impl Default for Stlsq {
    /// The paper's threshold of 0.1, no ridge.
    fn default() -> Self {
        Self { threshold: 0.1, ridge: 0.0 }
    }
}

impl Stlsq {
    /// Columns that survive the threshold, with their least-squares weights.
    ///
    /// A column dropped once does not return, whether it was small or linearly dependent.
    ///
    /// # Errors
    /// [`SparseError::Setting`](crate::SparseError::Setting) if threshold or ridge are negative or not finite.
    pub fn select(&self, problem: &NormalEquations) -> Result<KeptColumns> {
        require("threshold", self.threshold, self.threshold >= 0.0, "zero or more")?;
        require("ridge", self.ridge, self.ridge >= 0.0, "zero or more")?;
        let columns = 0..problem.n_columns();
        let mut active: Vec<usize> = columns.filter(|&j| problem.column_scale(j) > 0.0).collect();
        let mut gone = Vec::new();
        for _ in 0..MOST_FITS {
            let fit = problem.solve(&active, self.ridge);
            gone.extend(fit.dependent);
            let before = active.len();
            active.retain(|&j| fit.values[(j, 0)].abs() > self.threshold);
            if active.len() == before {
                break;
            }
        }
        let mut selection = problem.refit(&active)?;
        selection.dependent.extend(gone);
        selection.dependent.sort_unstable();
        Ok(selection)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    fn diagonal(weights: &[f64]) -> NormalEquations {
        let gram = Mat::from_fn(weights.len(), weights.len(), |i, j| f64::from(i == j) * 100.0);
        let cross: Vec<f64> = weights.iter().map(|c| 100.0 * c).collect();
        let energy = weights.iter().map(|c| 100.0 * c * c).sum();
        NormalEquations::new(gram, &cross, energy, 100.0).unwrap()
    }

    #[test]
    fn weights_above_the_threshold_stay_without_ridge_and_a_negative_one_is_refused() {
        let problem = diagonal(&[0.3, -0.05, 0.11, -0.4]);

        let plain = Stlsq::default().select(&problem).unwrap();
        let ridged = Stlsq { ridge: 1.0, ..Stlsq::default() }.select(&problem).unwrap();

        assert_eq!([&plain.active, &ridged.active], [&[0, 2, 3], &[0, 2, 3]]);
        assert!((ridged.coefficients[0] - 0.3).abs() < 1e-15);
        let refused = Stlsq { threshold: -1.0, ..Stlsq::default() }.select(&diagonal(&[1.0]));

        assert!(matches!(refused, Err(crate::SparseError::Setting { setting: "threshold", .. })));
    }
}
