//! Normal equations without what noise in the rows adds to them (E7).

use crate::{Result, SparseError};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, Par, Side};

/// A corrected Gram matrix keeps at least this part of each of its directions: where noise
/// outweighs a column, a difference of two large numbers would be no information.
const LEAST_KEPT: f64 = 0.1;
/// Ridges, relative to the diagonal, below which columns count as dependent: the first that makes
/// up for the rounding of the sums.
const DEPENDENT: [f64; 3] = [1e-10, 1e-8, 1e-6];
/// A column whose squares are below this part of the largest is lost in the last place of the sums.
const LEAST_COLUMN: f64 = 1e-18;

/// YᵀY less what noise added to it (E7), kept positive semidefinite.
///
/// - `gram`, `bias`: p×p, symmetric
///
/// # Errors
/// [`SparseError::NotSolvable`] if the decomposition fails.
pub fn corrected(gram: &Mat<f64>, bias: &Mat<f64>) -> Result<Mat<f64>> {
    let p = gram.ncols();
    if bias.norm_max() == 0.0 {
        return Ok(gram.clone());
    }
    let least = LEAST_COLUMN * (0..p).fold(f64::MIN_POSITIVE, |most, j| most.max(gram[(j, j)]));
    let scale: Vec<f64> = (0..p).map(|j| gram[(j, j)].max(least).sqrt()).collect();
    let scaled = |x: &Mat<f64>, i: usize, j: usize| x[(i, j)] / (scale[i] * scale[j]);
    let ridged = |ridge: f64| {
        let entry = |i, j| scaled(gram, i, j) + if i == j { ridge } else { 0.0 };
        Mat::from_fn(p, p, entry).llt(Side::Lower).ok()
    };
    let failed = || SparseError::NotSolvable;
    let factor = DEPENDENT.into_iter().find_map(ridged).ok_or_else(failed)?;
    // L⁻¹ B L⁻ᵀ: by what part noise makes each direction larger.
    let lower = factor.L().to_owned();
    let mut part = Mat::from_fn(p, p, |i, j| scaled(bias, i, j));
    for _ in 0..2 {
        solve_lower_triangular_in_place(lower.as_ref(), part.as_mut(), Par::Seq);
        part = part.transpose().to_owned();
    }
    let part = Mat::from_fn(p, p, |i, j| 0.5 * (part[(i, j)] + part[(j, i)]));
    let eigen = part.self_adjoint_eigen(Side::Lower).map_err(|_| failed())?;
    let values = eigen.S().column_vector();
    let most = 1.0 - LEAST_KEPT;
    if values.iter().all(|&value| value <= most) {
        return Ok(gram - bias);
    }
    let basis = eigen.U();
    let kept = Mat::from_fn(p, p, |i, j| basis[(i, j)] * values[j].min(most));
    let bounded = &lower * (&kept * basis.transpose()) * lower.transpose();
    Ok(Mat::from_fn(p, p, |i, j| {
        let symmetric = 0.5 * (bounded[(i, j)] + bounded[(j, i)]);
        gram[(i, j)] - symmetric * scale[i] * scale[j]
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_that_rounding_left_indefinite_are_corrected_and_large_corrections_bounded() {
        // Two columns that are one, but for an eigenvalue of −1e-9.
        let gram = Mat::from_fn(2, 2, |i, j| if i == j { 1.0 } else { 1.0 + 1e-9 });
        let bias = Mat::from_fn(2, 2, |i, j| if i == j { 0.1 } else { 0.0 });

        let found = corrected(&gram, &bias).unwrap();

        assert!((0..2).all(|j| found[(j, j)] > 0.5 && found[(j, j)] <= 1.0), "{found:?}");
        let gram = Mat::from_fn(2, 2, |i, j| if i == j { 4.0 } else { 1.0 });
        let small = Mat::from_fn(2, 2, |i, j| if i == j { 0.4 } else { 0.0 });
        let large = Mat::from_fn(2, 2, |i, j| if (i, j) == (1, 1) { 5.0 } else { 0.0 });

        assert_eq!(corrected(&gram, &small).unwrap(), &gram - &small);
        let bounded = corrected(&gram, &large).unwrap();
        let least = bounded.self_adjoint_eigenvalues(Side::Lower).unwrap()[0];
        assert!(least > 0.0, "{least}");
    }
}
