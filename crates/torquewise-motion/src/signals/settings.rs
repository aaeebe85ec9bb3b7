//! From wishes to Conditioning: how raw signals are to be conditioned.

use crate::MotionError;
use crate::signals::butterworth::low_pass;

/// The cut-off of the low-pass filter that all signals pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cutoff {
    /// Eight times the frequency of the motion.
    Auto,
    /// This many \[Hz\]; half the amplitude passes there.
    Hz(f64),
    /// No filter.
    Off,
}

/// Where velocity and acceleration come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Derive {
    /// Both from the filtered position, which no sensor or driver has delayed.
    FromPosition,
    /// Velocity as measured and filtered, acceleration from it.
    FromVelocity,
    /// Both as measured and filtered.
    Measured,
}

/// How much is dropped at both ends, where filters have not settled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trim {
    /// Until the filter has settled to 1 %, at most a tenth of the trajectory at each end.
    Auto,
    /// This many seconds at each end.
    Seconds(f64),
}

/// How raw signals are conditioned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditioning {
    /// Of the low-pass filter.
    pub cutoff: Cutoff,
    /// Order of the Butterworth filter, which is run forwards and backwards.
    pub order: usize,
    /// Whether spikes of one to three rows are replaced.
    pub outliers: bool,
    /// Rows per second to keep, about; none for eight times the cut-off or more.
    pub rate: Option<f64>,
    /// Seconds by which the torque lags the motion: it is advanced by as much.
    pub delay: f64,
    /// Where velocity and acceleration come from.
    pub derive: Derive,
    /// What is dropped at both ends.
    pub trim: Trim,
}

impl Default for Conditioning {
    /// Everything by itself: cut-off above the motion, order 4, no delay.
    fn default() -> Self {
        Self {
            cutoff: Cutoff::Auto,
            order: 4,
            outliers: true,
            rate: None,
            delay: 0.0,
            derive: Derive::FromPosition,
            trim: Trim::Auto,
        }
    }
}

impl Conditioning {
    /// Refuses what no log could be conditioned with.
    pub(crate) fn check(&self) -> Result<(), MotionError> {
        let setting = |what, value, expected| Err(MotionError::Setting { what, value, expected });
        // At this rate any order is a filter, so only the order is judged.
        low_pass(self.order, 1.0, 4.0)?;
        if let Some(rate) = self.rate.filter(|rate| !(rate.is_finite() && *rate > 0.0)) {
            return setting("rate to keep", rate, "above 0 Hz");
        }
        if !self.delay.is_finite() || self.delay.abs() > 1.0 {
            return setting("delay of the torque", self.delay, "within 1 s: it is in seconds");
        }
        match self.trim {
            Trim::Seconds(s) if !(0.0..1e9).contains(&s) => {
                setting("trim", s, "0 s or more, and less than half the trajectory")
            }
            _ => Ok(()),
        }
    }
}
