//! Derivatives of q(t) by local polynomial least squares, on any time stamps.

use crate::{MotionError, Result};
use faer::{Mat, MatRef};

/// Rows on each side of a row that the polynomial around it is fitted to by [`derivative`].
pub const HALF_WINDOW: usize = 10;

/// On 21 rows: at 100 Hz, q̈ of a 1 Hz sine is right to 1 %.
const DEGREE: usize = 4;

/// Derivative of each column of `x` with respect to `t`: the one of the polynomial of degree four and
/// of least squares around each row. On even time stamps this is the Savitzky–Golay filter.
///
/// A row depends on the rows of its window alone, and the window looks both ways, so there is no
/// phase shift and a long signal may be worked through in overlapping parts.
///
/// - `t`: time stamps \[s\], m, strictly increasing
/// - `x`: signals, m×n
/// - `order`: 0 smooths, 1 gives ẋ, 2 gives ẍ
/// - returns: the derivatives, m×n, in the unit of `x` per s^`order`
///
/// Source: A. Savitzky, M. Golay, Anal. Chem. 36 (1964); the basis of polynomials orthogonal on
/// the window is that of G. Forsythe, J. SIAM 5 (1957). Checked against: exact polynomials.
///
/// # Errors
/// [`MotionError::Shape`], [`MotionError::NotFinite`], [`MotionError::TimeOrder`],
/// [`MotionError::TooFewRows`].
pub fn derivative(t: &[f64], x: MatRef<'_, f64>, order: usize) -> Result<Mat<f64>> {
    derivative_by((HALF_WINDOW, DEGREE), t, x, order)
}

/// The same by another polynomial: rows to each side that it is fitted to, and its degree.
///
/// Near an end the window of a row keeps its number of rows and moves inwards, so that the ends are
/// fitted as well as the middle and never padded.
fn derivative_by(
    (half_window, degree): (usize, usize),
    t: &[f64],
    x: MatRef<'_, f64>,
    order: usize,
) -> Result<Mat<f64>> {
    check(t, x, degree)?;
    let mut derived = Mat::zeros(x.nrows(), x.ncols());
    let width = (2 * half_window + 1).min(t.len());
    for row in 0..t.len() {
        let start = row.saturating_sub(half_window).min(t.len() - width);
        let window = start..start + width;
        let weights = stencil(&t[window.clone()], t[row], degree, order);
        for column in 0..x.ncols() {
            // Weights of a derivative sum to zero: relative to the middle, rounding is smaller.
            let middle = x[(row, column)];
            let weighted = weights.iter().zip(window.clone());
            let sum: f64 = weighted.map(|(w, k)| w * (x[(k, column)] - middle)).sum();
            derived[(row, column)] = if order == 0 { middle + sum } else { sum };
        }
    }
    Ok(derived)
}

fn check(t: &[f64], x: MatRef<'_, f64>, degree: usize) -> Result<()> {
    let (rows, columns) = (x.nrows(), x.ncols());
    MotionError::check_shape("x", x, [t.len(), columns])?;
    if rows <= degree {
        return Err(MotionError::TooFewRows { rows, needed: degree + 1 });
    }
    MotionError::check_finite("t", 0, t)?;
    MotionError::check_order(t)?;
    MotionError::check_all_finite("x", x)
}

/// Weights w with x⁽ʳ⁾(at) ≈ Σ wₖ xₖ for the rows of one window, r the order:
/// w = Σₖ Pₖ⁽ʳ⁾(at) Pₖ / ‖Pₖ‖² with the polynomials that are orthogonal on the window,
/// Pₖ₊₁ = (u − aₖ) Pₖ − bₖ Pₖ₋₁ from P₀ = 1 on.
pub(crate) fn stencil(t: &[f64], at: f64, degree: usize, order: usize) -> Vec<f64> {
    let half_width = 0.5 * (t[t.len() - 1] - t[0]);
    let u: Vec<f64> = t.iter().map(|t| (t - at) / half_width).collect();
    let mut weights = vec![0.0; t.len()];
    // Pₖ₋₁ and Pₖ on the window, and their derivatives at `at`.
    let (mut previous, mut current) = (vec![0.0; t.len()], vec![1.0; t.len()]);
    let (mut slopes_previous, mut slopes) = (vec![0.0; order + 1], vec![0.0; order + 1]);
    slopes[0] = 1.0;
    let mut norm_previous = f64::INFINITY;
    for k in 0..=degree {
        let norm: f64 = current.iter().map(|p| p * p).sum();
        let gain = slopes[order] / norm;
        weights.iter_mut().zip(&current).for_each(|(weight, p)| *weight += gain * p);
        if k == degree {
            break;
        }
        let moment: f64 = u.iter().zip(&current).map(|(u, p)| u * p * p).sum();
        let (a, b) = (moment / norm, norm / norm_previous);
        norm_previous = norm;
        for ((previous, current), u) in previous.iter_mut().zip(&current).zip(&u) {
            *previous = (u - a) * current - b * *previous;
        }
        for r in 0..=order {
            let inner = if r == 0 { 0.0 } else { r as f64 * slopes[r - 1] };
            slopes_previous[r] = inner - a * slopes[r] - b * slopes_previous[r];
        }
        std::mem::swap(&mut previous, &mut current);
        std::mem::swap(&mut slopes_previous, &mut slopes);
    }
    let per_unit = (0..order).fold(1.0, |product, _| product / half_width);
    weights.iter().map(|weight| weight * per_unit).collect()
}

#[cfg(test)]
mod tests;
