//! From spectra of q and τ to cut-off frequency: up to where a signal stands above its noise.

use crate::MotionError;
use crate::signals::noise::{median, quantisation};
use crate::signals::spectrum::{Spectrum, welch, whitened};
use std::fmt;

/// Lowest cut-off that is ever chosen \[Hz\].
pub const LOWEST: f64 = 0.5;
/// Highest cut-off that is ever chosen, as a share of the rate.
pub const HIGHEST: f64 = 0.4;

/// Density over floor at which signal and noise are equally strong: the Wiener gain (S − N)/S is
/// one half there, as is the gain of the zero-phase filter at its cut-off.
const CLEAR: f64 = 2.0;
/// Density below this share of the highest is no content, whatever the floor.
const EMPTY: f64 = 1e-8;
/// The signal has to stay in its noise up to this multiple of the cut-off.
const FOR_GOOD: f64 = std::f64::consts::SQRT_2;
/// Share of the power of the speed that counts as motion.
const MOTION_SHARE: f64 = 0.95;
/// A common cut-off is this many times the frequency of the motion at least and at most.
const MOTION_MARGIN: (f64, f64) = (5.0, 20.0);
/// Length of a segment \[s\].
const SEGMENT: f64 = 4.0;

/// Which of the signals: what is asked of its spectrum differs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A position, which matters by its acceleration.
    Position,
    /// A torque.
    Torque,
}

/// Why a cut-off is what it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// Above it the signal is lost in its noise.
    Noise,
    /// Above it the log holds nothing: it was filtered before it was written, or has no noise.
    Empty,
    /// The signal stands above its noise all the way, so the bound by the rate holds.
    Rate,
    /// The signal is lost in its noise from the start, so the lowest cut-off holds.
    Lost,
    /// The signal does not move.
    Constant,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Noise => "above it the signal is lost in noise",
            Self::Empty => "above it the log holds nothing",
            Self::Rate => "the signal stands above its noise as far as the rate allows",
            Self::Lost => "the signal is lost in noise from the start",
            Self::Constant => "the signal does not move",
        })
    }
}

/// Where one signal is lost in its noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignalCutoff {
    /// \[Hz\]
    pub cutoff: f64,
    /// Why it is there.
    pub reason: Reason,
    /// Density of the noise, in the unit of the signal squared per Hz.
    pub floor: f64,
    /// Share of the signal's power above the cut-off, slow drift over segments not counted.
    pub removed: f64,
    /// 95 % of the power of the signal's speed below the cut-off is below this \[Hz\].
    pub motion: f64,
}

/// Where a signal is lost in its noise.
///
/// The floor is the median density over the upper half of the band, or that of a quantised signal
/// if it is higher. The cut-off is the first frequency above the densest one from which the
/// density, smoothed by a running median, stays below twice the floor for half an octave.
/// A narrow line above, such as that of a power supply or a structure, is not waited for.
///
/// - `x`: m values at `rate` \[Hz\], without spikes
///
/// # Errors
/// [`MotionError::TooFewRows`] below 64 rows, or [`MotionError::NotFiniteAt`].
pub fn signal_cutoff(x: &[f64], rate: f64, kind: Kind) -> Result<SignalCutoff, MotionError> {
    if x.len() < 64 {
        return Err(MotionError::TooFewRows { rows: x.len(), needed: 64 });
    }
    if !rate.is_finite() || rate <= 2.0 * LOWEST {
        let expected = "above 1 Hz to choose a cut-off, or set one";
        return Err(MotionError::Setting { what: "rate of the log", value: rate, expected });
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bounded below")]
    let segment = ((SEGMENT * rate).min(x.len() as f64 / 4.0) as usize).clamp(16, x.len() / 2);
    let differences = if kind == Kind::Position { 2 } else { 1 };
    let spectrum = whitened(x, rate, segment, differences)?;
    let upper = (HIGHEST * rate).max(LOWEST);
    let (low, high) = x.iter().fold((x[0], x[0]), |(low, high), x| (low.min(*x), high.max(*x)));
    if high - low <= 16.0 * f64::EPSILON * low.abs().max(high.abs()) {
        let (reason, none) = (Reason::Constant, 0.0);
        return Ok(SignalCutoff {
            cutoff: upper,
            reason,
            floor: none,
            removed: none,
            motion: none,
        });
    }
    let floor = floor(&spectrum, x, rate);
    let (cutoff, reason) = lost_at(&spectrum, floor, kind, upper);
    let power = |keep: &dyn Fn(f64) -> bool| -> f64 {
        bins(&spectrum).filter(|(f, _)| keep(*f)).map(|(_, s)| s).sum()
    };
    let removed = power(&|f| f > cutoff) / power(&|_| true);
    Ok(SignalCutoff { cutoff, reason, floor, removed, motion: motion(x, rate, cutoff)? })
}

fn bins(spectrum: &Spectrum) -> impl Iterator<Item = (f64, f64)> {
    spectrum.frequency.iter().copied().zip(spectrum.density.iter().copied())
}

fn floor(spectrum: &Spectrum, x: &[f64], rate: f64) -> f64 {
    let upper_half = |f: f64| f > 0.25 * rate && f < 0.475 * rate;
    let mut densities: Vec<f64> =
        bins(spectrum).filter(|(f, _)| upper_half(*f)).map(|(_, s)| s).collect();
    // Rounding to a step is an error of variance step²/12, spread over half the rate.
    let rounding = quantisation(x).map_or(0.0, |q| q.step * q.step / (6.0 * rate));
    median(&mut densities).max(rounding)
}

/// The frequency from which the signal is lost in its noise, and why.
fn lost_at(spectrum: &Spectrum, floor: f64, kind: Kind, upper: f64) -> (f64, Reason) {
    let smooth = smoothed(spectrum);
    // What counts in the torque: of a position, its acceleration.
    let weight = |f: f64| if kind == Kind::Position { f.powi(4) } else { 1.0 };
    let content = |k: usize| smooth[k] * weight(spectrum.frequency[k]);
    let clear = |k: usize| smooth[k] > CLEAR * floor;
    let n = smooth.len();
    let densest = (0..n).filter(|k| clear(*k)).max_by(|a, b| content(*a).total_cmp(&content(*b)));
    let Some(densest) = densest else { return (LOWEST, Reason::Lost) };
    let limit = EMPTY * content(densest);
    let present = |k: usize| clear(k) && content(k) > limit;
    // A position is densest at its slowest motion, which content by acceleration may overlook.
    let mut candidate = (0..n).find(|k| clear(*k)).unwrap_or(densest);
    while candidate < n {
        let frequency = spectrum.frequency[candidate];
        if frequency >= upper {
            return (upper, Reason::Rate);
        }
        let stretch = (candidate..n)
            .take_while(|k| *k == candidate || spectrum.frequency[*k] <= FOR_GOOD * frequency);
        match stretch.filter(|k| present(*k)).last() {
            Some(last) => candidate = last + 1,
            None if frequency < LOWEST => return (LOWEST, Reason::Noise),
            None if clear(candidate) => return (frequency, Reason::Empty),
            None => return (frequency, Reason::Noise),
        }
    }
    (upper, Reason::Rate)
}

/// Running median over a tenth of the frequency to each side, one bin at least: a narrow line
/// does not pass, the flank of a wide hump stays where it is.
fn smoothed(spectrum: &Spectrum) -> Vec<f64> {
    let density = &spectrum.density;
    let window = |k: usize| {
        let reach = (k / 10).max(1);
        k.saturating_sub(reach)..(k + reach + 1).min(density.len())
    };
    (0..density.len()).map(|k| median(&mut density[window(k)].to_vec())).collect()
}

/// Frequency below which 95 % of the power of the speed lies, of what is below `cutoff`; from one
/// segment, as motion may be slower than those of the spectrum.
fn motion(x: &[f64], rate: f64, cutoff: f64) -> Result<f64, MotionError> {
    let speed: Vec<f64> = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let spectrum = welch(&speed, rate, speed.len())?;
    let total: f64 = bins(&spectrum).filter(|(f, _)| *f <= cutoff).map(|(_, s)| s).sum();
    let mut below = 0.0;
    for (frequency, power) in bins(&spectrum) {
        below += power;
        if below >= MOTION_SHARE * total {
            return Ok(frequency);
        }
    }
    Ok(cutoff)
}

/// One cut-off for all signals, and what it was chosen from.
#[derive(Clone, Debug, PartialEq)]
pub struct CutoffChoice {
    /// \[Hz\]
    pub cutoff: f64,
    /// Which signal decided.
    pub decided: Decided,
    /// Of the position of each joint, n.
    pub q: Vec<SignalCutoff>,
    /// Of the torque of each joint, n, or none.
    pub tau: Vec<SignalCutoff>,
}

/// What decides on the common cut-off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decided {
    /// Above it the acceleration of most joints would be noise.
    Position,
    /// Above it the torque of most joints is noise.
    Torque,
    /// Five times the motion: torque is noisier, but a lower one would cut the motion.
    MotionLeast,
    /// Twenty times the motion: what is above is vibration, and no motion of rigid bodies.
    MotionMost,
    /// No joint moves.
    Nothing,
    /// Not the spectra: with this one torque of held-out rows was predicted better.
    HeldOut,
}

impl fmt::Display for Decided {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Position => "above it the acceleration of most joints is noise",
            Self::Torque => "above it the torque of most joints is noise",
            Self::MotionLeast => "five times the frequency of the motion, torque is noisier",
            Self::MotionMost => "twenty times the frequency of the motion, vibration is above",
            Self::Nothing => "no joint moves",
            Self::HeldOut => {
                "torque of held-out rows is predicted better than with that of the spectra"
            }
        })
    }
}

/// One cut-off for position and torque of all joints, which must pass the same filter.
///
/// It is the middle one of the joints' torque, but within five and twenty times the frequency of
/// the motion, and no more than the middle one of their positions: beyond that the acceleration is
/// noise, which would bias the fit, while noise in the torque only blurs it.
///
/// - `rate`: of the signals the choices were made from \[Hz\]
///
/// Source: ten times the bandwidth of the motion, between the two, is usual in the identification
/// of robots, see A. Janot et al., IEEE Trans. Control Syst. Technol. 22 (2014).
pub fn choose(q: Vec<SignalCutoff>, tau: Vec<SignalCutoff>, rate: f64) -> CutoffChoice {
    let motion = middle(&q, |choice| choice.motion);
    let of_q = middle(&q, |choice| choice.cutoff);
    let of_tau = middle(&tau, |choice| choice.cutoff);
    let (cutoff, decided) = match (motion, of_q) {
        (Some(motion), Some(of_q)) => {
            let (least, most) = (MOTION_MARGIN.0 * motion, MOTION_MARGIN.1 * motion);
            let wanted = match of_tau {
                Some(tau) if tau < least => (least, Decided::MotionLeast),
                Some(tau) if tau <= most => (tau, Decided::Torque),
                _ => (most, Decided::MotionMost),
            };
            if wanted.0 < of_q { wanted } else { (of_q, Decided::Position) }
        }
        _ => (HIGHEST * rate, Decided::Nothing),
    };
    let cutoff = cutoff.clamp(LOWEST, (HIGHEST * rate).max(LOWEST));
    CutoffChoice { cutoff, decided, q, tau }
}

/// Middle one of the joints that move, the geometric mean of two.
fn middle(choices: &[SignalCutoff], of: impl Fn(&SignalCutoff) -> f64) -> Option<f64> {
    let moving = choices.iter().filter(|choice| choice.reason != Reason::Constant);
    let mut values: Vec<f64> = moving.map(of).collect();
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    Some((values[last / 2] * values[last.div_ceil(2)]).sqrt())
}

#[cfg(test)]
mod tests;
