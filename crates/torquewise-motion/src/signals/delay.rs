//! Two signals → delay between them, and a signal → the same signal shifted in time.

use crate::stats::correlation;
use crate::whole;
use std::f64::consts::PI;

/// Samples to each side that a shifted value is interpolated from.
pub(crate) const TAPS: usize = 16;
/// Shape of the Kaiser window over them.
const KAISER: f64 = 9.0;

/// The shift of least error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shift {
    /// \[s\]
    pub seconds: f64,
    /// Error there.
    pub error: f64,
    /// Whether it is at an end of the range, so that the best may lie outside.
    pub at_end: bool,
}

/// The shift of least error: a coarse search over the range, then golden sections around the
/// best.
///
/// - `error`: of a shift \[s\]; values that are not finite count as worst
/// - `longest`: shifts that are tried are no longer, either way \[s\]
/// - `resolution`: of the coarse search \[s\], finer than the valley around the least error. The
///   result is right to a thousandth of it.
pub(crate) fn best_shift(error: impl Fn(f64) -> f64, longest: f64, resolution: f64) -> Shift {
    let (begin, end) = (-longest, longest);
    let steps = whole(((end - begin) / resolution).ceil());
    let step = (end - begin) / steps as f64;
    let finite_error = |seconds: f64| {
        let error = error(seconds);
        if error.is_finite() { error } else { f64::INFINITY }
    };
    let all = (0..=steps).map(|k| (k, finite_error(begin + k as f64 * step)));
    let best = all.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, f64::INFINITY));
    let seconds = begin + best.0 as f64 * step;
    if best.0 == 0 || best.0 == steps {
        return Shift { seconds, error: best.1, at_end: true };
    }
    // Golden sections: J. Kiefer, Proc. Am. Math. Soc. 4 (1953).
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (seconds - step, seconds + step);
    let (mut left, mut right) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut at_left, mut at_right) = (finite_error(left), finite_error(right));
    while high - low > 1e-3 * step && left < right {
        if at_left <= at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - ratio * (high - low);
            at_left = finite_error(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + ratio * (high - low);
            at_right = finite_error(right);
        }
    }
    let (seconds, error) = if at_left <= at_right { (left, at_left) } else { (right, at_right) };
    Shift { seconds, error, at_end: false }
}

/// x(t + `seconds`): a positive shift advances a signal that lags.
///
/// Values between samples are those of a sinc under a Kaiser window over 16 samples to each side;
/// a tone below 0.4 of the rate is right to 1e-3, below a third to 1e-4. The ends are continued
/// by odd reflection: drop as many rows there as the shift is long.
///
/// - `x`: m values at `rate` \[Hz\]
pub(crate) fn shift(x: &[f64], rate: f64, seconds: f64) -> Vec<f64> {
    shift_at(x, rate, seconds, 0..x.len())
}

/// The same at some rows only.
pub(crate) fn shift_at(
    x: &[f64],
    rate: f64,
    seconds: f64,
    rows: impl Iterator<Item = usize>,
) -> Vec<f64> {
    let samples = seconds * rate;
    let steps = samples.floor();
    let rest = samples - steps;
    if x.is_empty() || seconds == 0.0 || !samples.is_finite() {
        return rows.map(|row| x[row]).collect();
    }
    // Beyond this every value is a reflection anyway.
    let far = 2.0 * x.len() as f64;
    #[expect(clippy::cast_possible_truncation, reason = "bounded")]
    let steps = steps.clamp(-far, far) as isize;
    let taps = TAPS.cast_signed();
    let weights: Vec<f64> = (1 - taps..=taps).map(|k| weight(k as f64 - rest)).collect();
    let sum: f64 = weights.iter().sum();
    let last = x.len().cast_signed() - 1;
    let at = |row: isize| x[row.clamp(0, last).unsigned_abs()];
    // Continued by odd reflection, and by its ends beyond that.
    let reflected = |row: isize| match row {
        ..0 => 2.0 * at(0) - at(-row),
        _ if row > last => 2.0 * at(last) - at(2 * last - row),
        _ => at(row),
    };
    let rows: Vec<isize> = rows.map(|row| row.cast_signed() + steps).collect();
    // Tap by tap, so that no addition waits for the one before.
    let mut shifted = vec![0.0; rows.len()];
    for (k, w) in (1 - taps..=taps).zip(&weights) {
        shifted.iter_mut().zip(&rows).for_each(|(x, row)| *x += w * reflected(row + k));
    }
    shifted.into_iter().map(|x| x / sum).collect()
}

fn weight(u: f64) -> f64 {
    let inside = 1.0 - (u / TAPS as f64).powi(2);
    if inside < 0.0 {
        return 0.0;
    }
    let sinc = if u.abs() < 1e-12 { 1.0 } else { (PI * u).sin() / (PI * u) };
    sinc * bessel(KAISER * inside.sqrt()) / bessel(KAISER)
}

fn bessel(x: f64) -> f64 {
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..40 {
        term *= (0.5 * x / f64::from(k)).powi(2);
        sum += term;
    }
    sum
}

/// How far a measured signal lags a derived one, such as q̇ from the log behind the derivative of
/// q: the shift that leaves the least after the best gain and offset.
///
/// - `derived`, `measured`: m values at `rate` \[Hz\], of the same bandwidth
/// - `longest`: lag that is looked for, either way \[s\]
/// - returns: the lag, positive if `measured` comes late; `error` is one less the squared
///   correlation. `None` if one of them does not move, or they are too short.
pub(crate) fn lag(derived: &[f64], measured: &[f64], rate: f64, longest: f64) -> Option<Shift> {
    let edge = longest * rate + TAPS as f64;
    let n = derived.len().min(measured.len());
    if n < 16 || 4.0 * edge > n as f64 {
        return None;
    }
    let middle = whole(edge)..n - whole(edge);
    let reference = &derived[middle.clone()];
    let unlike = |seconds: f64| {
        let shifted = shift_at(measured, rate, seconds, middle.clone());
        1.0 - correlation(reference, &shifted).powi(2)
    };
    Some(best_shift(unlike, longest, 0.5 / rate)).filter(|found| found.error.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    fn tone(share: f64, late: f64) -> Vec<f64> {
        (0..600).map(|k| (2.0 * PI * share * (f64::from(k) - late) + 0.3).sin()).collect()
    }

    #[test]
    fn a_shifted_tone_is_that_tone_later() {
        for (share, error) in [(0.01, 1e-4), (0.2, 1e-4), (0.33, 1e-4), (0.4, 1e-3)] {
            for samples in [0.5, -2.3, 7.0] {
                let shifted = shift(&tone(share, 0.0), 100.0, samples / 100.0);

                let expected = tone(share, -samples);
                for row in 30..570 {
                    assert_abs_diff_eq!(shifted[row], expected[row], epsilon = error);
                }
            }
        }
    }

    #[test]
    fn a_lag_is_found_below_a_sample() {
        let mixed = |late: f64| -> Vec<f64> {
            tone(0.013, late).iter().zip(tone(0.05, late)).map(|(a, b)| a + 0.4 * b).collect()
        };
        let measured: Vec<f64> = mixed(1.37).iter().map(|x| 0.8 * x + 0.2).collect();

        let found = lag(&mixed(0.0), &measured, 100.0, 0.1).unwrap();

        assert_abs_diff_eq!(found.seconds, 0.0137, epsilon = 2e-5);
        assert!(!found.at_end && found.error < 1e-6);
    }

    #[test]
    fn the_least_error_is_found_among_several_valleys_and_at_the_end_is_told() {
        let error = |s: f64| (s - 0.0123).powi(2) + 1e-3 * (1.0 - (200.0 * (s - 0.0123)).cos());

        let found = best_shift(error, 0.1, 0.005);
        let at_end = best_shift(|s| s, 0.1, 0.01);

        assert_abs_diff_eq!(found.seconds, 0.0123, epsilon = 5e-6);
        assert_eq!((at_end.seconds, at_end.at_end), (-0.1, true));
    }

    #[test]
    fn what_does_not_move_has_no_lag() {
        assert_eq!(lag(&tone(0.1, 0.0), &[1.0; 600], 100.0, 0.1), None);
    }
}
