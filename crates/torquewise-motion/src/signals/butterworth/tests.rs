//! Sections of scipy 1.x; signals that went through them are those of `zero_phase`.

use super::*;
use approx::assert_relative_eq;

/// scipy.signal.butter(4, 2·cutoff/rate, output="sos") with rate 2 Hz.
const DESIGNS: [(f64, [[f64; 6]; 2]); 2] = [
    (
        0.05,
        [
            [
                3.123_897_691_708_262e-5,
                6.247_795_383_416_523e-5,
                3.123_897_691_708_262e-5,
                1.0,
                -1.725_933_395_036_940_7,
                0.747_447_371_907_791_1,
            ],
            [1.0, 2.0, 1.0, 1.0, -1.863_800_492_075_235, 0.887_032_999_652_694_6],
        ],
    ),
    (
        0.7,
        [
            [
                0.275_413_288_072_304_25,
                0.550_826_576_144_608_5,
                0.275_413_288_072_304_25,
                1.0,
                0.672_740_911_191_527,
                0.144_535_199_833_120_9,
            ],
            [1.0, 2.0, 1.0, 1.0, 0.897_657_940_036_644_5, 0.527_186_904_631_597_3],
        ],
    ),
];

#[test]
fn sections_are_those_of_scipy() {
    for (cutoff, expected) in DESIGNS {
        for (section, row) in low_pass(cutoff, 2.0).unwrap().iter().zip(expected) {
            let found = [section.b, section.a].concat();
            for (found, expected) in found.iter().zip(row) {
                assert_relative_eq!(*found, expected, max_relative = 1e-12, epsilon = 1e-13);
            }
        }
    }
}

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

#[test]
fn impossible_cut_offs_are_refused() {
    for cutoff in [0.0, -1.0, 5.0, f64::NAN, 1e-9] {
        assert!(matches!(low_pass(cutoff, 10.0), Err(MotionError::Cutoff { .. })));
    }
}
