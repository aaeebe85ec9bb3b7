//! LASSO: a path of penalties by coordinate descent on the Gram matrix, the best support, its least
//! squares.

use crate::normal_equations::{nonzero, require};
use crate::{KeptColumns, NormalEquations, Result, cholesky};
use faer::Mat;

/// Least absolute shrinkage: min ½/m‖y − X c‖² + λ Σ sⱼ|cⱼ|.
///
/// Source: paper, eq. 5, with the squared norm. sⱼ is the root mean square of column j: what a term
/// contributes is penalised, not its weight, so that units play no part and λ has the unit of the
/// response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lasso {
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
    /// Penalties down to 1e-4 of the first, no threshold.
    fn default() -> Self {
        Self { ratio: 1e-4, gap_tolerance: 1e-9, max_sweeps: 2000, threshold: 0.0 }
    }
}

/// Number of penalties on a path.
const PATH: usize = 100;

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
/// Checked against: the optimality conditions on the rows themselves.
///
/// # Errors
/// [`SparseError::Setting`](crate::SparseError::Setting) if a setting is out of its range.
pub fn lasso_path(problem: &NormalEquations, lasso: &Lasso) -> Result<Vec<PathPoint>> {
    let Lasso { ratio, gap_tolerance, max_sweeps, threshold } = *lasso;
    require("ratio", ratio, ratio > 0.0 && ratio < 1.0, "between 0 and 1")?;
    require("gap_tolerance", gap_tolerance, gap_tolerance > 0.0, "above zero")?;
    require("threshold", threshold, threshold >= 0.0, "zero or more")?;
    let (inner, scale) = &problem.standardised();
    let steepest = inner.right().iter().fold(0.0_f64, |most, b| most.max(b.abs()));
    // Penalties in equal ratios, from the one above which nothing is active.
    let first = steepest / inner.rows;
    let last = first * ratio;
    let part = |step: usize| (last / first).powf(step as f64 / (PATH - 1) as f64);
    let penalty = |k: usize| if k + 1 == PATH { last } else { first * part(k) };
    let tolerance = gap_tolerance * inner.energy[0] / inner.rows;
    let unscaled = |(c, s): (&f64, &f64)| if *s > 0.0 { c / s } else { 0.0 };

    let mut descent = Descent {
        problem: inner,
        weights: vec![0.0; inner.n_columns()],
        slope: inner.right().iter().map(|b| b / inner.rows).collect(),
    };
    let point = |lambda| {
        let (gap, sweeps) = descent.run(lambda, tolerance, max_sweeps)?;
        let coefficients = descent.weights.iter().zip(scale).map(unscaled).collect();
        Some(PathPoint { lambda, coefficients, gap, sweeps })
    };
    let count = if first <= last { 1 } else { PATH };
    Ok((0..count).map(penalty).map_while(point).collect())
}

impl Lasso {
    /// The support on the path whose least-squares refit has the lowest Bayesian information
    /// criterion, with the weights of that refit, which takes the shrinkage off.
    ///
    /// # Errors
    /// [`SparseError::Setting`](crate::SparseError::Setting) if a setting is out of its range.
    pub fn select(&self, problem: &NormalEquations) -> Result<KeptColumns> {
        let support = |PathPoint { coefficients, .. }| {
            (0..coefficients.len()).filter(|&j| coefficients[j].abs() > self.threshold).collect()
        };
        let mut supports: Vec<Vec<usize>> =
            lasso_path(problem, self)?.into_iter().map(support).collect();
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
}

/// Residual energy below zero by this part of the response's is no rounding: that stays under
/// ε Σ|bⱼcⱼ| ≤ ε λ_max/λ · yᵀy, and paths end at λ = 1e-4 λ_max or so.
const INDEFINITE: f64 = 1e-9;
/// Added to the diagonal for a Newton step, as a part of it.
const RIDGE: f64 = 1e-10;
/// Sweeps over the weights that are not zero before a Newton step is tried.
const BURST: usize = 10;

/// Cyclic coordinate descent on ½/m‖y − X c‖² + λ‖c‖₁, carried from one λ to the next.
///
/// Columns with an empty diagonal must have no cross product either.
struct Descent<'a> {
    problem: &'a NormalEquations,
    /// c, p.
    weights: Vec<f64>,
    /// Xᵀ(y − X c)/m, p.
    slope: Vec<f64>,
}

impl Descent<'_> {
    /// Descends to λ, until the duality gap is within `tolerance` or `max_sweeps` are spent; returns
    /// the gap and the sweeps, Newton steps included. `None` where the Gram matrix turns out to be
    /// indefinite along the weights.
    fn run(&mut self, lambda: f64, tolerance: f64, max_sweeps: usize) -> Option<(f64, usize)> {
        let mut sweeps = 0;
        loop {
            self.sweep(lambda);
            sweeps += 1;
            let gap = self.gap(lambda)?;
            if gap <= tolerance || sweeps >= max_sweeps {
                return Some((gap, sweeps));
            }
            // The weights that are not zero in a problem of their own: sweeps, then Newton steps
            // where these creep. What is left is one sweep over all.
            let places = nonzero(&self.weights, self.weights.len());
            let own = |values: &[f64]| places.iter().map(|&j| values[j]).collect();
            let (weights, slope) = (own(&self.weights), own(&self.slope));
            let mut active = Descent { problem: &self.problem.restricted(&places), weights, slope };
            let (mut spent, left) = (0, max_sweeps - sweeps - 1);
            while spent < left.min(BURST) {
                spent += 1;
                if active.sweep(lambda) * places.len() as f64 <= tolerance {
                    break;
                }
            }
            while spent < left {
                spent += 1;
                if !active.newton_step(lambda) {
                    break;
                }
            }
            for (&j, weight) in places.iter().zip(active.weights) {
                self.set_weight(j, weight);
            }
            sweeps += spent;
        }
    }

    fn set_weight(&mut self, j: usize, weight: f64) {
        let change = (weight - self.weights[j]) / self.problem.rows;
        self.weights[j] = weight;
        for (slope, entry) in self.slope.iter_mut().zip(self.problem.gram.col_as_slice(j)) {
            *slope -= change * entry;
        }
    }

    /// Minimises exactly over each weight in turn, the others held: the soft threshold. Returns the
    /// largest change squared, in the unit of the objective.
    fn sweep(&mut self, lambda: f64) -> f64 {
        let mut largest = 0.0_f64;
        for j in 0..self.weights.len() {
            let (before, curvature) =
                (self.weights[j], self.problem.gram[(j, j)] / self.problem.rows);
            let target = self.slope[j] + curvature * before;
            let shrunk = target.signum() * (target.abs() - lambda).max(0.0);
            let weight = if curvature > 0.0 { shrunk / curvature } else { 0.0 };
            let change = weight - before;
            if change != 0.0 {
                self.set_weight(j, weight);
                largest = largest.max(change * change * curvature);
            }
        }
        largest
    }

    /// Jumps to the optimum among weights of the present signs, or to the first sign change, which
    /// leaves that weight at zero; returns whether it was one, so that another step may follow.
    ///
    /// On a fixed sign pattern the objective is quadratic; correlated columns would cost thousands
    /// of sweeps. Along a direction that changes nothing but the penalty the ridge makes the step so
    /// long that a sign changes.
    fn newton_step(&mut self, lambda: f64) -> bool {
        let moving = nonzero(&self.weights, self.weights.len());
        let size = moving.len();
        let gram = Mat::from_fn(size, size, |i, j| {
            let ridge = if i == j { 1.0 + RIDGE } else { 1.0 };
            ridge * (self.problem.gram[(moving[i], moving[j])] / self.problem.rows)
        });
        let downhill = |i: usize| self.slope[moving[i]] - lambda * self.weights[moving[i]].signum();
        let step = cholesky::solve(gram, Mat::from_fn(size, 1, |i, _| downhill(i)).as_ref());
        let step = step.values.col_as_slice(0);
        let crossing =
            |(&j, step): (&usize, &f64)| Some(-self.weights[j] / step).filter(|x| *x > 0.0);
        let length = moving.iter().zip(step).filter_map(crossing).fold(1.0, f64::min);
        for (&j, step) in moving.iter().zip(step) {
            let before = self.weights[j];
            let moved = before + length * step;
            let crossed = moved * before.signum() <= 4.0 * f64::EPSILON * before.abs();
            self.set_weight(j, if crossed { 0.0 } else { moved });
        }
        length < 1.0
    }

    /// Duality gap; `None` if ‖y − X c‖² came out negative by more than rounding, or overflowed.
    ///
    /// The dual point is the residual r = y − X c, scaled until no column sees more than λ of it:
    /// D(u) = yᵀu/m − ½uᵀu/m subject to ‖Xᵀu‖∞/m ≤ λ.
    fn gap(&self, lambda: f64) -> Option<f64> {
        let NormalEquations { rows, ref energy, .. } = *self.problem;
        // yᵀr/m and what of it the fit explains, cᵀXᵀr/m.
        let (mut with_response, mut with_fit) = (energy[0] / rows, 0.0);
        for (j, weight) in self.weights.iter().enumerate() {
            with_response -= weight * self.problem.right()[j] / rows;
            with_fit += weight * self.slope[j];
        }
        let mean_square = with_response - with_fit;
        if !mean_square.is_finite() || mean_square < -INDEFINITE * energy[0] / rows {
            return None;
        }
        let steepest = self.slope.iter().fold(0.0_f64, |most, slope| most.max(slope.abs()));
        let best = if mean_square > 0.0 { with_response / mean_square } else { 1.0 };
        let limit = if steepest > 0.0 { lambda / steepest } else { f64::INFINITY };
        let shrink = best.clamp(-limit, limit);

        let size: f64 = self.weights.iter().map(|weight| weight.abs()).sum();
        let primal = 0.5 * mean_square + lambda * size;
        Some(primal - (shrink * with_response - 0.5 * shrink * shrink * mean_square))
    }
}
