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

/// scipy.signal.sosfiltfilt(butter(4, 0.25, output="sos"), signal)
const FILTERED: [f64; 40] = [
    0.001_056_202_247_831_289_4,
    0.651_658_471_357_711_5,
    1.187_534_174_351_915_9,
    1.543_820_214_053_701_8,
    1.719_697_037_910_712_4,
    1.756_132_039_027_902,
    1.699_055_259_063_086_3,
    1.576_782_586_538_940_2,
    1.401_531_318_835_021,
    1.182_389_558_170_920_7,
    0.932_889_831_313_138_3,
    0.669_902_625_874_936_9,
    0.412_104_215_864_528_56,
    0.182_488_972_777_947_46,
    0.009_030_056_762_287_797,
    -0.082_632_133_199_053_03,
    -0.079_777_893_617_212_56,
    0.014_367_196_257_085_957,
    0.187_799_259_120_602_22,
    0.427_539_603_741_568,
    0.718_837_571_946_347_2,
    1.039_021_097_456_076,
    1.356_943_950_361_484_6,
    1.641_529_300_381_117_3,
    1.870_634_640_604_952_3,
    2.031_178_721_095_962_6,
    2.113_316_052_985_408,
    2.108_865_969_017_060_6,
    2.017_040_025_044_226_4,
    1.849_032_538_900_516_4,
    1.623_721_319_229_883_6,
    1.359_134_671_195_966_4,
    1.071_312_505_279_043,
    0.783_301_639_271_395,
    0.533_073_503_622_186_1,
    0.368_072_282_153_359_5,
    0.327_351_275_641_986_96,
    0.423_766_631_141_387_4,
    0.636_755_327_341_876,
    0.916_874_809_560_881_5,
];

#[test]
fn columns_are_filtered_as_scipy_does() {
    let mut filtered = signal();

    filtfilt(&low_pass(0.25, 2.0).unwrap(), &mut filtered).unwrap();

    for (filtered, expected) in filtered.iter().zip(FILTERED) {
        assert_abs_diff_eq!(*filtered, expected, epsilon = 1e-10);
    }
}

#[test]
fn a_straight_line_passes_unchanged() {
    let sections = low_pass(5.0, 100.0).unwrap();
    let line: Vec<f64> = (0..1000).map(|k| 3.0 - 0.01 * f64::from(k)).collect();
    let mut x = line.clone();

    filtfilt(&sections, &mut x).unwrap();

    // The backward pass starts from the settled state of the last padded value, not from the
    // line's slope, which leaves a transient near the ends.
    for row in 300..700 {
        assert_abs_diff_eq!(x[row], line[row], epsilon = 1e-9);
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
