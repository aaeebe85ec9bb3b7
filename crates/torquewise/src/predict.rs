//! What a prediction is worth: its bounds, and where a motion leaves the range of the model.

mod interval;
mod range;

pub use interval::Interval;
pub use range::MotionRange;
