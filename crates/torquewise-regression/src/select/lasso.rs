//! LASSO: a path of penalties, the best support, its least squares.

use crate::error::SparseError;
use crate::normal_equations::{NormalEquations, Selection, require};
use crate::select::descent::Descent;

/// Least absolute shrinkage: min ½/m‖y − X c‖² + λ Σ sⱼ|cⱼ|.
///
/// Source: paper, eq. 5, with the squared norm. sⱼ is the root mean square of column j: what a term
/// contributes is penalised, not its weight, so that units play no part and λ has the unit of the
/// response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lasso {
    /// Number of penalties on the path, one or more.
    pub path: usize,
    /// Last penalty of the path over its first, in (0, 1).
    pub ratio: f64,
    /// Duality gap at which a point is done, as a part of ‖y‖²/m; above 0. Below 1e-13 rounding
    /// is all there is, and the sweeps run out.
    pub gap_tolerance: f64,
    /// Bound on the sweeps at each penalty. A point that needs more keeps its larger gap.
    pub max_sweeps: usize,
    /// LASSO weights |cⱼ| not above this do not count as active; zero or more, the paper has 0.1.
    pub threshold: f64,
}

impl Default for Lasso {
    /// 100 penalties down to 1e-4 of the first, no threshold.
    fn default() -> Self {
        Self { path: 100, ratio: 1e-4, gap_tolerance: 1e-9, max_sweeps: 2000, threshold: 0.0 }
    }
}

/// The LASSO at one penalty.
#[derive(Clone, Debug, PartialEq)]
pub struct PathPoint {
    /// Penalty λ.
    pub lambda: f64,
    /// Weight of every column of the problem as it was given, p.
    pub coefficients: Vec<f64>,
    /// Duality gap: the objective is at most this far above its minimum. Proven for a
    /// semidefinite Gram matrix, an indication for one that a noise correction made indefinite.
    pub gap: f64,
    /// Sweeps over the weights it took to get here from the point before.
    pub sweeps: usize,
}

/// LASSO solutions for falling penalties, each started from the one before.
///
/// The first penalty is the smallest with no active column. The path ends early where ‖y − X c‖²
/// of an indefinite Gram matrix falls below zero; what lies beyond has no meaning.
///
/// Checked against: `tests/lasso.rs`, the optimality conditions on the rows themselves.
///
/// # Errors
/// [`SparseError::Setting`] if a setting is out of its range.
pub fn lasso_path(problem: &NormalEquations, lasso: &Lasso) -> Result<Vec<PathPoint>, SparseError> {
    lasso.check()?;
    let (inner, scale) = &problem.standardised();
    let steepest = inner.right().iter().fold(0.0_f64, |most, b| most.max(b.abs()));
    let penalties = lasso.penalties(steepest / inner.rows);
    let tolerance = lasso.gap_tolerance * inner.energy[0] / inner.rows;
    let unscaled = |(c, s): (&f64, &f64)| if *s > 0.0 { c / s } else { 0.0 };

    let mut descent = Descent::new(inner);
    let mut points = Vec::with_capacity(penalties.len());
    for lambda in penalties {
        let reached = descent.run(lambda, tolerance, lasso.max_sweeps);
        if reached.indefinite {
            break;
        }
        points.push(PathPoint {
            lambda,
            coefficients: descent.weights.iter().zip(scale).map(unscaled).collect(),
            gap: reached.gap,
            sweeps: reached.sweeps,
        });
    }
    Ok(points)
}

impl Lasso {
    /// The support on the path whose least-squares refit has the lowest Bayesian information
    /// criterion, with the weights of that refit, which takes the shrinkage off.
    ///
    /// # Errors
    /// [`SparseError::Setting`] if a setting is out of its range.
    pub fn select(&self, problem: &NormalEquations) -> Result<Selection, SparseError> {
        let mut supports: Vec<Vec<usize>> =
            lasso_path(problem, self)?.iter().map(|point| self.support(point)).collect();
        supports.sort_by_key(Vec::len);
        supports.dedup();

        // No support explains more than all of them together, so once the terms alone cost too
        // much, no larger support can win. (Their dependent columns count as terms here.)
        let least = problem.refit(&supports.concat())?.residual_energy;

        let mut best = problem.refit(&[])?;
        let mut lowest = problem.bic(best.residual_energy, 0);
        for support in supports {
            if problem.bic(least, support.len()) >= lowest {
                break;
            }
            let refit = problem.refit(&support)?;
            let bic = problem.bic(refit.residual_energy, refit.active.len());
            if bic < lowest {
                (best, lowest) = (refit, bic);
            }
        }
        Ok(best)
    }

    /// Columns whose weight at this point counts as active.
    fn support(&self, point: &PathPoint) -> Vec<usize> {
        let weights = &point.coefficients;
        (0..weights.len()).filter(|&j| weights[j].abs() > self.threshold).collect()
    }

    /// Penalties in equal ratios, from the one above which nothing is active.
    fn penalties(&self, first: f64) -> Vec<f64> {
        let last = first * self.ratio;
        if first <= last || self.path == 1 {
            return vec![first];
        }
        let steps = (self.path - 1) as f64;
        let part = |step: usize| (last / first).powf(step as f64 / steps);
        (0..self.path).map(|k| if k + 1 == self.path { last } else { first * part(k) }).collect()
    }

    fn check(&self) -> Result<(), SparseError> {
        let ratio_fits = self.ratio > 0.0 && self.ratio < 1.0;
        require("path", self.path as f64, self.path > 0, "one or more")?;
        require("ratio", self.ratio, ratio_fits, "between 0 and 1")?;
        require("gap_tolerance", self.gap_tolerance, self.gap_tolerance > 0.0, "above zero")?;
        require("threshold", self.threshold, self.threshold >= 0.0, "zero or more")
    }
}
