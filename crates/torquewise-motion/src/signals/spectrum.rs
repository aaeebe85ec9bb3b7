//! From signal to power spectral density: Welch's periodogram, plain or whitened by differences.

use crate::MotionError;
use realfft::RealFftPlanner;
use std::f64::consts::PI;

/// Shortest segment of a periodogram.
const MIN_SEGMENT: usize = 8;

/// One-sided power spectral density.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// \[Hz\], evenly spaced from 0 to half the rate.
    pub frequency: Vec<f64>,
    /// Power per frequency, in the unit of the signal squared per Hz.
    pub density: Vec<f64>,
    /// Segments that were averaged.
    pub n_segments: u32,
}

/// Welch's estimate: segments that overlap by half, each less its mean, under a Hann window.
///
/// - `x`: m values at `rate` \[Hz\]
/// - `segment`: rows per segment, 8 to m
///
/// Source: P. Welch, IEEE Trans. Audio Electroacoust. 15 (1967). Checked against:
/// scipy.signal.welch.
///
/// # Errors
/// [`MotionError::TooFewRows`] or [`MotionError::NotFiniteAt`].
pub fn welch(x: &[f64], rate: f64, segment: usize) -> Result<Spectrum, MotionError> {
    let n = segment.max(MIN_SEGMENT);
    if x.len() < n {
        return Err(MotionError::TooFewRows { rows: x.len(), needed: n });
    }
    if let Some(row) = x.iter().position(|x| !x.is_finite()) {
        return Err(MotionError::NotFiniteAt { row });
    }
    let hann: Vec<f64> =
        (0..n).map(|k| 0.5 - 0.5 * (2.0 * PI * k as f64 / n as f64).cos()).collect();
    let scale = 1.0 / (rate * hann.iter().map(|w| w * w).sum::<f64>());
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(n);
    let (mut windowed, mut bins) = (transform.make_input_vec(), transform.make_output_vec());
    let mut density = vec![0.0; bins.len()];
    let mut n_segments = 0_u32;
    for part in x.windows(n).step_by(n - n / 2) {
        let mean = part.iter().sum::<f64>() / n as f64;
        for ((y, x), w) in windowed.iter_mut().zip(part).zip(&hann) {
            *y = (x - mean) * w;
        }
        // The buffers are those the transform made, which is all that it checks.
        if transform.process(&mut windowed, &mut bins).is_err() {
            return Err(MotionError::TooFewRows { rows: x.len(), needed: n });
        }
        for (density, bin) in density.iter_mut().zip(&bins) {
            *density += scale * bin.norm_sqr();
        }
        n_segments += 1;
    }
    let last = density.len() - 1;
    for (bin, density) in density.iter_mut().enumerate() {
        let two_sided = bin == 0 || (bin == last && n.is_multiple_of(2));
        *density *= if two_sided { 1.0 } else { 2.0 } / f64::from(n_segments);
    }
    let frequency = (0..=last).map(|bin| bin as f64 * rate / n as f64).collect();
    Ok(Spectrum { frequency, density, n_segments })
}

/// [`welch`] of the differences of `x`, divided by the gain of differencing.
///
/// A position moves a million times as far at low frequencies as at high ones, and no window keeps
/// that from leaking. Its second differences are nearly white. The first bin is dropped, at which
/// differences know nothing.
///
/// - `differences`: how often; 0, 1 for a torque, 2 for a position
///
/// # Errors
/// Those of [`welch`].
pub fn whitened(
    x: &[f64],
    rate: f64,
    segment: usize,
    differences: u8,
) -> Result<Spectrum, MotionError> {
    let mut x = x.to_vec();
    for _ in 0..differences {
        x = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
    }
    let mut spectrum = welch(&x, rate, segment)?;
    spectrum.frequency.remove(0);
    spectrum.density.remove(0);
    for (frequency, density) in spectrum.frequency.iter().zip(&mut spectrum.density) {
        let gain = (2.0 * (PI * frequency / rate).sin()).powi(2 * i32::from(differences));
        *density /= gain;
    }
    Ok(spectrum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn density_is_that_of_scipy() {
        let value = |n: u32| {
            let k = f64::from(n);
            ((0.3 * k).sin() + 0.02 * k + 0.3 * f64::from((7 * n) % 5)) * 1e3
        };
        let x: Vec<f64> = (0..40).map(|n| value(n).round() / 1e3).collect();

        let found = welch(&x, 50.0, 16).unwrap();

        let expected = [
            0.018_605_838_834_992_47,
            0.070_306_298_213_227_54,
            0.011_861_921_479_283_352,
            0.010_268_782_808_684_75,
            0.004_506_309_271_601_106,
            0.001_382_886_948_291_548_6,
            0.022_664_301_724_427_14,
            0.017_192_269_172_148_236,
            0.000_443_682_015_076_170_66,
        ];
        assert_eq!((found.n_segments, found.frequency[1]), (4, 3.125));
        for (found, expected) in found.density.iter().zip(expected) {
            assert_relative_eq!(*found, expected, max_relative = 1e-10);
        }
    }

    #[test]
    fn whitening_shows_a_floor_that_leakage_would_hide() {
        let sweep = |k: i32| {
            let t = f64::from(k) * 0.01;
            // A ramp, whose ends do not meet, and a grain of noise without randomness.
            50.0 * t + 1e-6 * f64::from((k * 7919) % 1009) / 1009.0
        };
        let x: Vec<f64> = (0..8192).map(sweep).collect();

        let plain = welch(&x, 100.0, 1024).unwrap();
        let white = whitened(&x, 100.0, 1024, 2).unwrap();

        let at_30_hz = 307;
        let floor = 1e-12 / 12.0 * 2.0 / 100.0;
        assert!(plain.density[at_30_hz] > 100.0 * floor);
        let near = &white.density[at_30_hz - 100..at_30_hz + 100];
        let mean = near.iter().sum::<f64>() / near.len() as f64;
        assert!((0.3..3.0).contains(&(mean / floor)), "{}", mean / floor);
    }

    #[test]
    fn the_power_of_a_sine_is_half_its_square() {
        let x: Vec<f64> = (0..5000).map(|k| 3.0 * (0.2 * f64::from(k)).sin()).collect();

        let found = whitened(&x, 200.0, 500, 1).unwrap();

        let power: f64 = found.density.iter().sum::<f64>() * found.frequency[0];
        assert_relative_eq!(power, 4.5, max_relative = 0.01);
    }
}
