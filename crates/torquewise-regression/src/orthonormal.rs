//! From columns to an orthonormal basis of what they span.

use crate::cholesky::{Pivoted, pivoted, regular_factor};
use crate::products::add_gram;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, Par};

/// Columns of unit length that are perpendicular to each other and span what `columns` do, N×g with
/// g their rank.
///
/// Twice over the Cholesky factor of their Gram matrix: what rounding leaves of the angles the
/// first time is gone the second time. A column that differs from all before it by less than
/// about 3e-6 of its length is taken to say the same.
///
/// Source: T. Fukaya, Y. Nakatsukasa, Y. Yanagisawa, Y. Yamamoto, CholeskyQR2, ScalA (2014).
pub(crate) fn orthonormal(mut columns: Mat<f64>) -> Mat<f64> {
    let lengths: Vec<f64> = (0..columns.ncols()).map(|j| columns.col(j).norm_l2()).collect();
    let kept: Vec<usize> = (0..lengths.len()).filter(|&j| lengths[j] > 0.0).collect();
    for &j in &kept {
        columns.col_as_slice_mut(j).iter_mut().for_each(|x| *x /= lengths[j]);
    }
    let unit = gathered(&columns, &kept);
    let Pivoted { factor, order } = pivoted(gram(&unit));
    let mut basis = gathered(&unit, &order[..factor.nrows()]);
    drop((columns, unit));
    divide(&mut basis, &factor);
    if let Some(factor) = regular_factor(gram(&basis)) {
        divide(&mut basis, &factor);
    }
    basis
}

/// XᵀX, lower triangle.
fn gram(columns: &Mat<f64>) -> Mat<f64> {
    let size = columns.ncols();
    let mut gram = Mat::zeros(size, size);
    add_gram(&mut gram, columns.as_ref(), 1.0);
    gram
}

/// X ← X L⁻ᵀ
fn divide(columns: &mut Mat<f64>, factor: &Mat<f64>) {
    solve_lower_triangular_in_place(factor.as_ref(), columns.transpose_mut(), Par::Seq);
}

fn gathered(columns: &Mat<f64>, places: &[usize]) -> Mat<f64> {
    Mat::from_fn(columns.nrows(), places.len(), |row, j| columns[(row, places[j])])
}

#[cfg(test)]
mod tests {
    use super::orthonormal;
    use crate::products::product;
    use faer::Mat;

    /// Eight columns of which the last two are sums of others, of very different lengths.
    fn columns() -> Mat<f64> {
        let wave = |i: usize, k: usize| (0.7 * (i * (k + 1)) as f64 + (k * k) as f64).sin();
        Mat::from_fn(200, 8, |i, j| match j {
            6 => wave(i, 0) - 3.0 * wave(i, 1),
            7 => 1e4 * (wave(i, 2) + wave(i, 5)),
            _ => 10_f64.powf(j as f64 - 3.0) * wave(i, j),
        })
    }

    #[test]
    fn the_basis_is_orthonormal_and_of_the_rank() {
        let basis = orthonormal(columns());

        assert_eq!(basis.ncols(), 6);
        let gram = product(basis.transpose(), basis.as_ref());
        for i in 0..6 {
            for j in 0..6 {
                let expected = f64::from(u8::from(i == j));
                assert!((gram[(i, j)] - expected).abs() < 1e-14, "{i} {j}: {}", gram[(i, j)]);
            }
        }
    }

    #[test]
    fn every_column_lies_in_the_span() {
        let columns = columns();

        let basis = orthonormal(columns.clone());

        let left = &columns - &basis * product(basis.transpose(), columns.as_ref());
        for j in 0..8 {
            let (left, length) = (left.col(j).norm_l2(), columns.col(j).norm_l2());
            assert!(left < 1e-12 * length, "{j}: {left}");
        }
    }

    #[test]
    fn columns_of_zeros_span_nothing() {
        assert_eq!(orthonormal(Mat::zeros(5, 3)).ncols(), 0);
    }
}
