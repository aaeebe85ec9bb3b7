//! Butterworth low-pass filters as second-order sections.

use crate::error::{MotionError, Result};
use std::f64::consts::PI;

pub(crate) const MAX_ORDER: usize = 24;

/// One second-order section: H(z) = (b₀ + b₁z⁻¹ + b₂z⁻²) / (1 + a₁z⁻¹ + a₂z⁻²).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Section {
    pub(crate) b: [f64; 3],
    pub(crate) a: [f64; 3],
}

/// Butterworth low-pass filter by the pre-warped bilinear transform.
///
/// - `order`: 1 to [`MAX_ORDER`]
/// - `cutoff`: frequency where one pass has the gain 1/√2 \[Hz\]
/// - `rate`: samples per second \[Hz\]
/// - returns: ⌈order/2⌉ sections, the one nearest the unit circle last, all gain in the first
///
/// Source: A. Oppenheim, R. Schafer, Discrete-Time Signal Processing, ch. 7. Checked against:
/// scipy.signal.butter, of the same order of sections.
pub(crate) fn low_pass(order: usize, cutoff: f64, rate: f64) -> Result<Vec<Section>> {
    if order == 0 || order > MAX_ORDER {
        return Err(MotionError::FilterOrder { order, limit: MAX_ORDER });
    }
    let reachable = cutoff.is_finite() && rate.is_finite() && cutoff > 0.0 && cutoff < 0.5 * rate;
    // Below this the poles round to 1.
    if !reachable || cutoff < 1e-7 * rate {
        return Err(MotionError::Cutoff { cutoff, rate });
    }
    let warped = (PI * cutoff / rate).tan();
    let mut sections = Vec::with_capacity(order.div_ceil(2));
    let mut gain = 1.0;
    if order % 2 == 1 {
        let pole = (1.0 - warped) / (1.0 + warped);
        gain *= warped / (1.0 + warped);
        sections.push(Section { b: [1.0, 2.0, 1.0], a: [1.0, -pole, 0.0] });
    }
    // Pole pairs from the real axis outwards: −ω(cos θ ± j sin θ), which is by rising radius.
    for pair in 0..order / 2 {
        let steps = 2 * pair + 1 + order % 2;
        let cosine = (PI * steps as f64 / (2 * order) as f64).cos();
        let norm = 1.0 + 2.0 * warped * cosine + warped * warped;
        let a1 = 2.0 * (warped * warped - 1.0) / norm;
        let a2 = (1.0 - 2.0 * warped * cosine + warped * warped) / norm;
        gain *= warped * warped / norm;
        sections.push(Section { b: [1.0, 2.0, 1.0], a: [1.0, a1, a2] });
    }
    if order % 2 == 1
        && let Some(last) = sections.last_mut()
    {
        last.b = [1.0, 1.0, 0.0];
    }
    if let Some(first) = sections.first_mut() {
        first.b = first.b.map(|b| gain * b);
    }
    Ok(sections)
}

/// Time after which the step response of [`low_pass`] is within `share` of its end \[s\]: that of
/// its slowest pole.
pub(crate) fn settle_time(order: usize, cutoff: f64, share: f64) -> f64 {
    let damping = (PI / (2.0 * order.max(1) as f64)).sin();
    (1.0 / share).ln() / (2.0 * PI * cutoff * damping)
}

/// Runs `x` through the sections in place; `state` is one pair per section and is carried on.
pub(crate) fn sosfilt(sections: &[Section], x: &mut [f64], state: &mut [[f64; 2]]) {
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
pub(crate) fn sosfilt_zi(sections: &[Section]) -> Vec<[f64; 2]> {
    let mut scale = 1.0;
    let mut states = Vec::with_capacity(sections.len());
    for Section { b, a } in sections {
        let sum_a = 1.0 + a[1] + a[2];
        let (c1, c2) = (b[1] - a[1] * b[0], b[2] - a[2] * b[0]);
        let first = (c1 + c2) / sum_a;
        let second = (1.0 + a[1]) * first - c1;
        states.push([scale * first, scale * second]);
        scale *= (b[0] + b[1] + b[2]) / sum_a;
    }
    states
}

#[cfg(test)]
mod tests;
