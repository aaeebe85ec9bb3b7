//! Products and Gram matrices, in an order that no number of threads changes.

use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, ColRef, Mat, MatRef, Par};

/// A B
pub fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let mut out = Mat::zeros(a.nrows(), b.ncols());
    matmul(out.as_mut(), Accum::Replace, a, b, 1.0, Par::Seq);
    out
}

/// Some rows and columns of a matrix, in that order.
///
/// # Panics
/// If there is no such row or column.
pub fn picked(
    of: &Mat<f64>,
    rows: &[usize],
    columns: impl ExactSizeIterator<Item = usize>,
) -> Mat<f64> {
    let mut picked = Mat::zeros(rows.len(), columns.len());
    for (l, column) in columns.enumerate() {
        let from = of.col_as_slice(column);
        let own = picked.col_as_slice_mut(l).iter_mut().zip(rows);
        own.for_each(|(x, &row)| *x = from[row]);
    }
    picked
}

pub(crate) fn add_product(target: &mut Mat<f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    matmul(target.as_mut(), Accum::Add, a.transpose(), b, 1.0, Par::Seq);
}

/// Adds weight · XᵀX to the lower triangle of `target`.
pub fn add_gram(target: &mut Mat<f64>, rows: MatRef<'_, f64>, weight: f64) {
    triangular::matmul(
        target.as_mut(),
        BlockStructure::TriangularLower,
        Accum::Add,
        rows.transpose(),
        BlockStructure::Rectangular,
        rows,
        BlockStructure::Rectangular,
        weight,
        Par::Seq,
    );
}

/// [`add_gram`] for the rows of several equations, all instants of one after those of the one
/// before, many of whose columns are zero; only columns that hold something are multiplied.
pub fn add_gram_of_equations(
    target: &mut Mat<f64>,
    rows: MatRef<'_, f64>,
    equations: usize,
    weight: f64,
) {
    let m = rows.nrows() / equations.max(1);
    for equation in 0..equations {
        let part = rows.subrows(equation * m, m);
        // Sixteen numbers at a time, which a processor compares at once.
        let holds = |x: &[f64]| x.iter().map(|x| u32::from(*x != 0.0)).sum::<u32>() > 0;
        let column = |j: usize| part.col(j).try_as_col_major().map(ColRef::as_slice);
        let is_used = |&j: &usize| column(j).is_none_or(|column| column.chunks(16).any(holds));
        let used: Vec<usize> = (0..rows.ncols()).filter(is_used).collect();
        let mut dense = Mat::zeros(m, used.len());
        for (j, &column) in used.iter().enumerate() {
            dense.col_mut(j).copy_from(part.col(column));
        }
        add_gram_at(target, &used, dense.as_ref(), weight);
    }
}

/// [`add_gram`] for rows that hold some columns alone, where these are in `target`, ascending.
pub fn add_gram_at(target: &mut Mat<f64>, places: &[usize], rows: MatRef<'_, f64>, weight: f64) {
    let mut gram = Mat::zeros(places.len(), places.len());
    add_gram(&mut gram, rows, weight);
    for (j, &column) in places.iter().enumerate() {
        for (i, &row) in places.iter().enumerate().skip(j) {
            target[(row, column)] += gram[(i, j)];
        }
    }
}
