//! The cubic spline through samples at any times.

use crate::{MotionError, Result};

/// Values at `at` of the cubic spline through (`t`, `x`), with no knot at the second and the last
/// but one sample.
///
/// - `t`: strictly increasing \[s\], m ≥ 4
/// - `x`: m values
/// - `at`: increasing \[s\]; outside of `t` the first and last polynomial go on
///
/// Source: C. de Boor, A Practical Guide to Splines, ch. IV. Checked against:
/// scipy.interpolate.CubicSpline.
pub(crate) fn interpolate(t: &[f64], x: &[f64], at: &[f64]) -> Result<Vec<f64>> {
    if t.len() < 4 {
        return Err(MotionError::TooFewRows { rows: t.len(), needed: 4 });
    }
    let slopes = slopes(t, x);
    let mut piece = 0;
    let mut values = Vec::with_capacity(at.len());
    for &at in at {
        while piece + 2 < t.len() && t[piece + 1] <= at {
            piece += 1;
        }
        let step = t[piece + 1] - t[piece];
        let (u, rise) = ((at - t[piece]) / step, x[piece + 1] - x[piece]);
        let (begin, end) = (slopes[piece] * step - rise, rise - slopes[piece + 1] * step);
        let bend = u * (1.0 - u) * ((1.0 - u) * begin + u * end);
        values.push(x[piece] + u * rise + bend);
    }
    Ok(values)
}

/// Weights of values at `t` in the polynomial through them, at one time.
pub fn lagrange(t: &[f64], at: f64) -> Vec<f64> {
    let weight = |i: usize| {
        let others = (0..t.len()).filter(|j| *j != i);
        others.map(|j| (at - t[j]) / (t[i] - t[j])).product()
    };
    (0..t.len()).map(weight).collect()
}

/// Slopes at the samples, from the tridiagonal system of continuous curvature.
fn slopes(t: &[f64], x: &[f64]) -> Vec<f64> {
    let n = t.len();
    let step = |k: usize| t[k + 1] - t[k];
    let secant = |k: usize| (x[k + 1] - x[k]) / step(k);
    let end = |near: usize, far: usize| {
        let (h, g) = (step(near), step(far));
        ((h + 2.0 * (h + g)) * g * secant(near) + h * h * secant(far)) / (h + g)
    };
    // Forward elimination: `upper` and `right` of the rows divided by their pivots.
    let mut upper = vec![(step(0) + step(1)) / step(1)];
    let mut right = vec![end(0, 1) / step(1)];
    for k in 1..n - 1 {
        let pivot = 2.0 * (step(k - 1) + step(k)) - step(k) * upper[k - 1];
        let sum = 3.0 * (step(k) * secant(k - 1) + step(k - 1) * secant(k));
        upper.push(step(k - 1) / pivot);
        right.push((sum - step(k) * right[k - 1]) / pivot);
    }
    let span = step(n - 2) + step(n - 3);
    let pivot = step(n - 3) - span * upper[n - 2];
    right.push((end(n - 2, n - 3) - span * right[n - 2]) / pivot);
    (0..n - 1).rev().for_each(|k| right[k] -= upper[k] * right[k + 1]);
    right
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn values_are_those_of_scipy_and_of_a_cubic() {
        let t = [0.0, 1.0, 2.5, 3.0, 4.2, 5.0];
        let x = [0.0, 1.0, -1.0, 0.5, 2.0, 1.0];

        let values = interpolate(&t, &x, &[0.3, 1.7, 2.6, 3.5, 4.9]).unwrap();

        let expected = [
            1.071_389_189_189_189_1,
            -0.596_317_117_117_117_1,
            -0.769_657_657_657_657_5,
            1.639_442_567_567_567_7,
            1.193_007_882_882_882,
        ];
        for (value, expected) in values.iter().zip(expected) {
            assert_abs_diff_eq!(*value, expected, epsilon = 1e-13);
        }
        let cubic = |t: f64| 1.0 - 2.0 * t + 0.5 * t * t - 0.25 * t * t * t;
        let t = [-1.0, 0.5, 0.7, 2.0];
        let x = t.map(cubic);

        let values = interpolate(&t, &x, &[-1.5, 0.6, 1.9, 2.5]).unwrap();

        for (value, t) in values.iter().zip([-1.5, 0.6, 1.9, 2.5]) {
            assert_abs_diff_eq!(*value, cubic(t), epsilon = 1e-12);
        }
    }
}
