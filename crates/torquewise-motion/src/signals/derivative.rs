//! Derivatives q̇, q̈ of evenly sampled, filtered q, without delay.

use crate::differentiate::stencil;
use crate::{MotionError, Result};
use faer::{Mat, MatRef};

/// Degree of the polynomial, on as many rows and one: it passes through all of them, so it
/// smooths nothing, which is the filter's part.
const DEGREE: usize = 6;

/// Rows that a derivative looks at on each side.
pub(crate) const REACH: usize = DEGREE / 2;

/// Derivative of each column, the central difference of order six.
///
/// Up to a fortieth of the rate, that is, a fifth of a cut-off at an eighth of it, the first and
/// second derivative of a sine are right to 1e-6, and at a tenth of the rate to 5e-4.
///
/// - `x`: m×n, at `rate` \[Hz\]
/// - `order`: 1 or 2
/// - returns: m×n, per s^`order`
pub(crate) fn even_derivative(x: MatRef<'_, f64>, rate: f64, order: usize) -> Result<Mat<f64>> {
    if x.nrows() <= DEGREE {
        return Err(MotionError::TooFewRows { rows: x.nrows(), needed: DEGREE + 1 });
    }
    // One stencil per place in the window, on exact time steps: the same bits for any part.
    let steps: Vec<f64> = (0..=DEGREE).map(|k| k as f64 - REACH as f64).collect();
    let stencils: Vec<Vec<f64>> =
        steps.iter().map(|&at| stencil(&steps, at, DEGREE, order)).collect();
    let scale = (0..order).fold(1.0, |scale, _| scale * rate);
    Ok(Mat::from_fn(x.nrows(), x.ncols(), |row, column| {
        let begin = row.saturating_sub(REACH).min(x.nrows() - DEGREE - 1);
        let terms = (0..=DEGREE).map(|k| {
            // Weights sum to zero: relative to the middle, rounding is smaller.
            stencils[row - begin][k] * (x[(begin + k, column)] - x[(row, column)])
        });
        scale * terms.sum::<f64>()
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signals::butterworth::{filtfilt, low_pass};
    use std::f64::consts::PI;

    /// Largest error in the middle of the signal over the largest value.
    fn worst(found: &Mat<f64>, truth: impl Fn(f64) -> f64, rate: f64) -> f64 {
        let rows = found.nrows() / 4..3 * found.nrows() / 4;
        let at = |row: usize| row as f64 / rate;
        let off = rows.clone().map(|row| (found[(row, 0)] - truth(at(row))).abs());
        off.fold(0.0, f64::max) / rows.map(|row| truth(at(row)).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn a_filtered_multi_sine_has_the_right_derivatives() {
        let cases =
            [(100.0, 10.0, 600), (100.0, 38.0, 400), (1000.0, 10.0, 6000), (5000.0, 4.0, 75_000)];
        for (rate, cutoff, n) in cases {
            let tones = [0.19, 0.11, 0.04].map(|share| 2.0 * PI * share * cutoff);
            let q = |t: f64| tones.iter().map(|w| (w * t + w).sin() / w).sum::<f64>();
            let dq = |t: f64| tones.iter().map(|w| (w * t + w).cos()).sum::<f64>();
            let ddq = |t: f64| tones.iter().map(|w| -w * (w * t + w).sin()).sum::<f64>();
            let mut smooth = Mat::from_fn(n, 1, |row, _| 1.0 + q(row as f64 / rate));

            filtfilt(&low_pass(cutoff, rate).unwrap(), smooth.col_as_slice_mut(0)).unwrap();
            let first = even_derivative(smooth.as_ref(), rate, 1).unwrap();
            let second = even_derivative(smooth.as_ref(), rate, 2).unwrap();

            assert!(worst(&first, dq, rate) < 1e-3, "{rate} {cutoff}");
            assert!(worst(&second, ddq, rate) < 1e-3, "{rate} {cutoff}");
        }
    }

    #[test]
    fn too_few_rows_are_refused() {
        let found = even_derivative(Mat::zeros(6, 1).as_ref(), 1.0, 1);

        assert_eq!(found, Err(MotionError::TooFewRows { rows: 6, needed: 7 }));
    }
}
