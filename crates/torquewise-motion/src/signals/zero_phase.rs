//! Zero-phase filtering: forwards and backwards, so that nothing is delayed.

use crate::error::{MotionError, Result};
use crate::signals::butterworth::{LowPass, sosfilt, sosfilt_zi};

/// Samples by which [`filtfilt`] continues a signal at each end: three times the taps.
const PADDING: usize = 15;

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
    if let Some(row) = x.iter().position(|x| !x.is_finite()) {
        return Err(MotionError::NotFiniteAt { row });
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
