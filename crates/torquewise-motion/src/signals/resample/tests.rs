//! Sines of known value between the samples, and stamps of known origin.

use super::*;
use approx::assert_relative_eq;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;

/// Even stamps at 100 Hz, each off by at most `error` steps.
fn received(n: usize, error: f64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    (0..n).map(|k| 0.01 * (k as f64 + error * rng.random_range(-1.0..1.0))).collect()
}

#[test]
fn a_sine_at_a_tenth_of_the_rate_is_reproduced() {
    let t = received(2000, 0.15);
    let sine = |t: f64| (2.0 * PI * 10.0 * t).sin();
    let x: Vec<f64> = t.iter().map(|t| sine(*t)).collect();
    let found = timing(&t).unwrap();

    let (first, even) = grid(&t, t[0], &found).unwrap();
    let y = Resampler::new(&t, &even, found.rate).column(&x).unwrap();

    assert_eq!(first, 0);
    assert!((1990..2010).contains(&even.len()));
    let worst = (10..even.len() - 10).map(|row| (y[row] - sine(even[row])).abs());
    assert!(worst.fold(0.0, f64::max) < 1e-3);
}

#[test]
fn receive_times_of_an_even_device_are_told_from_uneven_sampling() {
    let received = timing(&received(5000, 0.3)).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut now = 0.0;
    let uneven = (0..5000).map(|_| {
        now += 0.01 * (1.0 + 0.4 * rng.random_range(-1.0..1.0));
        now
    });
    let uneven = timing(&uneven.collect::<Vec<f64>>()).unwrap();

    // A uniform error of ±0.3 steps has a deviation of 0.3/√3, its differences √2 times that.
    assert_relative_eq!(received.jitter, 0.3 * (2.0_f64 / 3.0).sqrt(), max_relative = 0.05);
    assert_relative_eq!(received.receive_ratio().unwrap(), 1.0, max_relative = 0.05);
    assert!(uneven.receive_ratio().unwrap() > 5.0);
}

#[test]
fn even_stamps_are_even_and_kept() {
    let t: Vec<f64> = (0..1000).map(|k| 1.6e9 + f64::from(k) * 0.007_812_5).collect();

    let found = timing(&t).unwrap();
    let (_, even) = grid(&t, t[0], &found).unwrap();

    assert!(found.is_even());
    assert_eq!(found.receive_ratio(), None);
    assert_eq!(even, t);
}

#[test]
fn a_gap_that_would_fill_memory_is_refused() {
    let mut t: Vec<f64> = (0..100).map(|k| f64::from(k) * 1e-3).collect();
    t.push(1e9);

    let found = timing(&t).unwrap();

    assert!(matches!(grid(&t, 0.0, &found), Err(MotionError::Gap { row: 100, .. })));
}

#[test]
fn two_rows_received_at_once_do_not_blow_up_noise() {
    let mut t: Vec<f64> = (0..400).map(|k| f64::from(k) * 0.01).collect();
    t[200] = t[201] - 1e-7;
    t[301] = 0.5 * (t[300] + t[301]);
    let x: Vec<f64> = (0..400).map(|row| if row % 2 == 0 { 1e-3 } else { -1e-3 }).collect();
    let found = timing(&t).unwrap();

    let (_, even) = grid(&t, 0.0, &found).unwrap();
    let y = Resampler::new(&t, &even, found.rate).column(&x).unwrap();

    assert!(y.iter().all(|y| y.abs() < 3e-3));
}
