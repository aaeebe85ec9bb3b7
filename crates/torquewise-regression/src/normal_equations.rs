//! Normal equations YᵀY and Yᵀy: all that least squares can know of rows, and what it makes of them.

use crate::cholesky::{self, Solution};
use crate::{Result, SparseError, expect};
use faer::Mat;

/// Relative residual energy that rounding alone leaves in normal equations.
///
/// Sums over rows keep about 13 digits, so a residual below 3e-7 of the response is not resolved.
const RESOLUTION: f64 = 1e-13;

/// Normal equations of one or several responses of the same rows.
///
/// The Gram matrix may be slightly indefinite, as it is after a noise correction.
#[derive(Clone, Debug)]
pub struct NormalEquations {
    /// YᵀY, p×p, symmetric.
    pub gram: Mat<f64>,
    /// Yᵀy of each response, p×r.
    pub cross: Mat<f64>,
    /// yᵀy of each response, r.
    pub energy: Vec<f64>,
    /// Rows m.
    pub rows: f64,
}

/// The columns that were kept, with their weights.
#[derive(Clone, Debug, PartialEq)]
pub struct KeptColumns {
    /// Weight of every column, p; zero outside `active`.
    pub coefficients: Vec<f64>,
    /// Columns that carry a weight, ascending.
    pub active: Vec<usize>,
    /// Columns asked for but left out, ascending: linearly dependent on the active ones.
    pub dependent: Vec<usize>,
    /// ‖y − Y c‖², zero or more.
    pub residual_energy: f64,
}

impl NormalEquations {
    /// Those of no rows.
    pub fn zeros(n_columns: usize, n_responses: usize) -> Self {
        let [gram, cross] = [n_columns, n_responses].map(|columns| Mat::zeros(n_columns, columns));
        Self { gram, cross, energy: vec![0.0; n_responses], rows: 0.0 }
    }

    /// Those of one response.
    ///
    /// - `gram`: YᵀY, p×p, only its lower triangle is read
    /// - `cross`: Yᵀy, p
    /// - `energy`: yᵀy
    /// - `rows`: m
    ///
    /// # Errors
    /// As [`Self::checked`].
    pub fn new(gram: Mat<f64>, cross: &[f64], energy: f64, rows: f64) -> Result<Self> {
        let cross = Mat::from_fn(cross.len(), 1, |j, _| cross[j]);
        Self { gram, cross, energy: vec![energy], rows }.checked()
    }

    /// Those of the columns Y and one response y from the sums \[Y y\]ᵀ\[Y y\], (p+1)×(p+1).
    ///
    /// # Errors
    /// As [`Self::checked`].
    pub fn of_joined(sums: &Mat<f64>, rows: f64) -> Result<Self> {
        let p = sums.ncols() - 1;
        let cross: Vec<f64> = (0..p).map(|j| sums[(j, p)]).collect();
        Self::new(sums.submatrix(0, 0, p, p).to_owned(), &cross, sums[(p, p)], rows)
    }

    /// \[Y y\]ᵀ\[Y y\] of the first response y, (p+1)×(p+1).
    pub fn joined(&self) -> Mat<f64> {
        let p = self.n_columns();
        Mat::from_fn(p + 1, p + 1, |i, j| match (i < p, j < p) {
            (true, true) => self.gram[(i, j)],
            (false, false) => self.energy[0],
            _ => self.cross[(i.min(j), 0)],
        })
    }

    /// Checks shapes and finiteness, and mirrors the lower triangle of the Gram matrix.
    ///
    /// # Errors
    /// [`SparseError::Shape`], [`SparseError::NotFinite`], or [`SparseError::Setting`] for an
    /// energy below zero or less than one row.
    pub fn checked(mut self) -> Result<Self> {
        let columns = self.n_columns();
        expect("rows of the Gram matrix", self.gram.nrows(), columns)?;
        expect("the Gram matrix's row", self.gram.ncols(), columns)?;
        let mut cross = (0..self.cross.ncols()).flat_map(|r| self.cross.col_as_slice(r));
        if let Some(entry) = cross.position(|x| !x.is_finite()) {
            return Err(SparseError::NotFinite { what: "the cross product", entry });
        }
        for &energy in &self.energy {
            require("the energy of the response", energy, energy >= 0.0, "zero or more")?;
        }
        require("the number of rows", self.rows, self.rows >= 1.0, "one or more")?;
        let Some(entry) = mirror_lower(&mut self.gram) else { return Ok(self) };
        Err(SparseError::NotFinite { what: "the Gram matrix", entry })
    }

    /// Number of columns p.
    pub fn n_columns(&self) -> usize {
        self.cross.nrows()
    }

    /// Yᵀy of the first response, p.
    pub fn right(&self) -> &[f64] {
        self.cross.col_as_slice(0)
    }

    /// Adds the rows of another, sums over them counted `weight` times.
    ///
    /// # Errors
    /// [`SparseError::Shape`] if the two were made for different designs.
    pub fn add(&mut self, other: &Self, weight: f64) -> Result<()> {
        expect("a Gram matrix", other.gram.ncols(), self.gram.ncols())?;
        expect("a cross product", other.cross.ncols(), self.cross.ncols())?;
        self.take(other, weight);
        Ok(())
    }

    fn take(&mut self, other: &Self, weight: f64) {
        for (sum, more) in [(&mut self.gram, &other.gram), (&mut self.cross, &other.cross)] {
            faer::zip!(sum, more).for_each(|faer::unzip!(sum, more)| *sum += weight * *more);
        }
        self.energy.iter_mut().zip(&other.energy).for_each(|(sum, more)| *sum += weight * more);
        self.rows += other.rows;
    }

    /// The normal equations in some of the columns.
    pub fn restricted(&self, columns: &[usize]) -> Self {
        let p = columns.len();
        let gram = Mat::from_fn(p, p, |i, j| self.gram[(columns[i], columns[j])]);
        let cross = Mat::from_fn(p, self.cross.ncols(), |i, r| self.cross[(columns[i], r)]);
        Self { gram, cross, energy: self.energy.clone(), rows: self.rows }
    }

    /// The normal equations in some of the columns for what weights of all columns leave of a
    /// response.
    pub fn left_by(&self, weights: &[f64], response: usize, columns: &[usize]) -> Self {
        let left = |j: usize, _| {
            let from = self.gram.col_as_slice(columns[j]);
            let explained: f64 = from.iter().zip(weights).map(|(g, c)| g * c).sum();
            self.cross[(columns[j], response)] - explained
        };
        let cross = Mat::from_fn(columns.len(), 1, left);
        let energy = vec![self.residual_energy(weights, response)];
        Self { cross, energy, ..self.restricted(columns) }
    }

    /// Root mean square of column `j`; zero if it is empty, or has lost more than its energy to a
    /// noise correction.
    pub(crate) fn column_scale(&self, j: usize) -> f64 {
        let scale = (self.gram[(j, j)].max(0.0) / self.rows).sqrt();
        if scale.is_normal() { scale } else { 0.0 }
    }

    /// Residual energy ‖y − Y c‖² = yᵀy − 2 cᵀYᵀy + cᵀYᵀY c of a response, at least zero.
    ///
    /// - `coefficients`: c, p; weights beyond p count for nothing, missing ones are zero
    pub fn residual_energy(&self, coefficients: &[f64], response: usize) -> f64 {
        let active = nonzero(coefficients, self.n_columns());
        let mut residual = self.energy[response];
        for &j in &active {
            let column = self.gram.col_as_slice(j);
            let fitted: f64 = active.iter().map(|&i| column[i] * coefficients[i]).sum();
            residual += coefficients[j] * (fitted - 2.0 * self.cross[(j, response)]);
        }
        residual.max(0.0)
    }

    /// Smallest residual energy of the first response that can be told from rounding, 1e-13 yᵀy.
    pub fn resolution(&self) -> f64 {
        (RESOLUTION * self.energy[0]).max(f64::MIN_POSITIVE)
    }

    /// Bayesian information criterion m ln(‖y − Y c‖²/m) + k ln m of a fit of the first response
    /// with k terms.
    ///
    /// Residuals below [`Self::resolution`] count as equal, so that among exact fits the one with
    /// the fewest terms wins.
    pub fn bic(&self, residual_energy: f64, terms: usize) -> f64 {
        let mean = residual_energy.max(self.resolution()) / self.rows;
        self.rows * mean.ln() + terms as f64 * self.rows.ln()
    }

    /// The same in columns of unit mean square, whose Gram matrix has m on its diagonal, and what
    /// they were divided by, p; zero marks a column that may never be selected.
    pub fn standardised(&self) -> (Self, Vec<f64>) {
        let scale: Vec<f64> = (0..self.n_columns()).map(|j| self.column_scale(j)).collect();
        let inverse = |s: &f64| if *s > 0.0 { s.recip() } else { 0.0 };
        let inverse: Vec<f64> = scale.iter().map(inverse).collect();
        let mut scaled = self.clone();
        for (i, own) in inverse.iter().enumerate() {
            scaled.cross.row_mut(i).iter_mut().for_each(|x| *x *= own);
            for (j, other) in inverse.iter().enumerate() {
                scaled.gram[(i, j)] = self.gram[(i, j)] * own * other;
            }
        }
        (scaled, scale)
    }

    /// Least squares of the first response on the columns `active`, min ‖y − Y c‖² with c zero
    /// elsewhere.
    ///
    /// Columns that the others explain to 1 − R² < 1e-11, and empty ones, get no weight and are
    /// reported as dependent.
    ///
    /// # Errors
    /// [`SparseError::Column`] if an active column is not below p.
    pub fn refit(&self, active: &[usize]) -> Result<KeptColumns> {
        let columns = self.n_columns();
        if let Some(&column) = active.iter().find(|&&j| j >= columns) {
            return Err(SparseError::Column { column, columns });
        }
        let Solution { values, dependent } = self.solve(active, 0.0);
        let coefficients = values.col_as_slice(0).to_vec();
        let mut active = ascending(active.to_vec());
        active.retain(|j| dependent.binary_search(j).is_err());
        let residual_energy = self.residual_energy(&coefficients, 0);
        Ok(KeptColumns { coefficients, active, dependent, residual_energy })
    }

    /// Least-squares weights of every response on all columns, p×r: one factorisation serves all.
    pub fn weights(&self) -> Mat<f64> {
        self.solve(&(0..self.n_columns()).collect::<Vec<_>>(), 0.0).values
    }

    /// Ridge regression of each response on the columns `active`, min ‖y − Y c‖² + ridge ‖c‖²: the
    /// weight of every column, p×r, and which of those asked for have none.
    pub(crate) fn solve(&self, active: &[usize], ridge: f64) -> Solution {
        let (columns, cross) = (self.n_columns(), &self.cross);
        let (used, mut dependent): (Vec<usize>, Vec<usize>) =
            ascending(active.to_vec()).into_iter().partition(|&j| self.column_scale(j) > 0.0);

        // Columns of unit length: the matrix has 1 + ridge on its diagonal.
        let length: Vec<f64> = used.iter().map(|&j| self.gram[(j, j)].sqrt()).collect();
        let inverse: Vec<f64> = length.iter().map(|l| l.recip()).collect();
        let matrix = Mat::from_fn(used.len(), used.len(), |i, j| {
            let own = ridge / length[j].powi(2);
            let shared = || self.gram[(used[i], used[j])] * inverse[i] * inverse[j];
            if i == j { 1.0 + own } else { shared() }
        });
        let right = Mat::from_fn(used.len(), cross.ncols(), |i, k| cross[(used[i], k)] / length[i]);
        let solution = cholesky::solve(matrix, right.as_ref());

        let mut values = Mat::zeros(columns, cross.ncols());
        for (i, (&j, l)) in used.iter().zip(&length).enumerate() {
            (0..cross.ncols()).for_each(|k| values[(j, k)] = solution.values[(i, k)] / l);
        }
        dependent.extend(solution.dependent.iter().map(|&i| used[i]));
        dependent.sort_unstable();
        Solution { values, dependent }
    }
}

/// The sum of normal equations that were made for one design, of which none may be another.
impl<'a> std::iter::Sum<&'a NormalEquations> for NormalEquations {
    fn sum<I: Iterator<Item = &'a Self>>(mut all: I) -> Self {
        let mut sum = all.next().cloned().unwrap_or_else(|| Self::zeros(0, 1));
        all.for_each(|own| sum.take(own, 1.0));
        sum
    }
}

/// Fails unless a scalar is finite and `valid`.
pub(crate) fn require(
    setting: &'static str,
    found: f64,
    valid: bool,
    expected: &'static str,
) -> Result<()> {
    let refused = || SparseError::Setting { setting, found, expected };
    (found.is_finite() && valid).then_some(()).ok_or_else(refused)
}

/// Indices below `columns` whose weight is not zero.
pub(crate) fn nonzero(coefficients: &[f64], columns: usize) -> Vec<usize> {
    (0..columns.min(coefficients.len())).filter(|&j| coefficients[j] != 0.0).collect()
}

/// Columns, or what else has an order, ascending, each once.
pub fn ascending<T: Ord>(mut columns: Vec<T>) -> Vec<T> {
    columns.sort_unstable();
    columns.dedup();
    columns
}

/// Copies the lower triangle to the upper one; returns an entry that is not finite, if there is one.
pub(crate) fn mirror_lower(gram: &mut Mat<f64>) -> Option<usize> {
    let columns = gram.ncols();
    let mut broken = None;
    for j in 0..columns {
        for i in j..columns {
            let value = gram[(i, j)];
            if !value.is_finite() {
                broken = broken.or(Some(i * columns + j));
            }
            gram[(j, i)] = value;
        }
    }
    broken
}
