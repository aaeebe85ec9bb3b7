//! The information in rows: their Gram matrix, what more rows would add, how well it is conditioned.

use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, MatRef, Par, Side};
use torquewise_regression::products::add_gram;

/// Σ aᵀa over rows a, plus a small multiple of one, and its factor. One thread, so that the same
/// rows give the same bits.
#[derive(Clone, Debug)]
pub(crate) struct Information {
    /// Lower triangle, p×p.
    gram: Mat<f64>,
    /// L of L Lᵀ, lower triangle.
    factor: Mat<f64>,
}

/// An eigenvalue this much below the largest says nothing but roundings.
const ROUNDINGS: f64 = 1e-15;

impl Information {
    /// Some rows known, and that no column is worth less than `ridge`.
    pub(crate) fn new(columns: usize, ridge: f64, known: &[Mat<f64>]) -> Self {
        let mut gram = faer::Scale(ridge) * Mat::<f64>::identity(columns, columns);
        for rows in known {
            add_gram(&mut gram, rows.as_ref(), 1.0);
        }
        let factor = factor(&gram);
        Self { gram, factor }
    }

    /// Adds rows, `sign` 1, or takes rows that were added away, `sign` −1.
    pub(crate) fn add(&mut self, rows: MatRef<'_, f64>, sign: f64) {
        add_gram(&mut self.gram, rows, sign);
        self.factor = factor(&self.gram);
    }

    /// log det(G + Σ aᵀa) − log det G for some rows a.
    pub(crate) fn gain(&self, rows: MatRef<'_, f64>) -> f64 {
        let (k, p) = (rows.nrows(), rows.ncols());
        if k >= p {
            let mut gram = self.gram.clone();
            add_gram(&mut gram, rows, 1.0);
            return log_det(&factor(&gram)) - log_det(&self.factor);
        }
        // The same as det(I + A G⁻¹ Aᵀ), which is smaller.
        let mut white = rows.transpose().to_owned();
        solve_lower_triangular_in_place(self.factor.as_ref(), white.as_mut(), Par::Seq);
        let mut small = Mat::identity(k, k);
        add_gram(&mut small, white.as_ref(), 1.0);
        log_det(&factor(&small))
    }
}

/// How well the coefficients of a library can be told from each other.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct DesignCriterion {
    /// Columns judged: energies, offsets, friction.
    pub columns: usize,
    /// Condition number of the columns, each of size one over the limits; infinite if some depend on
    /// others.
    pub condition: f64,
    /// Geometric mean of the eigenvalues of the information per second, columns being of size one
    /// over the limits; zero if some depend on others. D-optimality is to make this large.
    pub information: f64,
}

impl DesignCriterion {
    /// Of rows weighted by the root of the seconds they stand for.
    pub(crate) fn of(rows: MatRef<'_, f64>, seconds: f64) -> Self {
        let p = rows.ncols();
        let mut gram = Mat::zeros(p, p);
        add_gram(&mut gram, rows, 1.0 / seconds);
        let is_finite = (0..p).all(|j| (j..p).all(|i| gram[(i, j)].is_finite()));
        let found = is_finite.then(|| gram.self_adjoint_eigenvalues(Side::Lower).ok()).flatten();
        let mut eigenvalues = found.unwrap_or_default();
        eigenvalues.sort_by(f64::total_cmp);
        let (condition, information) = match (eigenvalues.first(), eigenvalues.last()) {
            (Some(least), Some(most)) if *least > ROUNDINGS * p as f64 * most => {
                let logarithms = eigenvalues.iter().map(|x| x.ln());
                ((most / least).sqrt(), (logarithms.sum::<f64>() / p as f64).exp())
            }
            _ => (f64::INFINITY, 0.0),
        };
        Self { columns: p, condition, information }
    }
}

/// L of a positive definite matrix; not a number on the diagonal if it is none.
fn factor(matrix: &Mat<f64>) -> Mat<f64> {
    let none = |_| Mat::from_fn(matrix.nrows(), matrix.ncols(), |_, _| f64::NAN);
    matrix.llt(Side::Lower).map_or_else(none, |factored| factored.L().to_owned())
}

fn log_det(factor: &Mat<f64>) -> f64 {
    (0..factor.nrows()).map(|j| 2.0 * factor[(j, j)].ln()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Numbers without order, of size one.
    fn rows(k: usize, p: usize, phase: f64) -> Mat<f64> {
        Mat::from_fn(k, p, |i, j| (phase + 1.3 * (i * p + j) as f64 + (j * j) as f64).sin())
    }

    #[test]
    fn the_gain_is_what_adding_the_rows_brings_and_taking_them_away_leaves_what_was_there() {
        for k in [2, 9] {
            let mut information = Information::new(5, 1e-3, &[]);
            information.add(rows(7, 5, 0.1).as_ref(), 1.0);
            let before = log_det(&information.factor);
            let more = rows(k, 5, 0.7);

            let gain = information.gain(more.as_ref());
            information.add(more.as_ref(), 1.0);
            assert_relative_eq!(gain, log_det(&information.factor) - before, epsilon = 1e-10);

            information.add(more.as_ref(), -1.0);
            assert_relative_eq!(log_det(&information.factor), before, epsilon = 1e-10);
        }
    }

    #[test]
    fn the_condition_counts_columns_that_hardly_move_and_dependent_ones_have_none() {
        // Columns of lengths 1 and 10 at 60 degrees: eigenvalues (101 ± √(99² + 10²))/2 of YᵀY.
        let rows = faer::mat![[1.0, 5.0], [0.0, 5.0 * 3.0_f64.sqrt()]];

        let found = DesignCriterion::of(rows.as_ref(), 2.0);

        let root = 9_901.0_f64.sqrt();
        let expected = ((101.0 + root) / (101.0 - root)).sqrt();
        assert_relative_eq!(found.condition, expected, max_relative = 1e-12);
        // det(YᵀY) = 1·100·(1 − 1/4), per second a quarter of it.
        let geometric_mean = (75.0_f64 / 4.0).sqrt();
        assert_relative_eq!(found.information, geometric_mean, max_relative = 1e-12);
        let twice = faer::mat![[1.0, 2.0], [3.0, 6.0], [-1.0, -2.0]];
        let empty = faer::mat![[1.0, 0.0], [3.0, 0.0]];

        for rows in [twice, empty] {
            let found = DesignCriterion::of(rows.as_ref(), 1.0);
            assert!(found.condition.is_infinite() && found.information <= 0.0, "{found:?}");
        }
    }
}
