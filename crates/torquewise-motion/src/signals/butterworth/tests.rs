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

/// Every fifth of scipy.signal.sosfiltfilt(butter(4, cutoff, output="sos"), signal).
const FILTERED: [(f64, [f64; 8]); 2] = [
    (
        0.25,
        [
            0.001_056_202_247_831_289_4,
            1.756_132_039_027_902,
            0.932_889_831_313_138_3,
            -0.082_632_133_199_053_03,
            0.718_837_571_946_347_2,
            2.031_178_721_095_962_6,
            1.623_721_319_229_883_6,
            0.368_072_282_153_359_5,
        ],
    ),
    (
        0.05,
        [
            -0.132_221_494_206_813_87,
            0.264_414_584_167_356_5,
            0.659_156_534_766_789_7,
            0.963_192_444_853_572_9,
            1.152_041_747_878_057,
            1.231_832_015_666_964_2,
            1.225_251_656_701_186_2,
            1.174_855_459_546_953_8,
        ],
    ),
];

#[test]
fn columns_are_filtered_as_scipy_does() {
    for (cutoff, expected) in FILTERED {
        let mut filtered = signal();

        filtfilt(&low_pass(cutoff, 2.0).unwrap(), &mut filtered).unwrap();

        for (filtered, expected) in filtered.iter().step_by(5).zip(expected) {
            assert_abs_diff_eq!(*filtered, expected, epsilon = 1e-9);
        }
    }
}

#[test]
fn impossible_cut_offs_and_signals_no_longer_than_the_padding_are_refused() {
    for cutoff in [0.0, -1.0, 5.0, f64::NAN, 1e-9] {
        assert!(matches!(low_pass(cutoff, 10.0), Err(MotionError::Cutoff { .. })));
    }
    let sections = low_pass(0.25, 2.0).unwrap();

    let short = filtfilt(&sections, &mut [0.0; 15]);
    let broken = filtfilt(&sections, &mut [f64::NAN; 16]);

    assert_eq!(short, Err(MotionError::TooFewRows { rows: 15, needed: 16 }));
    assert_eq!(broken, Err(MotionError::NotFiniteAt { row: 0 }));
}
