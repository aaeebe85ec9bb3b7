//! Report of conditioning: everything that was found, done and left out.

use crate::repairs::counted;
use crate::signals::clean::Outliers;
use crate::signals::delay::Shift;
use crate::signals::noise::Quantisation;
use crate::signals::resample::Timing;
use crate::{Raw, Signal, ends, median};
use std::fmt;
use std::ops::Range;

/// A signal of fewer levels than this is called coarse.
const COARSE_LEVELS: f64 = 32.0;
/// A quantisation step of more than this share of the deviation is called coarse.
const COARSE_SHARE: f64 = 0.1;

/// A signal that is exactly at one of its ends in more than this part of its rows, in so many runs of
/// them, was cut off there; one of fewer levels is there by itself.
const MOST_AT_ENDS: f64 = 0.05;
const LEAST_RUNS: usize = 3;
const LEAST_LEVELS: f64 = 1000.0;

/// What is known of one signal of one joint.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalReport {
    /// q, dq, ddq or tau.
    pub signal: &'static str,
    /// Name of the joint.
    pub joint: String,
    /// Standard deviation of the white noise before the filter, in the unit of the signal: in rows at
    /// standstill, where there are enough.
    pub noise: f64,
    /// The step its raw values are quantised to.
    pub quantisation: Option<Quantisation>,
    /// Part of its raw rows that are exactly at its smallest or its largest value, and in how many runs
    /// of two and more.
    pub at_ends: (f64, usize),
}

impl SignalReport {
    /// Whether so few levels are left that the signal may be useless.
    pub fn is_coarse(&self) -> bool {
        let coarse =
            |q: Quantisation| q.levels < COARSE_LEVELS || q.share_of_deviation > COARSE_SHARE;
        self.quantisation.is_some_and(coarse)
    }

    /// Whether a limit cut it off.
    pub fn is_cut_off(&self) -> bool {
        let (part, runs) = self.at_ends;
        let is_fine = self.quantisation.is_none_or(|q| q.levels >= LEAST_LEVELS);
        // A signal that is at its ends in all rows has two values.
        is_fine && part > MOST_AT_ENDS && part < 1.0 && runs >= LEAST_RUNS
    }
}

/// Where a cut-off comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CutoffFrom {
    /// It was set.
    Setting,
    /// It is eight times the band of the motion.
    Motion,
    /// Torque of held-out rows is predicted best with it (E19).
    HeldOut,
}

impl fmt::Display for CutoffFrom {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Setting => "as set",
            Self::Motion => {
                "eight times the frequency of the motion; where a chain is fitted, others are tried"
            }
            Self::HeldOut => "at which torque of held-out rows is predicted best",
        })
    }
}

/// What was found, done and left out in the conditioning of one trajectory.
#[derive(Clone, Debug, PartialEq)]
pub struct ConditionReport {
    /// Rows of the raw log.
    pub rows_in: usize,
    /// Rows that came out.
    pub rows_out: usize,
    /// Rate and jitter of the raw stamps.
    pub timing: Timing,
    /// Samples per second that came out \[Hz\].
    pub rate_out: f64,
    /// Cut-off of the low-pass filter \[Hz\].
    pub cutoff: f64,
    /// Where it comes from.
    pub cutoff_from: CutoffFrom,
    /// Spikes that were replaced, by signal and joint; none without.
    pub outliers: Vec<Outliers>,
    /// Noise and quantisation, by signal and joint.
    pub signals: Vec<SignalReport>,
    /// How far the measured velocity of each joint lags the derivative of its position, n; empty
    /// if no velocity was measured, `None` for a joint that does not move.
    pub dq_lag: Vec<Option<Shift>>,
    /// Measured velocity of each joint over the derivative of its position, by least squares, n;
    /// empty if no velocity was measured, `None` for a joint that does not move.
    pub dq_gain: Vec<Option<f64>>,
    /// Joints whose levels and velocity are those of another piece, where they move more.
    pub seen_elsewhere: Vec<usize>,
    /// The longest time \[s\] for which the torque of each joint, which else changes from row to row, does
    /// not while the joint goes on by a part of its way, n; empty without torque.
    pub stuck: Vec<f64>,
    /// Seconds by which the torque was advanced.
    pub delay: f64,
    /// Seconds dropped at each end.
    pub trimmed: f64,
}

impl ConditionReport {
    /// Looks for torques that are stuck in a piece.
    pub fn see_stuck(&mut self, raw: &Raw) {
        let found: Vec<f64> =
            (0..raw.of(Signal::Tau).len()).map(|joint| stuck(raw, joint)).collect();
        self.stuck.resize(found.len(), 0.0);
        self.stuck.iter_mut().zip(found).for_each(|(own, found)| *own = own.max(found));
    }

    /// Levels and measured velocity of a joint as they are in another piece, where it moves more.
    pub fn see_joint(&mut self, joint: usize, other: &Self) {
        // The first are those of positions.
        let name = other.signals.get(joint).map(|q| &q.joint);
        for own in self.signals.iter_mut().filter(|own| Some(&own.joint) == name) {
            let mut of_joint = other.signals.iter().filter(|other| Some(&other.joint) == name);
            if let Some(other) = of_joint.find(|other| other.signal == own.signal) {
                own.quantisation = other.quantisation;
            }
        }
        see(&mut self.dq_lag, &other.dq_lag, joint);
        see(&mut self.dq_gain, &other.dq_gain, joint);
        self.seen_elsewhere.push(joint);
    }
}

/// The longest time \[s\] for which a torque that changes in nine of ten other rows does not, while its
/// joint goes on by a tenth of its way; one at its limit is cut off.
fn stuck(raw: &Raw, joint: usize) -> f64 {
    const MOST_ROWS: f64 = 0.9;
    const PART: f64 = 0.1;
    let (tau, q) = (&raw.of(Signal::Tau)[joint], &raw.of(Signal::Q)[joint]);
    let ends = |x: &[f64]| ends(x.iter().copied());
    let way = |rows: &Range<usize>| ends(&q[rows.clone()])[1] - ends(&q[rows.clone()])[0];
    let runs = tau.chunk_by(|a, b| a.to_bits() == b.to_bits()).scan(0, |begin, run| {
        let rows = *begin..*begin + run.len();
        *begin = rows.end;
        Some(rows)
    });
    let (whole, limits, runs) = (way(&(0..q.len())), ends(tau), runs.collect::<Vec<_>>());
    let counts = |rows: &&Range<usize>| {
        let (others, value) = (tau.len() - rows.len(), tau[rows.start]);
        2 * others > tau.len()
            && runs.len() as f64 > MOST_ROWS * others as f64
            && (value == 0.0 || !limits.contains(&value))
            && way(rows) > PART * whole
    };
    let times = runs.iter().filter(counts);
    times.map(|rows| raw.t[rows.end - 1] - raw.t[rows.start]).fold(0.0, f64::max)
}

/// What is known of a joint elsewhere takes the place of its own.
fn see<T: Copy>(own: &mut [Option<T>], other: &[Option<T>], joint: usize) {
    if let (Some(own), Some(Some(other))) = (own.get_mut(joint), other.get(joint)) {
        *own = Some(*other);
    }
}

impl fmt::Display for ConditionReport {
    /// One line per finding, without a last line break.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Timing { rate, jitter, longest_step, .. } = self.timing;
        write!(f, "{} rows at {rate:.1} Hz", self.rows_in)?;
        if !self.timing.is_even() {
            write!(f, ", made even: jitter {:.2} %", 100.0 * jitter)?;
        }
        if longest_step * rate > 2.5 {
            write!(f, ", longest step {longest_step:.3} s")?;
        }
        let ratio = self.timing.receive_ratio();
        if ratio.is_some_and(|ratio| (0.5..2.0).contains(&ratio)) {
            write!(f, ", as of late receipt from an even device")?;
        }
        write!(f, " -> {} rows at {:.1} Hz", self.rows_out, self.rate_out)?;
        write!(f, "\ncut-off {:.2} Hz, {}", self.cutoff, self.cutoff_from)?;
        if self.trimmed > 0.0 {
            write!(f, "\n{:.2} s dropped at each end", self.trimmed)?;
        }
        if self.delay != 0.0 {
            let is = if self.delay > 0.0 { "late: advanced" } else { "early: delayed" };
            write!(f, "\ntau {:.1} ms {is}", 1e3 * self.delay.abs())?;
        }
        for Outliers { signal, joint, rows } in &self.outliers {
            let outliers = counted(rows.len() as u64, "outlier", "replaced");
            write!(f, "\n{signal} of {joint}: {outliers}")?;
        }
        let coarse = self.signals.iter().filter(|report| report.is_coarse());
        for SignalReport { signal, joint, quantisation, .. } in coarse {
            let Some(q) = quantisation else { continue };
            let Quantisation { step, levels, .. } = q;
            write!(f, "\n{signal} of {joint} is quantised to {step:.3e}: {levels} levels, ")?;
            write!(f, "{:.0} % of its deviation", 100.0 * q.share_of_deviation)?;
        }
        let lags = || self.dq_lag.iter().flatten();
        let mut seconds: Vec<f64> = lags().map(|lag| lag.seconds).collect();
        if !seconds.is_empty() {
            let bound = if lags().any(|lag| lag.at_end) { "at least " } else { "" };
            let median = 1e3 * median(&mut seconds);
            let (way, size) = if median < 0.0 { ("leads", -median) } else { ("lags", median) };
            write!(f, "\nmeasured dq {way} d(q)/dt by {bound}{size:.1} ms")?;
        }
        Ok(())
    }
}
