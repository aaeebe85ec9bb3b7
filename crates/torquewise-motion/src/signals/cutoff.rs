//! Where the choice of a cut-off begins: above the band of the motion.

use crate::signals::noise::white_noise;
use crate::{MotionError, Result, median};
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use std::f64::consts::PI;

/// Lowest cut-off that is ever chosen \[Hz\].
pub(crate) const LOWEST: f64 = 0.5;
/// Highest cut-off that is ever chosen, as a share of the rate.
pub(crate) const HIGHEST: f64 = 0.4;

/// The first cut-off is so many times the band of the motion.
const MARGIN: f64 = 8.0;
const MOTION_SHARE: f64 = 0.95;
/// Power of the speed counts where it is so many times that of white noise in the position, and of
/// what lies at the high half of all frequencies: what stamps are off is white in the speed.
const CLEAR: f64 = 16.0;
/// A joint whose speed has less than this part of the power of the fastest does not move.
const MOVING: f64 = 1e-3;
/// A gap in the spectrum is counted from this bin, where it begins below.
const LEAST_BIN: usize = 8;
const LEAST_ROWS: usize = 64;

/// A cut-off eight times above the band of the motion \[Hz\], at the middle one of the joints that
/// move: wide enough to lose no torque of rigid bodies, and a start for the choice by held-out
/// torque (E19).
///
/// - `q`: evenly sampled positions of each joint \[rad\], n of m values; `rate`: theirs \[Hz\]
///
/// Source: ten times the bandwidth of the motion is usual in the identification of robots, see
/// A. Janot et al., IEEE Trans. Control Syst. Technol. 22 (2014); the fit begins wider still.
pub(crate) fn above_motion(q: &[Vec<f64>], rate: f64) -> Result<f64> {
    let rows = q.first().map_or(0, Vec::len);
    if rows < LEAST_ROWS {
        return Err(MotionError::TooFewRows { rows, needed: LEAST_ROWS });
    }
    if !rate.is_finite() || rate <= 2.0 * LOWEST {
        let expected = "above 1 Hz to choose a cut-off, or set one";
        return Err(MotionError::Setting { what: "rate of the log", value: rate, expected });
    }
    let bands: Vec<(f64, f64)> = q.iter().filter_map(|x| band(x, rate)).collect();
    let most = bands.iter().fold(0.0, |most: f64, (_, power)| most.max(*power));
    let moving = bands.into_iter().filter(|(_, power)| *power >= MOVING * most);
    let mut bands: Vec<f64> = moving.map(|(band, _)| band).collect();
    bands.sort_by(f64::total_cmp);
    let highest = (HIGHEST * rate).max(LOWEST);
    let middle = bands.get(bands.len() / 2);
    Ok(middle.map_or(highest, |band| (MARGIN * band).clamp(LOWEST, highest)))
}

/// Frequency below which 95 % of the power of the speed lies that is clear of noise \[Hz\], and that
/// power; `None` of a joint that does not move.
fn band(x: &[f64], rate: f64) -> Option<(f64, f64)> {
    let speed: Vec<f64> = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let n = speed.len();
    let mean = speed.iter().sum::<f64>() / n as f64;
    let hann = |k: usize| 0.5 - 0.5 * (2.0 * PI * k as f64 / n as f64).cos();
    let windowed = speed.iter().enumerate().map(|(k, speed)| hann(k) * (speed - mean));
    let mut bins: Vec<Complex<f64>> = windowed.map(Complex::from).collect();
    FftPlanner::new().plan_fft_forward(n).process(&mut bins);
    // The other half mirrors this one.
    bins.truncate(n / 2 + 1);
    // White noise of the position has this mean square in each bin of its differences.
    let noise = white_noise(x, &vec![false; x.len()]);
    let window: f64 = (0..n).map(|k| hann(k).powi(2)).sum();
    let of_position = |bin: usize| {
        let gain = 2.0 * (PI * bin as f64 / n as f64).sin();
        window * (noise * gain).powi(2)
    };
    let squares: Vec<f64> = bins.iter().map(Complex::norm_sqr).collect();
    let of_speed = median(&mut squares[squares.len() / 2..].to_vec());
    let clear = |(bin, &value): (usize, &f64)| {
        if value > CLEAR * of_position(bin).max(of_speed) { value } else { 0.0 }
    };
    let mut power: Vec<f64> = squares.iter().enumerate().map(clear).collect();
    // What the first cut-off would leave out, with nothing in between, are lines of the device.
    let strongest = (0..power.len()).max_by(|a, b| power[*a].total_cmp(&power[*b]))?;
    let bins: Vec<usize> = (strongest..power.len()).filter(|&bin| power[bin] > 0.0).collect();
    let is_gap = |pair: &&[usize]| pair[1] as f64 > MARGIN * pair[0].max(LEAST_BIN) as f64;
    if let Some(gap) = bins.windows(2).find(is_gap) {
        power.truncate(gap[0] + 1);
    }
    let total: f64 = power.iter().sum();
    let mut below = 0.0;
    let last = power.iter().position(|power| {
        below += power;
        total > 0.0 && below >= MOTION_SHARE * total
    })?;
    Some((last.max(1) as f64 * rate / n as f64, total))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signals::noise::tests::gaussian;
    use approx::assert_abs_diff_eq;

    fn tones(rate: f64, rows: usize, noise: f64) -> Vec<f64> {
        let sum = |(k, noise): (usize, f64)| {
            let t = k as f64 / rate;
            (2.0 * PI * 0.2 * t).sin() + 0.3 * (2.0 * PI * 0.7 * t).sin() + noise
        };
        gaussian(rows, noise, 3).into_iter().enumerate().map(sum).collect()
    }

    #[test]
    fn the_band_of_a_motion_is_seen_through_noise_at_any_rate_and_with_tones_far_apart() {
        let noisy =
            [(100.0, 3_000, 0.0), (100.0, 3_000, 1e-3), (1e3, 30_000, 1e-4), (1e3, 30_000, 1e-3)];
        let noisy = noisy.map(|(rate, rows, noise)| (tones(rate, rows, noise), rate, 0.7));
        let tone =
            |k: u32, [hertz, size]: [f64; 2]| size * (2.0 * PI * hertz * 0.01 * f64::from(k)).sin();
        let sum = |tones: [[f64; 2]; 3]| -> Vec<f64> {
            (0..6_020).map(|k| tones.iter().map(|&own| tone(k, own)).sum()).collect()
        };
        let apart = [
            (sum([[0.5, 0.4], [1.0, 0.3], [1.5, 0.2]]), 100.0, 1.5),
            (sum([[0.1, 1.0], [1.0, 0.3], [0.0, 0.0]]), 100.0, 1.0),
            (sum([[1.0, 1.0], [4.0, 0.3], [0.0, 0.0]]), 100.0, 4.0),
        ];
        for (case, (x, rate, highest)) in noisy.into_iter().chain(apart).enumerate() {
            let (found, _) = band(&x, rate).unwrap();

            assert!((found - highest).abs() < 0.1, "case {case}: {found} {highest}");
        }
        let slow = (0..3000).map(|k| (2.0 * PI * 0.02 * f64::from(k) / 100.0).sin());
        assert!(band(&slow.collect::<Vec<f64>>(), 100.0).unwrap().0 < 0.15);
    }

    #[test]
    fn jitter_of_stamps_and_joints_that_stand_still_are_no_motion() {
        let units = gaussian(60_000, 1.0, 5);
        // Stamps are off by steps of their own, the rows are even.
        let mut t = 0.0;
        let late = units[..30_000].iter().map(|unit| {
            t += 1e-3 * (1.0 + 0.3 * unit);
            (2.0 * PI * 0.2 * t).sin() + 0.3 * (2.0 * PI * 0.7 * t).sin()
        });
        let late: Vec<f64> = late.collect();
        let still: Vec<f64> = units[30_000..].iter().map(|unit| 1e-6 * unit.round()).collect();
        // A clock that beats with the logger draws lines, far above the motion.
        let beats = tones(1e3, 30_000, 0.0).into_iter().enumerate();
        let line = |k: usize| 5e-4 * (2.0 * PI * 0.2 * k as f64).sin();
        let beats: Vec<f64> = beats.map(|(k, x)| x + line(k)).collect();

        let found = above_motion(&[still.clone(), late, still], 1e3).unwrap();

        assert!((found / MARGIN - 0.7).abs() < 0.1, "{found}");
        assert!((band(&beats, 1e3).unwrap().0 - 0.7).abs() < 0.1);
    }

    #[test]
    fn a_cut_off_lies_within_what_the_rate_allows() {
        let fast = tones(4.0, 200, 0.0);
        let still = vec![1.0; 200];

        assert_abs_diff_eq!(above_motion(&[fast], 4.0).unwrap(), 1.6);
        assert_abs_diff_eq!(above_motion(&[still], 30.0).unwrap(), 12.0);
        assert!(matches!(above_motion(&[vec![0.0; 9]], 30.0), Err(MotionError::TooFewRows { .. })));
        assert!(matches!(above_motion(&[vec![0.0; 99]], 1.0), Err(MotionError::Setting { .. })));
    }
}
