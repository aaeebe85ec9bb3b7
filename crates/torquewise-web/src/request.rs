//! What the page asks for.

use serde::Deserialize;
use serde_json::{Map, Value};
use torquewise::logs::Profile;

/// One question of the page.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "ask", rename_all = "snake_case")]
pub enum Question {
    /// What a log holds: columns, a profile for them, and what a fit would find amiss.
    Open(LogAt),
    /// A model for a log, its report and its equations.
    Fit {
        /// What it is fitted to.
        log: LogAt,
        /// Options of the fit, by the names that Python has.
        options: Map<String, Value>,
        /// Date of the report.
        date: String,
    },
    /// How well a model predicts a log.
    Evaluate {
        /// Text of its file.
        model: String,
        /// Another log of the arm.
        log: LogAt,
    },
    /// A model as a file for another program.
    Export {
        /// Text of its file.
        model: String,
        /// What for, as `torquewise export --to` says it.
        to: String,
        /// What functions begin with.
        name: String,
        /// Whether a model is written whose mass matrix is not positive definite.
        force: bool,
    },
    /// A log that is simulated, to try the page with.
    Example {
        /// Which, as [`crate::examples::csv`] takes it.
        name: String,
    },
}

/// A log of one or more files, and how it is read.
#[derive(Clone, Debug, Deserialize)]
pub struct LogAt {
    /// Its files.
    pub files: Vec<FileAt>,
    /// What the columns mean, where they have other names than `t`, `q1`, …
    pub profile: Option<Profile>,
    /// Cut-off of the filter \[Hz\]; chosen without.
    pub cutoff: Option<f64>,
}

/// A file that the page holds.
#[derive(Clone, Debug, Deserialize)]
pub struct FileAt {
    /// Its name, whose ending says its format.
    pub name: String,
    /// The number that the page knows it by.
    pub at: u32,
    /// Bytes.
    pub size: u64,
}
