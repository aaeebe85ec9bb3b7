//! Signal conditioning: clean, evenly sampled motion from what was measured.
//!
//! [`condition()`] takes out spikes, resamples jittery stamps, chooses one cut-off above the band
//! of the motion, passes all signals through the same zero-phase low-pass filter, derives
//! velocity and acceleration without delay, and reports all of it. A [`Conditioner`] does the same
//! to a log of any length, block by block. Everything is a function of its arguments: no files.
//!
//! ```
//! use torquewise_motion::signals::{Conditioning, Raw, condition};
//!
//! let t: Vec<f64> = (0..2000).map(|row| 0.01 * row as f64).collect();
//! let q = vec![t.iter().map(|t| (2.0 * t).sin()).collect()];
//! let raw = Raw { joints: vec!["elbow".into()], t, signals: [Some(q), None, None, None] };
//!
//! let clean = condition(&raw, &Conditioning::default())?;
//!
//! let (motion, middle) = (&clean.motion, clean.motion.n_rows() / 2);
//! let exact = -4.0 * (2.0 * motion.t()[middle]).sin();
//! assert!((motion.ddq()[(middle, 0)] - exact).abs() < 1e-3);
//! # Ok::<(), torquewise_motion::MotionError>(())
//! ```

mod butterworth;
mod spline;
mod resample;
mod noise;
mod outliers;
mod cutoff;
mod derivative;
mod delay;
mod raw;
mod clean;
mod plan;
mod smooth;
pub mod report;
pub mod condition;
pub mod blocks;
pub mod bandwidth;

pub use blocks::Conditioner;
pub use clean::Outliers;
pub use condition::{Conditioned, condition};
pub use delay::Shift;
pub use noise::Quantisation;
pub use plan::{Conditioning, Cutoff, SignalPlan};
pub use raw::{Raw, Signal};
pub use report::{ConditionReport, CutoffFrom, SignalReport};
pub use resample::Timing;
pub use spline::lagrange;
