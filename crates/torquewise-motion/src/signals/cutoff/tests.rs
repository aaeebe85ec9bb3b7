//! Cut-offs of signals whose spectrum is known.

use super::*;
use crate::signals::zero_phase::low_pass_columns;
use faer::Mat;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::PI;

fn white(n: usize, sigma: f64, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let draw = |_| {
        let x: f64 = StandardNormal.sample(&mut rng);
        sigma * x
    };
    (0..n).map(draw).collect()
}

/// Noise that a zero-phase Butterworth filter of order 4 has passed, so that its density is
/// 2/rate · (1 + (f/corner)⁸)⁻² for f well below half the rate.
fn coloured(n: usize, rate: f64, corner: f64) -> Vec<f64> {
    let x = white(n, 1.0, 1);
    let x = Mat::from_fn(n, 1, |row, _| x[row]);
    let filtered = low_pass_columns(x.as_ref(), rate, corner, 4).unwrap();
    filtered.col_as_slice(0).to_vec()
}

fn sum(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

#[test]
fn the_cutoff_is_where_signal_and_noise_are_equally_dense() {
    let (n, rate, corner) = (60_000, 500.0, 8.0);
    for sigma in [0.1, 0.01] {
        let x = sum(&coloured(n, rate, corner), &white(n, sigma, 2));

        let found = signal_cutoff(&x, rate, Kind::Torque).unwrap();

        // (1 + u⁸)⁻² = σ²  →  u = (1/σ − 1)^(1/8)
        let expected = corner * (1.0 / sigma - 1.0_f64).powf(0.125);
        assert_eq!(found.reason, Reason::Noise);
        assert!((found.cutoff / expected - 1.0).abs() < 0.1, "{} {expected}", found.cutoff);
        let floor = sigma * sigma * 2.0 / rate;
        assert!((found.floor / floor - 1.0).abs() < 0.1);
    }
}

#[test]
fn a_log_that_was_filtered_before_ends_where_it_is_empty() {
    let rate = 125.0;
    let x: Vec<f64> = (0..3440)
        .map(|k| {
            let t = f64::from(k) / rate;
            (1..=20).map(|h| (2.0 * PI * 0.25 * f64::from(h) * t).sin() / f64::from(h)).sum()
        })
        .collect();

    let found = signal_cutoff(&x, rate, Kind::Torque).unwrap();

    assert!((5.0..10.0).contains(&found.cutoff), "{found:?}");
    assert!(found.removed < 1e-6);
}

#[test]
fn a_coarse_encoder_sets_its_own_floor() {
    let (rate, step) = (200.0, 1e-3);
    let position = |t: f64| (2.0 * PI * 0.3 * t).sin() + 0.3 * (2.0 * PI * 2.0 * t).cos();
    let smooth: Vec<f64> = (0..20_000).map(|k| position(f64::from(k) / rate)).collect();
    let x: Vec<f64> = smooth.iter().map(|x| (x / step).round() * step).collect();

    let found = signal_cutoff(&x, rate, Kind::Position).unwrap();

    assert!(found.floor > 0.999 * step * step / (6.0 * rate));
    assert!((2.0..8.0).contains(&found.cutoff), "{found:?}");
}

#[test]
fn a_narrow_line_far_above_is_not_waited_for() {
    let (n, rate) = (30_000, 100.0);
    let line: Vec<f64> = (0..n).map(|k| 0.2 * (2.0 * PI * 29.7 / rate * k as f64).sin()).collect();
    let x = sum(&sum(&coloured(n, rate, 4.0), &white(n, 0.01, 3)), &line);

    let found = signal_cutoff(&x, rate, Kind::Torque).unwrap();

    assert!(found.cutoff < 10.0, "{found:?}");
}

#[test]
fn bounds_hold_for_noise_and_for_full_bands() {
    let noise = signal_cutoff(&white(20_000, 1.0, 4), 30.0, Kind::Torque).unwrap();
    let full = coloured(20_000, 30.0, 14.9);
    let full = signal_cutoff(&full, 30.0, Kind::Position).unwrap();
    let still = signal_cutoff(&[0.7; 500], 30.0, Kind::Torque).unwrap();

    assert!(noise.cutoff <= 1.0, "{noise:?}");
    assert!(full.cutoff <= 12.0);
    assert_eq!((still.cutoff, still.reason), (12.0, Reason::Constant));
}

#[test]
fn the_common_cutoff_keeps_the_motion_and_spares_the_acceleration() {
    let reason = Reason::Noise;
    let of = |cutoff, motion| SignalCutoff { cutoff, reason, floor: 1.0, removed: 0.1, motion };

    let torque = choose(vec![of(20.0, 1.0)], vec![of(6.0, 1.0)], 100.0);
    let least = choose(vec![of(20.0, 2.0)], vec![of(6.0, 1.0)], 100.0);
    let most = choose(vec![of(20.0, 0.25)], vec![of(6.0, 1.0)], 100.0);
    let position = choose(vec![of(5.0, 4.0)], vec![of(6.0, 1.0)], 100.0);
    let alone = choose(vec![of(50.0, 7.0)], Vec::new(), 100.0);
    let two = choose(vec![of(40.0, 1.0); 2], vec![of(4.0, 1.0), of(9.0, 1.0)], 100.0);

    assert_eq!((torque.cutoff, torque.decided), (6.0, Decided::Torque));
    assert_eq!((least.cutoff, least.decided), (10.0, Decided::MotionLeast));
    assert_eq!((most.cutoff, most.decided), (5.0, Decided::MotionMost));
    assert_eq!((position.cutoff, position.decided), (5.0, Decided::Position));
    assert_eq!((alone.cutoff, alone.decided), (40.0, Decided::Position));
    assert_eq!((two.cutoff, two.decided), (6.0, Decided::Torque));
}

#[test]
fn motion_slower_than_a_segment_is_seen() {
    let rate = 50.0;
    let noise = white(6000, 1e-5, 6);
    let slow = |k: usize| (2.0 * PI * 0.05 * k as f64 / rate).sin();
    let x: Vec<f64> = (0..6000).map(|k| slow(k) + noise[k]).collect();

    let found = signal_cutoff(&x, rate, Kind::Position).unwrap();

    assert!((0.03..0.1).contains(&found.motion), "{found:?}");
}
