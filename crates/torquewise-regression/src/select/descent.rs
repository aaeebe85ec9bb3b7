//! From problem, λ to LASSO optimum with its duality gap: coordinate descent on a growing working
//! set.

use crate::cholesky;
use crate::problem::{Problem, nonzero};
use faer::{Mat, MatRef};

/// Sweeps over the nonzero weights, at least, before a Newton step is tried.
const BURST: usize = 10;

/// A Newton step costs about one sweep for this many nonzero weights.
const COLUMNS_PER_SWEEP: usize = 16;

/// Residual energy below zero by this part of the response's is no rounding: that stays under
/// ε Σ|bⱼcⱼ| ≤ ε λ_max/λ · yᵀy, and paths end at λ = 1e-4 λ_max or so.
const INDEFINITE: f64 = 1e-9;

/// Descent on ½/m‖y − X c‖² + λ‖c‖₁, carried from one λ to the next.
///
/// Only the columns that ever looked useful are swept. They form the working set; its part of the
/// Gram matrix lies compact in `columns`, and `slope` follows each change of a weight.
pub(super) struct Descent<'a> {
    problem: &'a Problem,
    /// Working set: columns of the problem, in the order they joined.
    working: Vec<usize>,
    is_working: Vec<bool>,
    /// XᵀX/m of the working set, column by column.
    columns: Vec<Vec<f64>>,
    /// Weights of the working set.
    weights: Vec<f64>,
    /// Xᵀ(y − X c)/m of the working set.
    slope: Vec<f64>,
    /// Xᵀ(y − X c)/m of all columns, as of the last look at them.
    slope_of_all: Vec<f64>,
}

/// How far the descent came.
pub(super) struct Reached {
    /// Objective minus a lower bound of its minimum.
    pub(super) gap: f64,
    /// Sweeps taken, Newton steps included.
    pub(super) sweeps: usize,
    /// The quadratic part fell below zero: the Gram matrix is indefinite along the weights.
    pub(super) indefinite: bool,
}

impl<'a> Descent<'a> {
    /// Starts at c = 0. Columns with an empty diagonal must have no cross product either.
    pub(super) fn new(problem: &'a Problem) -> Self {
        Self {
            problem,
            working: Vec::new(),
            is_working: vec![false; problem.n_columns()],
            columns: Vec::new(),
            weights: Vec::new(),
            slope: Vec::new(),
            slope_of_all: problem.cross().iter().map(|b| b / problem.rows()).collect(),
        }
    }

    /// Weights of all columns, p.
    pub(super) fn coefficients(&self) -> Vec<f64> {
        let mut coefficients = vec![0.0; self.problem.n_columns()];
        for (&j, &weight) in self.working.iter().zip(&self.weights) {
            coefficients[j] = weight;
        }
        coefficients
    }

    /// Descends to λ from the weights at `previous` λ, until the gap on all columns is within
    /// `tolerance` or `max_sweeps` are spent.
    pub(super) fn run(
        &mut self,
        lambda: f64,
        previous: f64,
        tolerance: f64,
        max_sweeps: usize,
    ) -> Reached {
        // Strong rule: a column further than this below λ stays at zero in all but rare cases,
        // and those are caught below. After a long stride of λ it would let in everything.
        self.admit((2.0 * lambda - previous).max(0.5 * lambda));
        let mut sweeps = 0;
        loop {
            sweeps += self.descend(lambda, 0.5 * tolerance, max_sweeps - sweeps);
            self.look_at_all();
            let indefinite = self.is_indefinite();
            let gap = self.gap(&self.slope_of_all, lambda);
            let done = gap <= tolerance || sweeps >= max_sweeps || indefinite;
            if done || !self.admit(lambda) {
                return Reached { gap, sweeps, indefinite };
            }
        }
    }

    /// Sweeps the working set until its own gap is within `tolerance`; returns the sweeps taken.
    fn descend(&mut self, lambda: f64, tolerance: f64, max_sweeps: usize) -> usize {
        let mut sweeps = 0;
        while sweeps < max_sweeps {
            let all: Vec<usize> = (0..self.working.len()).collect();
            let change = self.sweep(&all, lambda);
            sweeps += 1;
            if self.gap(&self.slope, lambda) <= tolerance || change == 0.0 {
                break;
            }
            let active = nonzero(&self.weights, self.weights.len());
            let burst = BURST.max(active.len() / COLUMNS_PER_SWEEP);
            for _ in 0..burst.min(max_sweeps - sweeps) {
                sweeps += 1;
                let change = self.sweep(&active, lambda);
                if change * change * active.len() as f64 <= tolerance {
                    break;
                }
            }
            if self.gap(&self.slope, lambda) <= tolerance || self.is_indefinite() {
                break;
            }
            while sweeps < max_sweeps {
                sweeps += 1;
                if !self.newton_step(lambda) {
                    break;
                }
            }
        }
        sweeps
    }

    /// One pass of exact minimisation over each of the given weights; returns the largest change
    /// of one in the units of the response, zero if it is lost in rounding.
    fn sweep(&mut self, indices: &[usize], lambda: f64) -> f64 {
        let mut largest = 0.0_f64;
        for &j in indices {
            let curvature = self.columns[j][j];
            let before = self.weights[j];
            let target = soft_threshold(self.slope[j] + curvature * before, lambda);
            let after = if curvature > 0.0 { target / curvature } else { 0.0 };
            let change = after - before;
            if change != 0.0 {
                self.weights[j] = after;
                subtract(&mut self.slope, change, &self.columns[j]);
                if change.abs() > 4.0 * f64::EPSILON * after.abs() {
                    largest = largest.max(change.abs() * curvature.sqrt());
                }
            }
        }
        largest
    }

    /// Jumps to the optimum among weights of the present signs, or to the first sign change.
    ///
    /// On a fixed sign pattern the objective is quadratic, so descent along this line is certain
    /// where the Gram matrix is definite; correlated columns would cost thousands of sweeps.
    /// Returns true if a weight reached zero, so that another step may follow.
    fn newton_step(&mut self, lambda: f64) -> bool {
        let active = nonzero(&self.weights, self.weights.len());
        let right: Vec<f64> = active.iter().map(|&j| self.descent_of(j, lambda)).collect();
        let step = cholesky::solve(|| self.gram_of(&active), column(&right));
        match step.dependent.first() {
            Some(&surplus) => self.drop_one(&active, &step.dependent, surplus, lambda),
            None => self.advance(&active, step.values.col_as_slice(0), 1.0),
        }
    }

    /// Moves weights of dependent columns against each other until one is zero; the fit stays.
    ///
    /// - `active`: columns with a weight; `dependent`: places in it without a pivot
    /// - `surplus`: the dependent one that the others replace, or that replaces others
    fn drop_one(
        &mut self,
        active: &[usize],
        dependent: &[usize],
        surplus: usize,
        lambda: f64,
    ) -> bool {
        let is_pivot = |i: &usize| dependent.binary_search(i).is_err();
        let mut moving: Vec<usize> =
            (0..active.len()).filter(is_pivot).map(|i| active[i]).collect();
        let right: Vec<f64> = moving.iter().map(|&j| self.columns[j][active[surplus]]).collect();
        let solution = cholesky::solve(|| self.gram_of(&moving), column(&right));
        let mut direction = solution.values.col_as_slice(0).to_vec();
        moving.push(active[surplus]);
        direction.push(-1.0);

        let gain = moving.iter().zip(&direction).map(|(&j, d)| d * self.descent_of(j, lambda));
        if gain.sum::<f64>() < 0.0 {
            for d in &mut direction {
                *d = -*d;
            }
        }
        self.advance(&moving, &direction, f64::INFINITY)
    }

    /// Negative derivative of the objective by a weight that is not zero.
    fn descent_of(&self, j: usize, lambda: f64) -> f64 {
        self.slope[j] - lambda * self.weights[j].signum()
    }

    /// XᵀX/m of some of the working set.
    fn gram_of(&self, chosen: &[usize]) -> Mat<f64> {
        Mat::from_fn(chosen.len(), chosen.len(), |i, j| self.columns[chosen[j]][chosen[i]])
    }

    /// Moves weights along a direction, by `limit` of it or to the first sign change, whichever
    /// comes first. Returns true if it was a sign change, which leaves that weight at zero.
    fn advance(&mut self, moving: &[usize], direction: &[f64], limit: f64) -> bool {
        let crossing = |(&j, d): (&usize, &f64)| {
            let at = -self.weights[j] / d;
            (at > 0.0).then_some(at)
        };
        let length = moving.iter().zip(direction).filter_map(crossing).fold(limit, f64::min);
        if !length.is_finite() {
            return false;
        }
        for (&j, d) in moving.iter().zip(direction) {
            let before = self.weights[j];
            let moved = before + length * d;
            let crossed = moved * before.signum() <= 4.0 * f64::EPSILON * before.abs();
            let after = if crossed { 0.0 } else { moved };
            self.weights[j] = after;
            subtract(&mut self.slope, after - before, &self.columns[j]);
        }
        length < limit
    }

    /// Lets in each column whose slope exceeds `bound`; false if there was none.
    fn admit(&mut self, bound: f64) -> bool {
        let first = self.working.len();
        for (j, slope) in self.slope_of_all.iter().enumerate() {
            if slope.abs() > bound && !self.is_working[j] {
                self.is_working[j] = true;
                self.working.push(j);
            }
        }
        let entry = |i: usize, j: usize| self.problem.gram()[(i, j)] / self.problem.rows();
        for (column, &j) in self.columns.iter_mut().zip(&self.working) {
            column.extend(self.working[first..].iter().map(|&i| entry(i, j)));
        }
        for &j in &self.working[first..] {
            self.columns.push(self.working.iter().map(|&i| entry(i, j)).collect());
            self.weights.push(0.0);
            self.slope.push(self.slope_of_all[j]);
        }
        self.working.len() > first
    }

    /// Recomputes the slope of every column, which also clears rounding from the working set's.
    fn look_at_all(&mut self) {
        let rows = self.problem.rows();
        self.slope_of_all.copy_from_slice(self.problem.cross());
        for (&j, &weight) in self.working.iter().zip(&self.weights) {
            if weight != 0.0 {
                subtract(&mut self.slope_of_all, weight, self.problem.gram_column(j));
            }
        }
        for slope in &mut self.slope_of_all {
            *slope /= rows;
        }
        for (slope, &j) in self.slope.iter_mut().zip(&self.working) {
            *slope = self.slope_of_all[j];
        }
    }

    /// Mean squares of the residual as (yᵀr/m, rᵀr/m) with r = y − X c.
    fn residual(&self) -> (f64, f64) {
        let rows = self.problem.rows();
        let mut with_response = self.problem.energy() / rows;
        let mut with_fit = 0.0;
        for ((&j, weight), slope) in self.working.iter().zip(&self.weights).zip(&self.slope) {
            with_response -= weight * self.problem.cross()[j] / rows;
            with_fit += weight * slope;
        }
        (with_response, with_response - with_fit)
    }

    /// Whether ‖y − X c‖² came out negative by more than rounding, or overflowed.
    fn is_indefinite(&self) -> bool {
        let (_, mean_square) = self.residual();
        let floor = -INDEFINITE * self.problem.energy() / self.problem.rows();
        !mean_square.is_finite() || mean_square < floor
    }

    /// Duality gap over the columns whose slopes are given.
    ///
    /// The dual point is the residual, scaled until no column sees more than λ of it:
    /// D(u) = yᵀu/m − ½uᵀu/m subject to ‖Xᵀu‖∞/m ≤ λ.
    fn gap(&self, slopes: &[f64], lambda: f64) -> f64 {
        let (with_response, mean_square) = self.residual();
        let steepest = slopes.iter().fold(0.0_f64, |most, slope| most.max(slope.abs()));
        let best = if mean_square > 0.0 { with_response / mean_square } else { 1.0 };
        let limit = if steepest > 0.0 { lambda / steepest } else { f64::INFINITY };
        let shrink = best.clamp(-limit, limit);

        let size: f64 = self.weights.iter().map(|weight| weight.abs()).sum();
        let primal = 0.5 * mean_square + lambda * size;
        primal - (shrink * with_response - 0.5 * shrink * shrink * mean_square)
    }
}

/// The value nearest to zero within `lambda` of `x`.
fn soft_threshold(x: f64, lambda: f64) -> f64 {
    x.signum() * (x.abs() - lambda).max(0.0)
}

/// `target` −= `factor` · `column`.
fn subtract(target: &mut [f64], factor: f64, column: &[f64]) {
    for (t, c) in target.iter_mut().zip(column) {
        *t -= factor * c;
    }
}

/// Numbers as a matrix of one column.
fn column(numbers: &[f64]) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(numbers, numbers.len(), 1)
}
