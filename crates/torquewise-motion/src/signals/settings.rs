//! Settings of conditioning.

use crate::error::{MotionError, Result};

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
