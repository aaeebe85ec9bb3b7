//! From recording to survey: one look at a motion log, and choices on held-out rows of it.
//!
//! What every way from a log to a model needs first: ranges, the noise floor, an even sample, the
//! laws of friction that the speeds allow, and cross-validation on blocks of time.

pub mod error;
mod systematic_sample;
pub mod quantile;
pub mod noise;
pub mod survey;
pub mod held_out;
pub mod friction;
pub mod progress;

pub use error::IdentifyError;
pub use friction::FrictionKind;
pub use noise::NoiseFloor;
pub use progress::Progress;
pub use survey::{Survey, survey};
