//! Least squares of rows that err alike within a stretch of time: errors are those of clusters.

use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, MatRef, Side};
use torquewise_regression::NormalEquations;

/// Held at unit columns, so that one that repeats another has some coefficient.
const RIDGE: f64 = 1e-10;

/// What normal equations leave at a solution, p×1.
pub(crate) fn score(of: &NormalEquations, solution: MatRef<'_, f64>) -> Mat<f64> {
    &of.cross - &of.gram * solution
}

/// Σ s sᵀ of the scores of stretches, p×1 each, as many would scatter: p×p.
pub(crate) fn scatter(scores: impl Iterator<Item = Mat<f64>>) -> Mat<f64> {
    let squares: Vec<Mat<f64>> = scores.map(|score| &score * score.transpose()).collect();
    let count = squares.len() as f64;
    let sum = squares.into_iter().reduce(|sum, square| sum + square);
    sum.unwrap_or_else(|| Mat::zeros(0, 0)) * faer::Scale(count / f64::max(count - 1.0, 1.0))
}

/// Sums over equal stretches of time, a bounded number, and the rest.
#[derive(Clone, Debug)]
pub(crate) struct Stretches {
    most: usize,
    length: usize,
    whole: Vec<NormalEquations>,
    rest: NormalEquations,
}

/// A solution with what is known of each coefficient.
#[derive(Clone, Debug)]
pub(crate) struct Solved {
    pub(crate) values: Vec<f64>,
    /// Standard errors, those of clusters.
    pub(crate) std_errors: Vec<f64>,
    /// Part of the squares of each column that no other column explains.
    pub(crate) free: Vec<f64>,
    /// Squares of the response that the coefficient of each column explains beside the others.
    pub(crate) gained: Vec<f64>,
    /// Squares of the response that all columns leave.
    pub(crate) left: f64,
}

impl Stretches {
    /// - `most`: stretches at most; where there are more, each two neighbours become one
    /// - `length`: equations of the first stretches
    pub(crate) fn new(columns: usize, most: usize, length: usize) -> Self {
        Self { most, length, whole: Vec::new(), rest: NormalEquations::zeros(columns, 1) }
    }

    pub(crate) fn add(&mut self, columns: &[f64], response: f64, weight: f64) {
        self.rest.rows += 1.0;
        self.rest.energy[0] += weight * response * response;
        for (j, x) in columns.iter().enumerate() {
            let weighed = weight * x;
            self.rest.cross[(j, 0)] += weighed * response;
            let own = self.rest.gram.col_as_slice_mut(j).iter_mut();
            own.zip(columns).for_each(|(sum, y)| *sum += weighed * y);
        }
        if self.rest.rows < self.length as f64 {
            return;
        }
        let none = NormalEquations::zeros(columns.len(), 1);
        self.whole.push(std::mem::replace(&mut self.rest, none));
        if self.whole.len() >= self.most {
            self.whole = self.whole.chunks(2).map(|pair| pair.iter().sum()).collect();
            self.length *= 2;
        }
    }

    /// The same equations, each of them weighted so much more.
    pub(crate) fn weighted(&self, by: f64) -> Self {
        let weighted = |own: &NormalEquations| {
            let NormalEquations { gram, cross, energy, rows } = own;
            let energy = energy.iter().map(|energy| by * energy).collect();
            let [gram, cross] = [gram, cross].map(|own| faer::Scale(by) * own);
            NormalEquations { gram, cross, energy, rows: *rows }
        };
        let whole = self.whole.iter().map(weighted).collect();
        Self { whole, rest: weighted(&self.rest), ..*self }
    }

    pub(crate) fn all(&self) -> impl Iterator<Item = &NormalEquations> {
        self.whole.iter().chain(Some(&self.rest).filter(|rest| rest.rows > 0.0))
    }

    pub(crate) fn total(&self) -> NormalEquations {
        self.whole.iter().chain([&self.rest]).sum()
    }

    /// Least squares; a column of nothing but zeros has a coefficient of zero.
    pub(crate) fn solved(&self) -> Option<Solved> {
        let total = self.total();
        let p = total.cross.nrows();
        let size: Vec<f64> = (0..p).map(|k| total.gram[(k, k)].sqrt()).collect();
        let units = Mat::from_fn(p, p, |i, j| {
            let is_own =
                f64::from(u8::from(i == j)) * if size[i] > 0.0 { 1.0 + RIDGE } else { 1.0 };
            let across = size[i] * size[j];
            if i != j && across > 0.0 { total.gram[(i, j)] / across } else { is_own }
        });
        let inverse = units.llt(Side::Lower).ok()?.inverse();
        let per = |k: usize| if size[k] > 0.0 { 1.0 / size[k] } else { 0.0 };
        let inverse = Mat::from_fn(p, p, |i, j| per(i) * inverse[(i, j)] * per(j));
        let values = &inverse * &total.cross;
        let covariance =
            &inverse * scatter(self.all().map(|own| score(own, values.as_ref()))) * &inverse;
        let explained = (values.transpose() * &total.cross)[(0, 0)];
        let free = |k: usize| if size[k] > 0.0 { per(k).powi(2) / inverse[(k, k)] } else { 0.0 };
        let free: Vec<f64> = (0..p).map(free).collect();
        Some(Solved {
            gained: (0..p).map(|k| free[k] * (values[(k, 0)] * size[k]).powi(2)).collect(),
            std_errors: (0..p).map(|k| covariance[(k, k)].max(0.0).sqrt()).collect(),
            values: values.col_as_slice(0).to_vec(),
            free,
            left: (total.energy[0] - explained).max(0.0),
        })
    }
}
