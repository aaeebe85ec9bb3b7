//! Witnesses of the derivative: exact polynomials, a bound on a sine.

use super::{derivative, derivative_by};
use crate::MotionError;
use faer::Mat;

/// Time stamps 10 ms apart, each moved by up to 4 ms.
fn jittered(rows: usize) -> Vec<f64> {
    (0..rows).map(|i| 0.01 * i as f64 + 0.004 * (i as f64 * 12.9898).sin()).collect()
}

fn even(rows: usize) -> Vec<f64> {
    (0..rows).map(|i| 0.01 * i as f64).collect()
}

fn column(t: &[f64], x: impl Fn(f64) -> f64) -> Mat<f64> {
    Mat::from_fn(t.len(), 1, |row, _| x(t[row]))
}

/// tᵈ differentiated `order` times.
fn power_derivative(degree: usize, order: usize, t: f64) -> f64 {
    if order > degree {
        return 0.0;
    }
    let factor: f64 = (0..order).map(|r| (degree - r) as f64).product();
    factor * t.powi(i32::try_from(degree - order).unwrap())
}

#[test]
fn polynomials_up_to_the_degree_are_exact_on_every_row() {
    for t in [even(60), jittered(60)] {
        for polynomial in [(1, 2), (2, 4), (7, 3), (10, 4), (40, 5)] {
            for order in 0..=polynomial.1.min(3) {
                assert_exact_to_the_degree(&t, polynomial, order);
            }
        }
    }
}

fn assert_exact_to_the_degree(t: &[f64], polynomial: (usize, usize), order: usize) {
    let impulses = Mat::identity(t.len(), t.len());
    let weights = derivative_by(polynomial, t, impulses.as_ref(), order).unwrap();
    for power in 0..=polynomial.1 {
        let x = column(t, |t| t.powi(i32::try_from(power).unwrap()));
        let derived = derivative_by(polynomial, t, x.as_ref(), order).unwrap();
        for (row, at) in t.iter().enumerate() {
            // |x| < 1: a few dozen roundings of every weight.
            let gain: f64 = (0..t.len()).map(|k| weights[(row, k)].abs()).sum();
            let error = (derived[(row, 0)] - power_derivative(power, order, *at)).abs();
            assert!(
                error <= 32.0 * f64::EPSILON * gain,
                "{polynomial:?}: t^{power}, order {order}, row {row}: {error:e}"
            );
        }
    }
}

#[test]
fn error_on_a_sine_stays_under_the_taylor_remainder() {
    let omega = std::f64::consts::TAU;
    for t in [even(80), jittered(80)] {
        let x = column(&t, |t| (omega * t).sin());
        let impulses = Mat::identity(t.len(), t.len());
        for order in [1, 2] {
            let derived = derivative(&t, x.as_ref(), order).unwrap();
            let weights = derivative(&t, impulses.as_ref(), order).unwrap();

            for row in 0..t.len() {
                // The fit is exact to degree 4: what is left is Σ |w| (ω Δt)⁵ / 5!.
                let remainder = |k: usize| (omega * (t[k] - t[row]).abs()).powi(5) / 120.0;
                let bound: f64 = (0..t.len()).map(|k| weights[(row, k)].abs() * remainder(k)).sum();
                let exact = match order {
                    1 => omega * (omega * t[row]).cos(),
                    _ => -omega * omega * (omega * t[row]).sin(),
                };
                let error = (derived[(row, 0)] - exact).abs();
                assert!(error <= bound, "order {order}, row {row}: {error} > {bound}");
            }
        }
    }
}

#[test]
fn acceleration_of_a_one_hertz_sine_at_100_hz_is_right_to_one_percent_by_default() {
    let (t, omega) = (even(400), std::f64::consts::TAU);
    let x = column(&t, |t| (omega * t).sin());

    let ddq = derivative(&t, x.as_ref(), 2).unwrap();

    let inner = 10..390;
    let worst = inner.map(|row| (ddq[(row, 0)] + omega * omega * x[(row, 0)]).abs());
    assert!(worst.fold(0.0, f64::max) < 0.01 * omega * omega);
}

#[test]
fn a_signal_shorter_than_the_window_is_fitted_as_a_whole() {
    let t = jittered(5);
    let x = column(&t, |t| 3.0 * t);

    let dq = derivative(&t, x.as_ref(), 1).unwrap();

    assert!((0..5).all(|row| (dq[(row, 0)] - 3.0).abs() < 1e-10));
}

#[test]
fn input_that_cannot_be_differentiated_is_refused() {
    let polynomial = (2, 3);
    let t = even(6);
    let x = column(&t, |t| t);
    let derived = |t: &[f64], x: &Mat<f64>| derivative_by(polynomial, t, x.as_ref(), 1);
    let refused = |t: &[f64], x: &Mat<f64>| derived(t, x).unwrap_err();

    let short = refused(&t[..3], &column(&t[..3], |t| t));
    let shape = refused(&t[..5], &x);
    let repeated = refused(&[0.0, 0.1, 0.2, 0.2, 0.3, 0.4], &x);
    let endless = refused(&[0.0, 0.1, f64::NAN, 0.2, 0.3, 0.4], &x);
    let hole = refused(&t, &column(&t, |t| if t > 0.03 { f64::NAN } else { t }));

    assert_eq!(short, MotionError::TooFewRows { rows: 3, needed: 4 });
    assert!(matches!(shape, MotionError::Shape { found: [6, _], expected: [5, _], .. }));
    assert_eq!(repeated, MotionError::TimeOrder { row: 3 });
    assert_eq!(endless, MotionError::NotFinite { signal: "t", joint: 0, row: 2 });
    assert!(matches!(hole, MotionError::NotFinite { signal: "x", .. }));
}
