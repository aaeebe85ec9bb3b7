//! Sections and filtered signals of scipy 1.x.

use super::*;
use approx::assert_relative_eq;

/// scipy.signal.butter(order, 2·cutoff/rate, output="sos") with rate 2 Hz.
type Sos = &'static [[f64; 6]];

const DESIGNS: [(usize, f64, Sos); 5] = [
    (
        1,
        0.2,
        &[[
            0.245_237_275_252_785_57,
            0.245_237_275_252_785_57,
            0.0,
            1.0,
            -0.509_525_449_494_428_8,
            0.0,
        ]],
    ),
    (
        2,
        0.1,
        &[[
            0.020_083_365_564_211_232,
            0.040_166_731_128_422_464,
            0.020_083_365_564_211_232,
            1.0,
            -1.561_018_075_800_718_2,
            0.641_351_538_057_563_1,
        ]],
    ),
    (
        3,
        0.2,
        &[
            [
                0.018_098_933_007_514_428,
                0.036_197_866_015_028_855,
                0.018_098_933_007_514_428,
                1.0,
                -0.509_525_449_494_428_8,
                0.0,
            ],
            [1.0, 1.0, 0.0, 1.0, -1.250_516_430_848_740_2, 0.545_723_315_509_457_9],
        ],
    ),
    (
        4,
        0.05,
        &[
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
        5,
        0.7,
        &[
            [
                0.201_885_013_869_886_36,
                0.403_770_027_739_772_7,
                0.201_885_013_869_886_36,
                1.0,
                0.324_919_696_232_906_3,
                0.0,
            ],
            [1.0, 2.0, 1.0, 1.0, 0.710_525_516_540_602_7, 0.208_818_210_000_029_98],
            [1.0, 1.0, 0.0, 1.0, 0.940_456_403_667_956_9, 0.6],
        ],
    ),
];

#[test]
fn sections_are_those_of_scipy() {
    for (order, cutoff, expected) in DESIGNS {
        let sections = low_pass(order, cutoff, 2.0).unwrap();

        assert_eq!(sections.len(), expected.len());
        for (section, row) in sections.iter().zip(expected) {
            let found = [section.b, section.a].concat();
            for (found, expected) in found.iter().zip(row) {
                assert_relative_eq!(found, expected, max_relative = 1e-12, epsilon = 1e-13);
            }
        }
    }
}

#[test]
fn states_and_outputs_are_those_of_scipy() {
    let sections = low_pass(3, 0.2, 2.0).unwrap();
    let mut state = vec![[0.0; 2]; 2];
    let mut x = [0.0, 0.916, 1.805, 1.143, 1.912, 1.097];

    let zi = sosfilt_zi(&sections);
    sosfilt(&sections, &mut x, &mut state);

    let expected_zi = [
        [0.129_504_509_322_844_32, 0.018_098_933_007_514_428],
        [0.852_396_557_669_640_6, -0.545_723_315_509_457_5],
    ];
    for (found, expected) in zi.concat().iter().zip(expected_zi.concat()) {
        assert_relative_eq!(*found, expected, max_relative = 1e-12);
    }
    let expected = [
        0.0,
        0.016_578_622_634_883_217,
        0.111_583_512_139_012_87,
        0.345_209_584_079_701_1,
        0.691_452_537_320_423_9,
        1.058_066_059_751_157_3,
    ];
    for (found, expected) in x.iter().zip(expected) {
        assert_relative_eq!(*found, expected, max_relative = 1e-12);
    }
}

#[test]
fn half_the_power_passes_at_the_cutoff() {
    for order in [1, 4, 11, MAX_ORDER] {
        let sections = low_pass(order, 3.0, 100.0).unwrap();
        let mut impulse = vec![0.0; 20_000];
        impulse[0] = 1.0;
        let mut state = vec![[0.0; 2]; sections.len()];

        sosfilt(&sections, &mut impulse, &mut state);

        let (mut re, mut im) = (0.0, 0.0);
        for (k, h) in impulse.iter().enumerate() {
            let (s, c) = (2.0 * PI * 0.03 * k as f64).sin_cos();
            (re, im) = (re + h * c, im + h * s);
        }
        assert_relative_eq!(re * re + im * im, 0.5, max_relative = 1e-8);
    }
}

#[test]
fn a_step_has_settled_when_it_is_said_to_have() {
    let sections = low_pass(4, 5.0, 1000.0).unwrap();
    let mut step = vec![1.0; 2000];
    sosfilt(&sections, &mut step, &mut [[0.0; 2]; 2]);

    let settle = settle_time(4, 5.0, 1e-3);
    let settled = (0..2000).find(|k| f64::from(*k) > 1000.0 * settle).unwrap_or(2000);
    let settled = usize::try_from(settled).unwrap();

    assert!(step[settled..].iter().all(|x| (x - 1.0).abs() < 2e-3));
    assert!(step[settled / 2..settled].iter().any(|x| (x - 1.0).abs() > 1e-2));
}

#[test]
fn impossible_filters_are_refused() {
    assert_eq!(
        low_pass(0, 1.0, 10.0),
        Err(MotionError::FilterOrder { order: 0, limit: MAX_ORDER })
    );
    for cutoff in [0.0, -1.0, 5.0, f64::NAN, 1e-9] {
        assert!(matches!(low_pass(4, cutoff, 10.0), Err(MotionError::Cutoff { .. })));
    }
}
