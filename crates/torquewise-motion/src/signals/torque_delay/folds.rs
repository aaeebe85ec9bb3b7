//! From columns to held-out errors of a torque: a model is fitted without each block of time in
//! turn.

use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, MatRef, Side};
use std::ops::Range;

/// Blocks of time, each held out once.
pub(crate) const FOLDS: usize = 5;

/// A linear model with its normal equations, factored without each block.
pub(crate) struct Folds {
    columns: Mat<f64>,
    rows: [Range<usize>; FOLDS],
    factors: Vec<Llt<f64>>,
}

impl Folds {
    /// `None` if the columns cannot be told apart.
    ///
    /// - `ridge`: added to each diagonal, relative to the mean square of its column
    pub(crate) fn new(columns: &[Vec<f64>], ridge: f64) -> Option<Self> {
        let m = columns.first().map_or(0, Vec::len);
        let scales = columns.iter().map(|column| {
            let square: f64 = column.iter().map(|x| x * x).sum();
            (m as f64 / square).sqrt()
        });
        let scaled: Vec<(&Vec<f64>, f64)> =
            columns.iter().zip(scales).filter(|(_, scale)| scale.is_finite()).collect();
        let columns = Mat::from_fn(m, scaled.len(), |row, j| scaled[j].0[row] * scaled[j].1);
        let rows = std::array::from_fn(|fold| fold * m / FOLDS..(fold + 1) * m / FOLDS);
        let grams = rows.each_ref().map(|rows: &Range<usize>| {
            let block = block(columns.as_ref(), rows);
            block.transpose() * block
        });
        let mut whole: Mat<f64> =
            grams.iter().fold(Mat::zeros(columns.ncols(), columns.ncols()), |sum, gram| sum + gram);
        for j in 0..columns.ncols() {
            whole[(j, j)] += ridge * m as f64;
        }
        let factor = |gram: &Mat<f64>| (&whole - gram).llt(Side::Lower).ok();
        let factors = grams.iter().map(factor).collect::<Option<_>>()?;
        Some(Self { columns, rows, factors })
    }

    /// Mean square of what is left of each torque on each block held out, folds by joints.
    ///
    /// - `tau`: m×n
    pub(crate) fn errors(&self, tau: &Mat<f64>) -> Vec<Vec<f64>> {
        let products = self
            .rows
            .each_ref()
            .map(|rows| block(self.columns.as_ref(), rows).transpose() * block(tau.as_ref(), rows));
        let whole: Mat<f64> = products
            .iter()
            .fold(Mat::zeros(self.columns.ncols(), tau.ncols()), |sum, product| sum + product);
        let held_out = self.rows.iter().zip(&self.factors).zip(&products);
        let of_fold = held_out.map(|((rows, factor), product)| {
            let weights = factor.solve(&whole - product);
            let left = block(tau.as_ref(), rows) - block(self.columns.as_ref(), rows) * weights;
            let mean = |joint: usize| {
                let squares: f64 = left.col(joint).iter().map(|x| x * x).sum();
                squares / rows.len() as f64
            };
            (0..tau.ncols()).map(mean).collect()
        });
        of_fold.collect()
    }
}

fn block<'a>(matrix: MatRef<'a, f64>, rows: &Range<usize>) -> MatRef<'a, f64> {
    matrix.subrows(rows.start, rows.len())
}
