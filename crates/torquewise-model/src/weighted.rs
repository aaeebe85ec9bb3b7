//! A term with its coefficient, the error of it, and how often it was kept.

use serde::{Deserialize, Serialize};

/// Standard errors from which on a number differs from zero.
pub(crate) const LEAST_T: f64 = 2.0;

/// A term with its coefficient and the standard error of it; both in the units of the coefficient.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Weighted<T> {
    /// The term.
    pub term: T,
    /// Its coefficient.
    pub coefficient: f64,
    /// Standard error of the coefficient; 0 where it is not known.
    pub std_error: f64,
    /// Share of resampled logs in which the term was kept; `None` where it was not asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inclusion: Option<f64>,
}

impl<T> Weighted<T> {
    /// A term with a coefficient that is simply given: without an error, and never resampled.
    pub const fn new(term: T, coefficient: f64) -> Self {
        Self { term, coefficient, std_error: 0.0, inclusion: None }
    }
}
