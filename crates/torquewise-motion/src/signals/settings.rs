//! Settings of conditioning.

use crate::error::{MotionError, Result};

/// Order of the Butterworth filter, which is run forwards and backwards.
pub(crate) const ORDER: usize = 4;

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
    /// Rows per second to keep, about; none for eight times the cut-off or more.
    pub rate: Option<f64>,
    /// Seconds by which the torque lags the motion: it is advanced by as much.
    pub delay: f64,
    /// What is dropped at both ends.
    pub trim: Trim,
}

impl Default for Conditioning {
    /// Everything by itself: cut-off above the motion, no delay.
    fn default() -> Self {
        Self { cutoff: Cutoff::Auto, rate: None, delay: 0.0, trim: Trim::Auto }
    }
}

impl Conditioning {
    /// Refuses what no log could be conditioned with.
    pub(crate) fn check(&self) -> Result<()> {
        let setting = |what, value, expected| Err(MotionError::Setting { what, value, expected });
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
