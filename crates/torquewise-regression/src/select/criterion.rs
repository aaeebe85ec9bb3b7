//! Terms that explain more than noise: forward, then backward, by t² (E5).

use crate::cholesky;
use crate::error::SparseError;
use crate::normal_equations::{NormalEquations, Selection, require};
use faer::Mat;

/// Judges a term by what it explains against the noise.
///
/// A term stays if t² ≥ ln m + 2γ ln p: the extended Bayesian information criterion, with γ = 0 the
/// usual one. Terms enter one by one by what they explain, then the weakest leave one by one.
///
/// Leaving alone, from a fit of all candidates, would be no better: where a short log cannot tell
/// them apart, it leaves a thousand terms that cancel each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Criterion {
    /// γ, zero or more: how much harder it is to be one of many candidates.
    pub gamma: f64,
}

/// At most this many terms enter.
const MOST: usize = 400;

impl Default for Criterion {
    fn default() -> Self {
        Self { gamma: 1.0 }
    }
}

impl Criterion {
    /// The least t² that keeps a term of p candidates in m rows.
    pub fn threshold(&self, rows: f64, n_columns: usize) -> f64 {
        rows.max(1.0).ln() + 2.0 * self.gamma * (n_columns.max(1) as f64).ln()
    }

    /// Selects, and refits what is kept by least squares.
    ///
    /// # Errors
    /// [`SparseError`] if a setting is out of range.
    pub fn select(&self, problem: &NormalEquations) -> Result<Selection, SparseError> {
        require("gamma", self.gamma, self.gamma >= 0.0, "zero or more")?;
        let (inner, scale) = &problem.standardised();
        let usable: Vec<usize> = (0..problem.n_columns()).filter(|&j| scale[j] > 0.0).collect();
        let threshold = self.threshold(problem.rows, usable.len());

        let entered = forward(inner, &usable, threshold);
        let full = Full::new(inner, &entered).unwrap_or_else(|| Full::none(inner));
        let kept = full.backward(inner, threshold);
        problem.refit(&kept)
    }
}

/// A least-squares fit with its inverse Gram matrix, from which columns can be taken one by one.
struct Full {
    active: Vec<usize>,
    inverse: Mat<f64>,
    coefficients: Vec<f64>,
    residual: f64,
}

impl Full {
    fn none(problem: &NormalEquations) -> Self {
        Self {
            active: Vec::new(),
            inverse: Mat::zeros(0, 0),
            coefficients: Vec::new(),
            residual: problem.energy[0],
        }
    }

    /// Fits all of `active`; `None` if rounding makes them depend on each other.
    fn new(problem: &NormalEquations, active: &[usize]) -> Option<Self> {
        let size = active.len();
        if size == 0 {
            return Some(Self::none(problem));
        }
        let gram = Mat::from_fn(size, size, |i, j| problem.gram[(active[i], active[j])]);
        let inverse = cholesky::inverse(&gram)?;
        let coefficients: Vec<f64> = (0..size)
            .map(|j| (0..size).map(|i| inverse[(i, j)] * problem.right()[active[i]]).sum())
            .collect();
        let explained: f64 =
            coefficients.iter().zip(active).map(|(c, &j)| c * problem.right()[j]).sum();
        let residual = (problem.energy[0] - explained).max(problem.resolution());
        Some(Self { active: active.to_vec(), inverse, coefficients, residual })
    }

    /// Drops the weakest column while its t² is below the threshold; the noise is that of the full
    /// fit, lest dropping terms makes others look weak. Returns the columns kept, ascending.
    fn backward(mut self, problem: &NormalEquations, threshold: f64) -> Vec<usize> {
        let freedom = (problem.rows - self.active.len() as f64).max(1.0);
        let noise = self.residual / freedom;
        let loss = |full: &Self, place: usize| {
            full.coefficients[place].powi(2) / full.inverse[(place, place)]
        };
        while let Some(weakest) = (0..self.active.len()).min_by(|&a, &b| {
            let by_column = self.active[a].cmp(&self.active[b]);
            loss(&self, a).total_cmp(&loss(&self, b)).then(by_column)
        }) {
            if loss(&self, weakest) >= threshold * noise {
                break;
            }
            self.leave_out(weakest);
        }
        self.active.sort_unstable();
        self.active
    }

    /// Inverse and coefficients without one column, by a rank-one change. The last column takes
    /// its place, so that the rest stays one block of memory.
    fn leave_out(&mut self, gone: usize) {
        let last = self.active.len() - 1;
        self.swap(gone, last);
        self.active.pop();
        let pivot = self.inverse[(last, last)];
        let column: Vec<f64> = self.inverse.col_as_slice(last)[..last].to_vec();
        let share = self.coefficients[last] / pivot;
        self.coefficients.pop();
        for (j, (coefficient, &weight)) in self.coefficients.iter_mut().zip(&column).enumerate() {
            *coefficient -= weight * share;
            let factor = weight / pivot;
            let target = &mut self.inverse.col_as_slice_mut(j)[..last];
            target.iter_mut().zip(&column).for_each(|(value, c)| *value -= c * factor);
        }
    }

    fn swap(&mut self, one: usize, other: usize) {
        if one == other {
            return;
        }
        self.active.swap(one, other);
        self.coefficients.swap(one, other);
        for j in 0..self.inverse.ncols() {
            self.inverse.col_as_slice_mut(j).swap(one, other);
        }
        let (left, right) = self.inverse.two_cols_mut(one.min(other), one.max(other));
        faer::zip!(left, right).for_each(|faer::unzip!(a, b)| std::mem::swap(a, b));
    }
}

/// A column whose part unexplained by the others is below this share of it adds nothing but noise.
const DEPENDENT: f64 = 1e-9;

/// Orthogonal forward selection: at each turn the column that explains most of what is left enters,
/// while it explains more than the threshold asks of the noise left.
fn forward(problem: &NormalEquations, usable: &[usize], threshold: f64) -> Vec<usize> {
    let rows = problem.rows;
    let mut entered: Vec<usize> = Vec::new();
    let mut factors: Vec<Vec<f64>> = Vec::new();
    let mut own: Vec<f64> = usable.iter().map(|&j| problem.gram[(j, j)]).collect();
    let mut cross: Vec<f64> = usable.iter().map(|&j| problem.right()[j]).collect();
    let mut left = problem.energy[0];
    while entered.len() < MOST.min(usable.len()) {
        let gain = |place: usize| {
            if own[place] > DEPENDENT * rows { cross[place].powi(2) / own[place] } else { 0.0 }
        };
        let best = (0..usable.len())
            .map(|place| (place, gain(place)))
            .fold((0, 0.0), |best, next| if next.1 > best.1 { next } else { best });
        let freedom = (rows - entered.len() as f64).max(1.0);
        let noise = (left - best.1).max(problem.resolution()) / freedom;
        if best.1 <= threshold * noise || left <= problem.resolution() {
            break;
        }
        let factor = orthogonal_part(problem, usable, &factors, best.0, own[best.0].sqrt());
        let scaled = cross[best.0] / own[best.0].sqrt();
        for (place, l) in factor.iter().enumerate() {
            own[place] -= l * l;
            cross[place] -= l * scaled;
        }
        own[best.0] = 0.0;
        left -= best.1;
        factors.push(factor);
        entered.push(usable[best.0]);
    }
    entered.sort_unstable();
    entered
}

/// The next column of the Cholesky factor: what each column shares with the one that enters, beyond
/// what those before explain.
fn orthogonal_part(
    problem: &NormalEquations,
    usable: &[usize],
    factors: &[Vec<f64>],
    enters: usize,
    pivot: f64,
) -> Vec<f64> {
    let gram = &problem.gram;
    let mut part: Vec<f64> = usable.iter().map(|&j| gram[(j, usable[enters])]).collect();
    for before in factors {
        let weight = before[enters];
        for (value, l) in part.iter_mut().zip(before) {
            *value -= weight * l;
        }
    }
    part.into_iter().map(|value| value / pivot).collect()
}
