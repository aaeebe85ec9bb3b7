//! Normal equations of one response, and their refit.

use crate::cholesky;
use crate::error::SparseError;
use faer::{Mat, MatRef};
use rayon::prelude::*;

/// Relative residual energy that rounding alone leaves in normal equations.
///
/// Sums over rows keep about 13 digits, so a residual below 3e-7 of the response is not resolved.
const RESOLUTION: f64 = 1e-13;

/// Normal equations of one response: everything least squares can know of y ≈ X c.
///
/// With X m×p and y of m rows: XᵀX, Xᵀy, yᵀy and m. All are finite and the Gram matrix is
/// symmetric. It may be slightly indefinite, as it is after a noise correction.
#[derive(Clone, Debug)]
pub struct Problem {
    gram: Mat<f64>,
    cross: Vec<f64>,
    energy: f64,
    rows: f64,
}

/// A problem whose columns have unit mean square, and what they were divided by.
#[derive(Clone, Debug)]
pub struct Standardised {
    /// The problem in the scaled columns; its Gram matrix has m on the diagonal.
    pub problem: Problem,
    /// Root mean square of each column, p; zero marks a column that may never be selected.
    pub scale: Vec<f64>,
}

/// Least squares on some of the columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Refit {
    /// Weight of every column, p; zero outside `active`.
    pub coefficients: Vec<f64>,
    /// Columns that carry a weight, ascending.
    pub active: Vec<usize>,
    /// Columns asked for but left out, ascending: the active ones say the same.
    pub dependent: Vec<usize>,
    /// ‖y − X c‖², zero or more.
    pub residual_energy: f64,
}

/// Least squares of several responses on some of the columns.
pub(crate) struct Solved {
    /// Weight of every column, p×r.
    pub(crate) weights: Mat<f64>,
    /// Columns asked for, ascending.
    wanted: Vec<usize>,
    /// Those of them without a weight, ascending.
    pub(crate) dependent: Vec<usize>,
}

/// What is added to the diagonal of XᵀX.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Ridge {
    /// As a part of each entry.
    pub(crate) part: f64,
    /// The same for all.
    pub(crate) plain: f64,
}

/// The columns a selector kept.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// Weight of every column, p; zero outside `active`.
    pub coefficients: Vec<f64>,
    /// Columns that carry a weight, ascending.
    pub active: Vec<usize>,
    /// Columns left out because the others say the same, ascending.
    pub dependent: Vec<usize>,
    /// Upper bound on how far the selector's objective is from its optimum, where it has one.
    pub certificate: Option<f64>,
}

impl Problem {
    /// Checks shapes and finiteness, and mirrors the lower triangle of the Gram matrix.
    ///
    /// - `gram`: XᵀX, p×p, only its lower triangle is read
    /// - `cross`: Xᵀy, p
    /// - `energy`: yᵀy, zero or more
    /// - `rows`: m, one or more; no integer where rows were weighted
    ///
    /// # Errors
    /// [`SparseError::Shape`], [`SparseError::NotFinite`], or [`SparseError::Setting`] for an
    /// energy or a number of rows out of range.
    pub fn new(
        mut gram: Mat<f64>,
        cross: Vec<f64>,
        energy: f64,
        rows: f64,
    ) -> Result<Self, SparseError> {
        let columns = cross.len();
        for (what, found) in
            [("rows of the Gram matrix", gram.nrows()), ("the Gram matrix's row", gram.ncols())]
        {
            if found != columns {
                return Err(SparseError::Shape { what, found, expected: columns });
            }
        }
        if let Some(entry) = cross.iter().position(|x| !x.is_finite()) {
            return Err(SparseError::NotFinite { what: "the cross product", entry });
        }
        require("the energy of the response", energy, energy >= 0.0, "zero or more")?;
        require("the number of rows", rows, rows >= 1.0, "one or more")?;
        mirror_lower(&mut gram)?;
        Ok(Self { gram, cross, energy, rows })
    }

    /// Number of columns p.
    pub fn n_columns(&self) -> usize {
        self.cross.len()
    }

    /// XᵀX, p×p, symmetric.
    pub fn gram(&self) -> MatRef<'_, f64> {
        self.gram.as_ref()
    }

    /// Column `j` of XᵀX, p.
    pub(crate) fn gram_column(&self, j: usize) -> &[f64] {
        self.gram.col_as_slice(j)
    }

    /// Xᵀy, p.
    pub fn cross(&self) -> &[f64] {
        &self.cross
    }

    /// yᵀy.
    pub fn energy(&self) -> f64 {
        self.energy
    }

    /// Number of rows m.
    pub fn rows(&self) -> f64 {
        self.rows
    }

    /// Root mean square of column `j`; zero if it is empty, or has lost more than its energy to a
    /// noise correction.
    pub(crate) fn column_scale(&self, j: usize) -> f64 {
        let scale = (self.gram[(j, j)].max(0.0) / self.rows).sqrt();
        if scale.is_normal() { scale } else { 0.0 }
    }

    /// Residual energy ‖y − X c‖² = yᵀy − 2 cᵀXᵀy + cᵀXᵀX c, at least zero.
    ///
    /// - `coefficients`: c, p; weights beyond p count for nothing, missing ones are zero
    pub fn residual_energy(&self, coefficients: &[f64]) -> f64 {
        let active = nonzero(coefficients, self.n_columns());
        let mut residual = self.energy;
        for &j in &active {
            let column = self.gram_column(j);
            let fitted: f64 = active.iter().map(|&i| column[i] * coefficients[i]).sum();
            residual += coefficients[j] * (fitted - 2.0 * self.cross[j]);
        }
        residual.max(0.0)
    }

    /// Smallest residual energy that can be told from rounding, 1e-13 yᵀy.
    pub fn resolution(&self) -> f64 {
        (RESOLUTION * self.energy).max(f64::MIN_POSITIVE)
    }

    /// Bayesian information criterion m ln(‖y − X c‖²/m) + k ln m of a fit with k terms.
    ///
    /// Residuals below [`Problem::resolution`] count as equal, so that among exact fits the one
    /// with the fewest terms wins.
    pub fn bic(&self, residual_energy: f64, terms: usize) -> f64 {
        let mean = residual_energy.max(self.resolution()) / self.rows;
        self.rows * mean.ln() + terms as f64 * self.rows.ln()
    }

    /// The same problem in columns of unit mean square.
    pub fn standardised(&self) -> Standardised {
        let scale: Vec<f64> = (0..self.n_columns()).map(|j| self.column_scale(j)).collect();
        self.scaled_by(scale)
    }

    /// The same problem in columns divided by `scale`; those with scale zero become empty.
    pub(crate) fn scaled_by(&self, scale: Vec<f64>) -> Standardised {
        let columns = self.n_columns();
        let inverse: Vec<f64> =
            scale.iter().map(|&s| if s > 0.0 { s.recip() } else { 0.0 }).collect();
        let gram =
            Mat::from_fn(columns, columns, |i, j| self.gram[(i, j)] * inverse[i] * inverse[j]);
        let cross = self.cross.iter().zip(&inverse).map(|(b, s)| b * s).collect();
        let problem = Self { gram, cross, energy: self.energy, rows: self.rows };
        Standardised { problem, scale }
    }

    /// Least squares on the columns `active`, min ‖y − X c‖² with c zero elsewhere.
    ///
    /// Columns that the others explain to 1 − R² < 1e-11, and empty ones, get no weight and are
    /// reported as dependent.
    ///
    /// # Errors
    /// [`SparseError::Column`] if an active column is not below p.
    pub fn refit(&self, active: &[usize]) -> Result<Refit, SparseError> {
        let cross = MatRef::from_column_major_slice(&self.cross, self.n_columns(), 1);
        let Solved { weights, wanted, dependent } = self.solve(active, cross, Ridge::default())?;
        let coefficients = weights.col_as_slice(0).to_vec();
        let active = wanted.into_iter().filter(|j| dependent.binary_search(j).is_err()).collect();
        let residual_energy = self.residual_energy(&coefficients);
        Ok(Refit { coefficients, active, dependent, residual_energy })
    }

    /// Least squares on the columns `active` for other responses of the same rows, p×r: one
    /// factorisation serves them all.
    ///
    /// - `cross`: Xᵀ of the responses, p×r
    ///
    /// # Errors
    /// [`SparseError::Column`] if an active column is not below p, [`SparseError::Shape`] if
    /// `cross` does not have p rows.
    pub fn refit_each(
        &self,
        active: &[usize],
        cross: MatRef<'_, f64>,
    ) -> Result<Mat<f64>, SparseError> {
        let (found, expected) = (cross.nrows(), self.n_columns());
        if found != expected {
            return Err(SparseError::Shape { what: "the cross products", found, expected });
        }
        Ok(self.solve(active, cross, Ridge::default())?.weights)
    }

    /// Ridge regression on the columns `active`, min ‖y − X c‖² + Σ (part·Gⱼⱼ + plain) cⱼ², for
    /// several responses.
    pub(crate) fn solve(
        &self,
        active: &[usize],
        cross: MatRef<'_, f64>,
        ridge: Ridge,
    ) -> Result<Solved, SparseError> {
        let columns = self.n_columns();
        if let Some(&column) = active.iter().find(|&&j| j >= columns) {
            return Err(SparseError::Column { column, columns });
        }
        let mut wanted = active.to_vec();
        wanted.sort_unstable();
        wanted.dedup();
        let (used, mut dependent): (Vec<usize>, Vec<usize>) =
            wanted.iter().partition(|&&j| self.column_scale(j) > 0.0);

        // Columns of unit length: the matrix has 1 + ridge on its diagonal.
        let length: Vec<f64> = used.iter().map(|&j| self.gram[(j, j)].sqrt()).collect();
        let matrix = || self.correlations(&used, &length, ridge);
        let right = Mat::from_fn(used.len(), cross.ncols(), |i, k| cross[(used[i], k)] / length[i]);
        let solution = cholesky::solve(matrix, right.as_ref());

        let mut weights = Mat::zeros(columns, cross.ncols());
        for (i, (&j, l)) in used.iter().zip(&length).enumerate() {
            for k in 0..cross.ncols() {
                weights[(j, k)] = solution.values[(i, k)] / l;
            }
        }
        dependent.extend(solution.dependent.iter().map(|&i| used[i]));
        dependent.sort_unstable();
        Ok(Solved { weights, wanted, dependent })
    }

    /// Lower triangle of the Gram matrix of some columns, each divided by its length, with ridge.
    fn correlations(&self, used: &[usize], length: &[f64], ridge: Ridge) -> Mat<f64> {
        let inverse: Vec<f64> = length.iter().map(|l| l.recip()).collect();
        let mut out = Mat::zeros(used.len(), used.len());
        let columns: Vec<_> = out.col_iter_mut().collect();
        columns.into_par_iter().enumerate().for_each(|(j, out)| {
            let Some(out) = out.try_as_col_major_mut() else { return };
            let (from, out) = (self.gram_column(used[j]), &mut out.as_slice_mut()[j..]);
            for (out, (&row, own)) in out.iter_mut().zip(used[j..].iter().zip(&inverse[j..])) {
                *out = from[row] * own * inverse[j];
            }
            out[0] = 1.0 + ridge.part + ridge.plain / length[j].powi(2);
        });
        out
    }
}

impl Standardised {
    /// Weights of the original columns: each divided by its column's scale, p.
    ///
    /// - `coefficients`: weights of the standardised columns, p
    pub fn unscaled(&self, coefficients: &[f64]) -> Vec<f64> {
        let divide = |(c, s): (&f64, &f64)| if *s > 0.0 { c / s } else { 0.0 };
        coefficients.iter().zip(&self.scale).map(divide).collect()
    }
}

impl Refit {
    /// The selection that keeps these columns.
    pub fn into_selection(self, certificate: Option<f64>) -> Selection {
        let Self { coefficients, active, dependent, .. } = self;
        Selection { coefficients, active, dependent, certificate }
    }
}

/// Fails unless a scalar is finite and `valid`.
pub(crate) fn require(
    setting: &'static str,
    found: f64,
    valid: bool,
    expected: &'static str,
) -> Result<(), SparseError> {
    if found.is_finite() && valid {
        Ok(())
    } else {
        Err(SparseError::Setting { setting, found, expected })
    }
}

/// Indices below `columns` whose weight is not zero.
pub(crate) fn nonzero(coefficients: &[f64], columns: usize) -> Vec<usize> {
    (0..columns.min(coefficients.len())).filter(|&j| coefficients[j] != 0.0).collect()
}

/// Copies the lower triangle to the upper one, tile by tile to stay in cache.
fn mirror_lower(gram: &mut Mat<f64>) -> Result<(), SparseError> {
    const TILE: usize = 32;
    let columns = gram.ncols();
    for first_column in (0..columns).step_by(TILE) {
        let columns_end = columns.min(first_column + TILE);
        for first_row in (first_column..columns).step_by(TILE) {
            for j in first_column..columns_end {
                for i in first_row.max(j)..columns.min(first_row + TILE) {
                    let value = gram[(i, j)];
                    if !value.is_finite() {
                        let entry = i * columns + j;
                        return Err(SparseError::NotFinite { what: "the Gram matrix", entry });
                    }
                    gram[(j, i)] = value;
                }
            }
        }
    }
    Ok(())
}
