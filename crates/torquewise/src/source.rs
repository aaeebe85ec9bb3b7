//! What a model can be fitted to, or judged by.

use crate::log::Log;
use torquewise_motion::Recording;

/// Log files, or motion at hand.
pub enum Source<'a> {
    /// Files, conditioned as they ask for.
    Log(&'a Log),
    /// Rows that are clean: q, q̇, q̈, τ in SI units.
    Recording(&'a dyn Recording),
}

impl<'a> From<&'a Log> for Source<'a> {
    fn from(log: &'a Log) -> Self {
        Self::Log(log)
    }
}

impl<'a, R: Recording> From<&'a R> for Source<'a> {
    fn from(recording: &'a R) -> Self {
        Self::Recording(recording)
    }
}
