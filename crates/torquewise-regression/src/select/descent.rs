//! LASSO optimum at one λ, with its duality gap: cyclic coordinate descent on the Gram matrix.

use crate::cholesky;
use crate::normal_equations::{NormalEquations, nonzero};
use faer::Mat;

/// Residual energy below zero by this part of the response's is no rounding: that stays under
/// ε Σ|bⱼcⱼ| ≤ ε λ_max/λ · yᵀy, and paths end at λ = 1e-4 λ_max or so.
const INDEFINITE: f64 = 1e-9;

/// Added to the diagonal for a Newton step, as a part of it.
const RIDGE: f64 = 1e-10;

/// Sweeps over the weights that are not zero before a Newton step is tried.
const BURST: usize = 10;

/// Descent on ½/m‖y − X c‖² + λ‖c‖₁, carried from one λ to the next.
pub(super) struct Descent<'a> {
    problem: &'a NormalEquations,
    /// c, p.
    pub(super) weights: Vec<f64>,
    /// Xᵀ(y − X c)/m, p.
    slope: Vec<f64>,
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
    pub(super) fn new(problem: &'a NormalEquations) -> Self {
        let slope = problem.right().iter().map(|b| b / problem.rows).collect();
        Self { problem, weights: vec![0.0; problem.n_columns()], slope }
    }

    /// Descends to λ, until the gap is within `tolerance` or `max_sweeps` are spent.
    ///
    pub(super) fn run(&mut self, lambda: f64, tolerance: f64, max_sweeps: usize) -> Reached {
        let mut sweeps = 0;
        loop {
            let Self { problem, weights, slope } = self;
            sweep(&problem.gram, problem.rows, weights, slope, lambda);
            sweeps += 1;
            let (gap, indefinite) = (self.gap(lambda), self.is_indefinite());
            if gap <= tolerance || sweeps >= max_sweeps || indefinite {
                return Reached { gap, sweeps, indefinite };
            }
            sweeps += self.sweep_active(lambda, tolerance, max_sweeps - sweeps - 1);
        }
    }

    /// Sweeps over the weights that are not zero, then Newton steps where these creep; returns the
    /// sweeps, Newton steps included.
    fn sweep_active(&mut self, lambda: f64, tolerance: f64, max_sweeps: usize) -> usize {
        let mut active = Active::of(self);
        let mut sweeps = 0;
        while sweeps < max_sweeps.min(BURST) {
            sweeps += 1;
            let Active { gram, rows, weights, slope, .. } = &mut active;
            if sweep(gram, *rows, weights, slope, lambda) * weights.len() as f64 <= tolerance {
                break;
            }
        }
        while sweeps < max_sweeps {
            sweeps += 1;
            if !active.newton_step(lambda) {
                break;
            }
        }
        for (&j, weight) in active.places.iter().zip(active.weights) {
            let change = (weight - self.weights[j]) / self.problem.rows;
            subtract(&mut self.slope, change, self.problem.gram_column(j));
            self.weights[j] = weight;
        }
        sweeps
    }

    /// Mean squares of the residual as (yᵀr/m, rᵀr/m) with r = y − X c.
    fn residual(&self) -> (f64, f64) {
        let rows = self.problem.rows;
        let mut with_response = self.problem.energy[0] / rows;
        let mut with_fit = 0.0;
        for ((cross, weight), slope) in
            self.problem.right().iter().zip(&self.weights).zip(&self.slope)
        {
            with_response -= weight * cross / rows;
            with_fit += weight * slope;
        }
        (with_response, with_response - with_fit)
    }

    /// Whether ‖y − X c‖² came out negative by more than rounding, or overflowed.
    fn is_indefinite(&self) -> bool {
        let (_, mean_square) = self.residual();
        let floor = -INDEFINITE * self.problem.energy[0] / self.problem.rows;
        !mean_square.is_finite() || mean_square < floor
    }

    /// Duality gap.
    ///
    /// The dual point is the residual, scaled until no column sees more than λ of it:
    /// D(u) = yᵀu/m − ½uᵀu/m subject to ‖Xᵀu‖∞/m ≤ λ.
    fn gap(&self, lambda: f64) -> f64 {
        let (with_response, mean_square) = self.residual();
        let steepest = self.slope.iter().fold(0.0_f64, |most, slope| most.max(slope.abs()));
        let best = if mean_square > 0.0 { with_response / mean_square } else { 1.0 };
        let limit = if steepest > 0.0 { lambda / steepest } else { f64::INFINITY };
        let shrink = best.clamp(-limit, limit);

        let size: f64 = self.weights.iter().map(|weight| weight.abs()).sum();
        let primal = 0.5 * mean_square + lambda * size;
        primal - (shrink * with_response - 0.5 * shrink * shrink * mean_square)
    }
}

/// The part of the descent in the columns with a weight, compact.
struct Active {
    places: Vec<usize>,
    /// XᵀX of these columns.
    gram: Mat<f64>,
    rows: f64,
    weights: Vec<f64>,
    slope: Vec<f64>,
}

impl Active {
    fn of(descent: &Descent<'_>) -> Self {
        let places = nonzero(&descent.weights, descent.weights.len());
        let own = |values: &[f64]| places.iter().map(|&j| values[j]).collect();
        let (weights, slope) = (own(&descent.weights), own(&descent.slope));
        let NormalEquations { gram, rows, .. } = descent.problem.restricted(&places);
        Self { places, gram, rows, weights, slope }
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
        let entry = |i: usize, j: usize| self.gram[(moving[i], moving[j])] / self.rows;
        let ridge = |i: usize, j: usize| if i == j { 1.0 + RIDGE } else { 1.0 };
        let gram = || Mat::from_fn(size, size, |i, j| ridge(i, j) * entry(i, j));
        let downhill = |i: usize| self.slope[moving[i]] - lambda * self.weights[moving[i]].signum();
        let right = Mat::from_fn(size, 1, |i, _| downhill(i));
        let step = cholesky::solve(gram, right.as_ref());
        let step = step.values.col_as_slice(0);
        let crossing =
            |(&j, step): (&usize, &f64)| Some(-self.weights[j] / step).filter(|x| *x > 0.0);
        let length = moving.iter().zip(step).filter_map(crossing).fold(1.0, f64::min);
        for (&j, step) in moving.iter().zip(step) {
            let before = self.weights[j];
            let moved = before + length * step;
            let crossed = moved * before.signum() <= 4.0 * f64::EPSILON * before.abs();
            self.weights[j] = if crossed { 0.0 } else { moved };
            let change = (self.weights[j] - before) / self.rows;
            subtract(&mut self.slope, change, self.gram.col_as_slice(j));
        }
        length < 1.0
    }
}

/// Minimises exactly over each weight in turn, the others held: the soft threshold. Returns the
/// largest change squared, in the unit of the objective.
fn sweep(gram: &Mat<f64>, rows: f64, weights: &mut [f64], slope: &mut [f64], lambda: f64) -> f64 {
    let mut largest = 0.0_f64;
    for (j, weight) in weights.iter_mut().enumerate() {
        let column = gram.col_as_slice(j);
        let (before, curvature) = (*weight, column[j] / rows);
        let target = slope[j] + curvature * before;
        let shrunk = target.signum() * (target.abs() - lambda).max(0.0);
        *weight = if curvature > 0.0 { shrunk / curvature } else { 0.0 };
        let change = *weight - before;
        if change != 0.0 {
            subtract(slope, change / rows, column);
            largest = largest.max(change * change * curvature);
        }
    }
    largest
}

/// `target` −= `factor` · `column`.
fn subtract(target: &mut [f64], factor: f64, column: &[f64]) {
    for (t, c) in target.iter_mut().zip(column) {
        *t -= factor * c;
    }
}
