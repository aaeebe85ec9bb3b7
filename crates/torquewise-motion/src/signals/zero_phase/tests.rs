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
const ORDER_4: [f64; 40] = [
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

/// scipy.signal.sosfiltfilt(butter(3, 0.1, output="sos"), signal)
const ORDER_3: [f64; 40] = [
    0.064_520_267_834_443_26,
    0.370_371_240_230_110_75,
    0.652_725_603_497_861_2,
    0.894_337_270_699_444_9,
    1.081_613_607_167_457_8,
    1.205_773_308_979_267_7,
    1.263_409_139_300_829_3,
    1.256_581_891_380_717_2,
    1.192_519_628_858_921_7,
    1.082_898_808_041_315_6,
    0.942_704_778_054_918_7,
    0.788_805_839_943_172_9,
    0.638_459_418_188_652_6,
    0.507_904_393_224_462_2,
    0.411_073_645_039_747_36,
    0.358_450_421_836_185_6,
    0.356_191_486_305_084_3,
    0.405_684_493_406_659_4,
    0.503_603_918_433_017_4,
    0.642_376_369_375_922_9,
    0.810_930_958_312_501_4,
    0.995_696_502_378_381_5,
    1.181_851_774_163_535_7,
    1.354_745_719_191_408,
    1.501_278_133_704_839,
    1.611_034_368_582_125_3,
    1.677_100_053_240_185_9,
    1.696_576_913_492_498_8,
    1.670_782_029_463_036_9,
    1.605_032_444_670_862_4,
    1.507_957_350_650_306,
    1.390_437_539_404_196_6,
    1.264_377_070_099_022_7,
    1.141_466_998_430_239,
    1.031_997_420_054_976_4,
    0.943_775_748_951_771_5,
    0.881_315_009_423_136_3,
    0.845_500_126_410_623_8,
    0.833_829_164_992_109,
    0.841_157_231_496_827_9,
];

#[test]
fn columns_are_filtered_as_scipy_does() {
    for (order, cutoff, expected) in [(4, 0.25, ORDER_4), (3, 0.1, ORDER_3)] {
        let mut filtered = signal();

        filtfilt(&low_pass(order, cutoff, 2.0).unwrap(), &mut filtered).unwrap();

        for (filtered, expected) in filtered.iter().zip(expected) {
            assert_abs_diff_eq!(*filtered, expected, epsilon = 1e-10);
        }
    }
}

#[test]
fn padding_is_that_of_scipy() {
    let padding = |order| padding(&low_pass(order, 0.3, 2.0).unwrap());

    assert_eq!([1, 2, 3, 4, 5].map(padding), [6, 9, 12, 15, 18]);
}

#[test]
fn a_straight_line_passes_unchanged() {
    let sections = low_pass(4, 5.0, 100.0).unwrap();
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
    let sections = low_pass(4, 0.25, 2.0).unwrap();

    let short = filtfilt(&sections, &mut [0.0; 15]);
    let broken = filtfilt(&sections, &mut [f64::NAN; 16]);

    assert_eq!(short, Err(MotionError::TooFewRows { rows: 15, needed: 16 }));
    assert_eq!(broken, Err(MotionError::NotFiniteAt { row: 0 }));
}
