//! Logs of an arm, and how their signals are conditioned before anything is fitted to them.

use crate::error::{Error, Result};
use std::path::{Path, PathBuf};
use torquewise_logs::conditioned::RawLogs;
use torquewise_logs::{ConditionedLogs, Logs, Options};
use torquewise_model::model::TrainingFilter;
use torquewise_motion::Recording;
use torquewise_motion::signals::{Conditioning, Cutoff};

pub use crate::prepared::Prepared;

/// Log files of one arm, opened: each is a trajectory or several.
///
/// Logs without q̈ are filtered and differentiated, at a bandwidth that held-out raw torque
/// chooses (E12); logs with q̈ are taken as they are, unless [`Log::filter`] says otherwise.
#[derive(Clone, Debug)]
pub struct Log {
    /// The files.
    pub files: Logs,
    /// How its signals are filtered.
    pub filter: Filter,
    /// Seconds by which torque lags motion; without, a fit chooses it where signals are filtered.
    pub delay: Option<f64>,
}

/// How signals pass a zero-phase low-pass filter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Filter {
    /// Logs without q̈, at the cut-off of the model or, in a fit, at one that is chosen.
    #[default]
    Auto,
    /// Not at all.
    None,
    /// At this cut-off \[Hz\].
    Hz(f64),
}

/// Which rows of a log are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rows {
    /// As many as the filter leaves something new in.
    Filtered,
    /// Every one: none is left out.
    Every,
    /// Every one but those at the ends, where the filter has not settled.
    Settled,
    /// The filtered, with torque before its filter at hand.
    WithRawTorque,
}

impl Log {
    /// Opens a file: `.csv`, `.parquet`, `.db3`, `.mcap`, `.npz`, `.mat`, or the folder of a bag.
    ///
    /// # Errors
    /// [`Error::Log`] names file, row and column.
    pub fn open(file: impl AsRef<Path>) -> Result<Self> {
        Self::open_all(&[file.as_ref().to_owned()], &Options::default())
    }

    /// Opens several files of one arm.
    ///
    /// - `options`: a profile of their columns, the topic of a bag, what becomes of faulty rows
    ///
    /// # Errors
    /// As [`Log::open`], and if they are of different arms.
    pub fn open_all(files: &[PathBuf], options: &Options) -> Result<Self> {
        Ok(Logs::open_with(files, options)?.into())
    }

    /// Joint names, base to tip.
    pub fn joints(&self) -> &[String] {
        self.files.joints()
    }

    /// Whether its signals will be filtered.
    pub fn is_filtered(&self) -> bool {
        self.cutoff().is_some()
    }

    fn cutoff(&self) -> Option<Cutoff> {
        match self.filter {
            Filter::Auto if self.files.has_ddq() => None,
            Filter::None => None,
            Filter::Auto => Some(Cutoff::Auto),
            Filter::Hz(hz) => Some(Cutoff::Hz(hz)),
        }
    }

    /// Its rows, filtered if they are to be.
    ///
    /// # Errors
    /// [`Error::DelayWithoutFilter`], and those of reading logs.
    pub fn prepare(&self, rows: Rows) -> Result<Prepared> {
        let logs = self.files.clone();
        let Some(cutoff) = self.cutoff() else {
            return match self.delay {
                Some(delay) if delay != 0.0 => Err(Error::DelayWithoutFilter),
                _ => Ok(Prepared::Plain(logs)),
            };
        };
        let delay = self.delay.unwrap_or_default();
        let thins = matches!(rows, Rows::Filtered | Rows::WithRawTorque);
        let settings = Conditioning { cutoff, delay, thins, trims: rows != Rows::Every };
        Ok(if rows == Rows::WithRawTorque {
            Prepared::Raw(Box::new(RawLogs::new(logs, &settings, self.delay.is_none())?))
        } else {
            Prepared::Conditioned(Box::new(ConditionedLogs::new(logs, &settings)?))
        })
    }

    /// Its rows filtered as those a model was fitted on, where nothing else is asked for: what is
    /// measured on them is what the fit measured, and they have no say in it.
    ///
    /// # Errors
    /// As [`Self::prepare`].
    pub fn prepare_as(&self, known: Option<TrainingFilter>, rows: Rows) -> Result<Prepared> {
        let filter = match (self.filter, known) {
            (Filter::Auto, Some(known)) if !self.files.has_ddq() => Filter::Hz(known.cutoff_hz),
            (Filter::Auto, _) => Filter::None,
            (asked, _) => asked,
        };
        let delay = match (self.delay, filter, known) {
            (None, Filter::Hz(_), Some(known)) => known.delay,
            (asked, _, _) => asked.unwrap_or_default(),
        };
        Self { filter, delay: Some(delay), ..self.clone() }.prepare(rows)
    }
}

impl From<Logs> for Log {
    /// Files that are open, or tables in memory, filtered where that is wanted.
    fn from(files: Logs) -> Self {
        Self { files, filter: Filter::Auto, delay: None }
    }
}

/// What a model is fitted to, or judged by: log files, or motion at hand.
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
