//! R factor of rows: [X y] = QR without Q, block by block, never squaring the condition (E6).

use crate::error::SparseError;
use faer::{Mat, MatRef};

/// The R factor of the rows seen so far; stacking two and factoring again merges them.
///
/// Rows wait until there are twice as many as columns: R is factored again with each batch, so that
/// small batches would mostly factor R.
#[derive(Clone, Debug)]
pub struct Triangle {
    r: Mat<f64>,
    waiting: Vec<Mat<f64>>,
    rows: usize,
}

/// Rows wait for this many at least.
const WORTH_FACTORING: usize = 256;

impl Triangle {
    /// The factor of no rows, for k columns.
    pub fn new(n_columns: usize) -> Self {
        Self { r: Mat::zeros(n_columns, n_columns), waiting: Vec::new(), rows: 0 }
    }

    /// R, k×k, upper triangular.
    pub fn r(&self) -> Mat<f64> {
        if self.waiting.is_empty() { self.r.clone() } else { upper_factor(&self.stacked()) }
    }

    /// Rows seen.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Adds rows, m×k.
    ///
    /// # Errors
    /// [`SparseError::Shape`] if the rows have another number of columns.
    pub fn add(&mut self, rows: MatRef<'_, f64>) -> Result<(), SparseError> {
        let k = self.r.ncols();
        if rows.ncols() != k {
            let found = rows.ncols();
            return Err(SparseError::Shape { what: "rows for a triangle", found, expected: k });
        }
        self.waiting.push(rows.to_owned());
        let waiting: usize = self.waiting.iter().map(Mat::nrows).sum();
        if waiting >= (2 * k).max(WORTH_FACTORING) {
            self.r = upper_factor(&self.stacked());
            self.waiting.clear();
        }
        self.rows += rows.nrows();
        Ok(())
    }

    /// Adds the rows another has seen.
    ///
    /// # Errors
    /// [`SparseError::Shape`] if the other has another number of columns.
    pub fn merge(&mut self, other: &Self) -> Result<(), SparseError> {
        let rows = self.rows + other.rows;
        self.add(other.r().as_ref())?;
        self.rows = rows;
        Ok(())
    }

    /// R with the waiting rows below it.
    fn stacked(&self) -> Mat<f64> {
        let k = self.r.ncols();
        let waiting: usize = self.waiting.iter().map(Mat::nrows).sum();
        let mut stacked = Mat::zeros(k + waiting, k);
        stacked.subrows_mut(0, k).copy_from(&self.r);
        let mut next = k;
        for rows in &self.waiting {
            stacked.subrows_mut(next, rows.nrows()).copy_from(rows);
            next += rows.nrows();
        }
        stacked
    }
}

/// R of a tall matrix by Householder reflections.
fn upper_factor(stacked: &Mat<f64>) -> Mat<f64> {
    stacked.qr().R().to_owned()
}
