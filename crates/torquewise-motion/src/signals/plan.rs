//! Settings and plan of conditioning: what every part of a log goes through.

use crate::signals::butterworth::{low_pass, settle_time};
use crate::signals::clean::{Base, Even, cleaned};
use crate::signals::cutoff::above_motion;
use crate::signals::delay::TAPS;
use crate::signals::derivative::REACH;
use crate::{MotionError, Raw, Result, Signal, whole};

/// Samples per period of the cut-off that are kept.
pub(crate) const OVERSAMPLING: f64 = 8.0;
/// Auto trim: what the filter may still be off, and the share of the trajectory it may take.
const SETTLED: f64 = 0.01;
const MAX_TRIM: f64 = 0.1;
/// What the ends of a block may still matter to the rows that leave it.
const FORGOTTEN: f64 = 1e-13;

/// The cut-off of the low-pass filter that all signals pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cutoff {
    /// Eight times the frequency of the motion.
    Auto,
    /// This many \[Hz\]; half the amplitude passes there.
    Hz(f64),
}

/// How raw signals are conditioned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditioning {
    /// Of the low-pass filter.
    pub cutoff: Cutoff,
    /// Whether only so many rows are kept as the cut-off asks for: eight times it per second.
    pub thins: bool,
    /// Seconds by which the torque lags the motion: it is advanced by as much.
    pub delay: f64,
    /// Whether both ends are dropped until the filter has settled to 1 %, at most a tenth of the
    /// trajectory at each.
    pub trims: bool,
}

impl Default for Conditioning {
    /// Everything by itself: cut-off above the motion, no delay.
    fn default() -> Self {
        Self { cutoff: Cutoff::Auto, thins: true, delay: 0.0, trims: true }
    }
}

impl Conditioning {
    /// Refuses what no log could be conditioned with.
    pub(crate) fn check(&self) -> Result<()> {
        if self.delay.is_finite() && self.delay.abs() <= 1.0 {
            return Ok(());
        }
        let expected = "within 1 s: it is in seconds";
        Err(MotionError::Setting { what: "delay of the torque", value: self.delay, expected })
    }
}

/// All that is decided about a log before its rows are conditioned, so that any part of it, or
/// another trajectory of the same arm, can be conditioned alike.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalPlan {
    pub(crate) joints: Vec<String>,
    pub(crate) base: Base,
    pub(crate) settings: Conditioning,
    /// Samples per second before decimation \[Hz\].
    pub(crate) rate: f64,
    pub(crate) cutoff: f64,
    pub(crate) keep_every: usize,
    pub(crate) trim: usize,
}

impl SignalPlan {
    /// Decides on rate, cut-off and trim from a trajectory or its first part.
    ///
    /// # Errors
    /// [`MotionError`] about settings, shapes, stamps, or too few rows.
    pub fn new(raw: &Raw, settings: &Conditioning) -> Result<Self> {
        Self::with_even(raw, settings).map(|(plan, _)| plan)
    }

    /// The plan, and the clean signals it was made from.
    pub(crate) fn with_even(columns: &Raw, settings: &Conditioning) -> Result<(Self, Even)> {
        settings.check()?;
        let (base, even) = cleaned(columns)?;
        let rate = base.timing.rate;
        let cutoff = match settings.cutoff {
            Cutoff::Auto => above_motion(even.columns.of(Signal::Q), rate)?,
            Cutoff::Hz(cutoff) => cutoff,
        };
        low_pass(cutoff, rate)?;
        let span = columns.t[columns.t.len() - 1] - columns.t[0];
        let mut plan = Self {
            joints: columns.joints.clone(),
            base,
            settings: *settings,
            rate,
            cutoff,
            keep_every: if settings.thins { keep_every(cutoff, rate) } else { 1 },
            trim: 0,
        };
        let settle = settle_time(cutoff, SETTLED).min(MAX_TRIM * span);
        let seconds = if settings.trims { settle } else { 0.0 };
        // Rounding of the rate is not to cost a row.
        plan.trim = rows((seconds * rate - 1e-6).ceil()) + plan.shift_reach();
        Ok((plan, even))
    }

    /// The same plan for a part of the signals, such as their noise: what is done to it is what is
    /// done to that part when the whole is conditioned. Nothing of it is taken for a spike.
    #[must_use]
    pub fn for_part(mut self) -> Self {
        self.base.scales = [const { Vec::new() }; 4];
        self
    }

    /// Rows to each side on which a conditioned row depends, to rounding.
    pub(crate) fn reach(&self) -> usize {
        let filter = 1.3 * (settle_time(self.cutoff, FORGOTTEN) * self.rate).ceil();
        self.base.reach() + rows(filter) + self.shift_reach() + REACH
    }

    fn shift_reach(&self) -> usize {
        let delay = self.settings.delay.abs();
        if delay > 0.0 { rows((delay * self.rate).ceil()) + TAPS } else { 0 }
    }
}

/// Of so many rows one is enough once signals are filtered.
pub(crate) fn keep_every(cutoff: f64, rate: f64) -> usize {
    rows(rate / (OVERSAMPLING * cutoff)).max(1)
}

/// A whole number of rows.
pub(crate) fn rows(x: f64) -> usize {
    whole(x.clamp(0.0, 1e12))
}
