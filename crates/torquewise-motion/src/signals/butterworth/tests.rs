//! Filtered signals of scipy 1.x; time to settle, and cut-offs that cannot be.

use super::*;
use approx::assert_abs_diff_eq;

#[test]
fn a_step_has_settled_when_it_is_said_to_have() {
    let sections = low_pass(5.0, 1000.0).unwrap();
    let mut step = vec![1.0; 2000];
    sosfilt(&sections, &mut step, &mut [[0.0; 2]; 2]);

    let settle = settle_time(5.0, 1e-3);
    let settled = (0..2000).find(|k| f64::from(*k) > 1000.0 * settle).unwrap_or(2000);
    let settled = usize::try_from(settled).unwrap();

    assert!(step[settled..].iter().all(|x| (x - 1.0).abs() < 2e-3));
    assert!(step[settled / 2..settled].iter().any(|x| (x - 1.0).abs() > 1e-2));
}

fn signal() -> Vec<f64> {
    let value = |n: usize| {
        let k = n as f64;
        (0.3 * k).sin() + 0.02 * k + 0.3 * ((7 * n) % 5) as f64
    };
    (0..40).map(|n| (value(n) * 1e3).round() / 1e3).collect()
}

/// A cut-off, and every fifth of scipy.signal.sosfiltfilt(butter(4, cutoff, output="sos"), signal).
const FILTERED: &str = include_str!("filtered.csv");

#[test]
fn columns_are_filtered_as_scipy_does() {
    for line in FILTERED.lines() {
        let expected: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        let mut filtered = signal();

        filtfilt(&low_pass(expected[0], 2.0).unwrap(), &mut filtered).unwrap();

        let found: Vec<f64> = filtered.into_iter().step_by(5).collect();
        assert_abs_diff_eq!(found[..], expected[1..], epsilon = 1e-9);
    }
}

#[test]
fn impossible_cut_offs_and_signals_no_longer_than_the_padding_are_refused() {
    for cutoff in [0.0, -1.0, 5.0, f64::NAN, 1e-9] {
        assert!(matches!(low_pass(cutoff, 10.0), Err(MotionError::Cutoff { .. })));
    }
    let sections = low_pass(0.25, 2.0).unwrap();

    let short = filtfilt(&sections, &mut [0.0; 15]);

    assert_eq!(short, Err(MotionError::TooFewRows { rows: 15, needed: 16 }));
}
