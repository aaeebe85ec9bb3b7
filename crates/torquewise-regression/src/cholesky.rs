//! Symmetric systems solved on their independent columns: pivoted Cholesky.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt_pivoting::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::solvers::SolveCore;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Conj, Mat, MatRef, Par, Side, Spec};

/// A pivot this much below the largest one means linear dependence on the other columns.
///
/// For columns of unit length a pivot is 1 − R², R² being what the columns before it explain.
/// Duplicates leave about 1e-15 times the rounding of the Gram matrix, some 1e-13 after many rows.
const DEPENDENCE: f64 = 1e-11;

/// All pivots this far above zero mean that no column depends on the others. Without pivoting a
/// small one may hide a combination that is smaller still, so this is far from [`DEPENDENCE`].
const REGULAR: f64 = 1e-6;

/// Solution of a symmetric system, zero where a column was dropped.
pub(crate) struct Solution {
    /// p×r, one column per right-hand side.
    pub(crate) values: Mat<f64>,
    /// Columns without a pivot of their own, ascending.
    pub(crate) dependent: Vec<usize>,
}

/// Solves A x = `right` on the columns that are independent of each other.
///
/// - `matrix`: A, p×p, lower triangle read, columns of like length
/// - `right`: p×r
///
/// Where no column depends on those before it, plain Cholesky does, which is twice as fast. Else
/// the largest remaining pivot goes first, so of equal columns the first one stays. A matrix with
/// negative eigenvalues loses the columns that would need them. One thread, hence the same bits on
/// any machine load.
pub(crate) fn solve(mut matrix: Mat<f64>, right: MatRef<'_, f64>) -> Solution {
    let size = right.nrows();
    if let Ok(factor) = matrix.llt(Side::Lower) {
        let pivots = factor.L().diagonal().column_vector();
        let largest = pivots.iter().copied().fold(0.0, f64::max);
        if pivots.iter().all(|&pivot| pivot > REGULAR.sqrt() * largest) {
            let mut values = right.to_owned();
            factor.solve_in_place_with_conj(Conj::No, values.as_mut());
            return Solution { values, dependent: Vec::new() };
        }
    }
    let mut order = vec![0_usize; size];
    let mut inverse = vec![0_usize; size];
    let scratch = cholesky_in_place_scratch::<usize, f64>(size, Par::Seq, Spec::default());
    let mut memory = MemBuffer::new(scratch);
    let stack = MemStack::new(&mut memory);
    let (to, from, spec) = (&mut order, &mut inverse, Spec::default());
    let factored = cholesky_in_place(matrix.as_mut(), to, from, Par::Seq, stack, spec);
    let found = factored.map_or(0, |(rank, _)| rank.rank);
    let largest = if found > 0 { matrix[(0, 0)] } else { 0.0 };
    let floor = DEPENDENCE.sqrt() * largest;
    let rank = (0..found).position(|i| matrix[(i, i)] <= floor).unwrap_or(found);
    let factor = matrix.submatrix(0, 0, rank, rank);
    let mut x = Mat::from_fn(rank, right.ncols(), |i, k| right[(order[i], k)]);
    solve_lower_triangular_in_place(factor, x.as_mut(), Par::Seq);
    solve_upper_triangular_in_place(factor.transpose(), x.as_mut(), Par::Seq);

    let mut values = Mat::zeros(size, right.ncols());
    for (i, &column) in order[..rank].iter().enumerate() {
        values.row_mut(column).copy_from(x.row(i));
    }
    let mut dependent = order.split_off(rank);
    dependent.sort_unstable();
    Solution { values, dependent }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rank_is_found_beyond_one_block_of_the_factorisation() {
        let (rank, size) = (150, 300);
        let wave = |i: usize, k: usize| (0.7 * (i * (k + 1)) as f64 + (k * k) as f64).sin();
        let spread = Mat::from_fn(size, rank, wave);
        let matrix = &spread * spread.transpose();

        let solution = solve(matrix, Mat::full(size, 1, 1.0).as_ref());

        assert_eq!(solution.dependent.len(), size - rank);
    }
}
