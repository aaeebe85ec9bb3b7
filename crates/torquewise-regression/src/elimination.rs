//! Backward elimination by t² with sandwich standard errors: the least significant term goes first
//! (E5).

use crate::products::product;
use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, Side};

/// Estimating equations A c = b with the spread of their right-hand side.
#[derive(Clone, Debug)]
pub struct Equations {
    /// A, p×p, symmetric: XᵀX, less what noise in X adds to it.
    pub information: Mat<f64>,
    /// b, p: Xᵀy.
    pub right: Vec<f64>,
    /// Ω, p×p: covariance of b − A c, so that c has the covariance A⁻¹ΩA⁻¹ (the sandwich).
    pub spread: Mat<f64>,
    /// Least |c| of each column that can be told from rounding, p.
    pub floor: Vec<f64>,
}

/// What is left when every remaining term is significant.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Columns kept, ascending.
    pub active: Vec<usize>,
    /// Their weights, in the same order.
    pub coefficients: Vec<f64>,
    /// Standard errors of the weights, in the same order.
    pub std_errors: Vec<f64>,
}

/// Above this many columns, clearly insignificant ones leave several at a time.
const ONE_BY_ONE: usize = 120;
/// A column with t² below this is clearly insignificant.
const CLEARLY: f64 = 1.0;

impl Equations {
    /// Drops the column of the smallest t² = c²/var(c), solves again, and stops when all that
    /// remain have t² ≥ `threshold`.
    ///
    /// - `columns`: those to begin with, ascending; an empty one is left out
    ///
    /// Returns `None` if A is not positive definite on these columns.
    ///
    /// # Panics
    /// If the parts differ in size.
    pub fn eliminate(&self, columns: &[usize], threshold: f64) -> Option<Estimate> {
        let mut active = columns.to_vec();
        active.retain(|&j| self.information[(j, j)] > 0.0);
        loop {
            let (estimate, t_squared) = self.solve(&active)?;
            // The weakest below the threshold, or while there are many, a tenth of them among those
            // that are clearly insignificant.
            let mut leaving: Vec<usize> =
                (0..active.len()).filter(|&j| t_squared[j] < threshold).collect();
            if leaving.is_empty() {
                return Some(estimate);
            }
            leaving.sort_by(|&a, &b| t_squared[a].total_cmp(&t_squared[b]).then(a.cmp(&b)));
            let clear = leaving.iter().filter(|&&j| t_squared[j] < CLEARLY).count();
            let at_once = if active.len() > ONE_BY_ONE { clear.min(active.len() / 10) } else { 1 };
            leaving.truncate(at_once.max(1));
            leaving.sort_unstable();
            leaving.iter().rev().for_each(|&place| _ = active.remove(place));
        }
    }

    /// The estimate in some columns, and t² of each.
    fn solve(&self, active: &[usize]) -> Option<(Estimate, Vec<f64>)> {
        let size = active.len();
        // Columns of unit length, lest units decide what is singular.
        let length: Vec<f64> = active.iter().map(|&j| self.information[(j, j)].sqrt()).collect();
        let pick = |from: &Mat<f64>| {
            Mat::from_fn(size, size, |i, j| from[(active[i], active[j])] / (length[i] * length[j]))
        };
        let inverse = pick(&self.information).llt(Side::Lower).ok()?.inverse();
        let half = product(inverse.as_ref(), pick(&self.spread).as_ref());

        let [mut coefficients, mut std_errors, mut t_squared] = [const { Vec::new() }; 3];
        for (j, &column) in active.iter().enumerate() {
            let solved: f64 =
                (0..size).map(|i| inverse[(j, i)] * self.right[active[i]] / length[i]).sum();
            let variance: f64 = (0..size).map(|i| half[(j, i)] * inverse[(i, j)]).sum();
            let (coefficient, std_error) =
                (solved / length[j], variance.max(0.0).sqrt() / length[j]);
            let resolved = coefficient.abs() > self.floor[column];
            let t = if resolved { coefficient / std_error.max(f64::MIN_POSITIVE) } else { 0.0 };
            coefficients.push(coefficient);
            std_errors.push(std_error);
            t_squared.push(t * t);
        }
        Some((Estimate { active: active.to_vec(), coefficients, std_errors }, t_squared))
    }
}
