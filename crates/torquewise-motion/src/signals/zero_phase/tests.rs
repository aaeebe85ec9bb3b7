//! Filtered signals of scipy 1.x.

use super::*;
use crate::signals::butterworth::low_pass;
use approx::assert_abs_diff_eq;

fn signal() -> Vec<f64> {
    let value = |n: usize| {
        let k = n as f64;
        (0.3 * k).sin() + 0.02 * k + 0.3 * ((7 * n) % 5) as f64
    };
    (0..40).map(|n| (value(n) * 1e3).round() / 1e3).collect()
}

/// Every fifth of scipy.signal.sosfiltfilt(butter(4, 0.25, output="sos"), signal).
const FILTERED: [f64; 8] = [
    0.001_056_202_247_831_289_4,
    1.756_132_039_027_902,
    0.932_889_831_313_138_3,
    -0.082_632_133_199_053_03,
    0.718_837_571_946_347_2,
    2.031_178_721_095_962_6,
    1.623_721_319_229_883_6,
    0.368_072_282_153_359_5,
];

#[test]
fn columns_are_filtered_as_scipy_does() {
    let mut filtered = signal();

    filtfilt(&low_pass(0.25, 2.0).unwrap(), &mut filtered).unwrap();

    for (filtered, expected) in filtered.iter().step_by(5).zip(FILTERED) {
        assert_abs_diff_eq!(*filtered, expected, epsilon = 1e-10);
    }
}

#[test]
fn a_signal_no_longer_than_the_padding_is_refused() {
    let sections = low_pass(0.25, 2.0).unwrap();

    let short = filtfilt(&sections, &mut [0.0; 15]);
    let broken = filtfilt(&sections, &mut [f64::NAN; 16]);

    assert_eq!(short, Err(MotionError::TooFewRows { rows: 15, needed: 16 }));
    assert_eq!(broken, Err(MotionError::NotFiniteAt { row: 0 }));
}
