//! Butterworth low-pass filters as second-order sections, run forwards and backwards, so that nothing
//! is delayed.

use crate::{MotionError, Result};
use std::f64::consts::PI;

/// One second-order section: H(z) = (b₀ + b₁z⁻¹ + b₂z⁻²) / (1 + a₁z⁻¹ + a₂z⁻²).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Section {
    pub(crate) b: [f64; 3],
    pub(crate) a: [f64; 3],
}

/// The filter that all signals pass, of order four.
pub(crate) type LowPass = [Section; 2];

/// Samples by which [`filtfilt`] continues a signal at each end: three times the taps.
const PADDING: usize = 15;

/// Butterworth low-pass filter of order four by the pre-warped bilinear transform.
///
/// - `cutoff`: frequency where one pass has the gain 1/√2 \[Hz\]
/// - `rate`: samples per second \[Hz\]
/// - returns: two sections, the one nearest the unit circle last, all gain in the first
///
/// Source: A. Oppenheim, R. Schafer, Discrete-Time Signal Processing, ch. 7. Checked against:
/// scipy.signal.butter, by signals that went through it.
pub(crate) fn low_pass(cutoff: f64, rate: f64) -> Result<LowPass> {
    let reachable = cutoff.is_finite() && rate.is_finite() && cutoff > 0.0 && cutoff < 0.5 * rate;
    // Below this the poles round to 1.
    if !reachable || cutoff < 1e-7 * rate {
        return Err(MotionError::Cutoff { cutoff, rate });
    }
    let warped = (PI * cutoff / rate).tan();
    let mut gain = 1.0;
    // Pole pairs from the real axis outwards: −ω(cos θ ± j sin θ), which is by rising radius.
    let mut sections = [1.0, 3.0].map(|steps: f64| {
        let cosine = (PI * steps / 8.0).cos();
        let norm = 1.0 + 2.0 * warped * cosine + warped * warped;
        let a1 = 2.0 * (warped * warped - 1.0) / norm;
        let a2 = (1.0 - 2.0 * warped * cosine + warped * warped) / norm;
        gain *= warped * warped / norm;
        Section { b: [1.0, 2.0, 1.0], a: [1.0, a1, a2] }
    });
    sections[0].b = sections[0].b.map(|b| gain * b);
    Ok(sections)
}

/// Time after which the step response of [`low_pass`] is within `share` of its end \[s\]: that of
/// its slowest pole.
pub(crate) fn settle_time(cutoff: f64, share: f64) -> f64 {
    let damping = (PI / 8.0).sin();
    (1.0 / share).ln() / (2.0 * PI * cutoff * damping)
}

/// Runs `x` through the sections in place; `state` is one pair per section and is carried on.
fn sosfilt(sections: &LowPass, x: &mut [f64], state: &mut [[f64; 2]; 2]) {
    for (section, state) in sections.iter().zip(state) {
        let ([b0, b1, b2], [_, a1, a2]) = (section.b, section.a);
        let [mut first, mut second] = *state;
        for value in x.iter_mut() {
            let input = *value;
            let output = b0 * input + first;
            first = b1 * input - a1 * output + second;
            second = b2 * input - a2 * output;
            *value = output;
        }
        *state = [first, second];
    }
}

/// State in which a filter that has always seen 1 stands, one pair per section.
///
/// Checked against: `scipy.signal.sosfilt_zi`.
fn sosfilt_zi(sections: &LowPass) -> [[f64; 2]; 2] {
    let mut scale = 1.0;
    sections.map(|Section { b, a }| {
        let sum_a = 1.0 + a[1] + a[2];
        let (c1, c2) = (b[1] - a[1] * b[0], b[2] - a[2] * b[0]);
        let first = (c1 + c2) / sum_a;
        let second = (1.0 + a[1]) * first - c1;
        let state = [scale * first, scale * second];
        scale *= (b[0] + b[1] + b[2]) / sum_a;
        state
    })
}

/// Runs `x` through the sections forwards and backwards, in place.
///
/// Both ends are continued by their odd reflection over 15 samples. The gain is that of
/// the filter squared: one half at the cut-off of a Butterworth filter.
///
/// Source: F. Gustafsson, IEEE Trans. Signal Process. 44 (1996). Checked against:
/// scipy.signal.sosfiltfilt.
pub(crate) fn filtfilt(sections: &LowPass, x: &mut [f64]) -> Result<()> {
    let (pad, n) = (PADDING, x.len());
    if n <= pad {
        return Err(MotionError::TooFewRows { rows: n, needed: pad + 1 });
    }
    let (first, last) = (x[0], x[n - 1]);
    let mut padded = Vec::with_capacity(n + 2 * pad);
    padded.extend((1..=pad).rev().map(|k| 2.0 * first - x[k]));
    padded.extend_from_slice(x);
    padded.extend((1..=pad).map(|k| 2.0 * last - x[n - 1 - k]));

    let zi = sosfilt_zi(sections);
    for _ in 0..2 {
        let start = padded[0];
        let mut state = zi.map(|pair| pair.map(|z| z * start));
        sosfilt(sections, &mut padded, &mut state);
        padded.reverse();
    }
    x.copy_from_slice(&padded[pad..pad + n]);
    Ok(())
}

#[cfg(test)]
mod tests;
