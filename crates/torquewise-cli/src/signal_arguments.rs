//! Words of the command line → recording: which files, by which profile, filtered how.

use crate::error::CliError;
use crate::files::read_model;
use crate::recorded::Recorded;
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;
use torquewise::logs::conditioned::RawLogs;
use torquewise::logs::{Clock, ConditionedLogs, Logs, Options, Profile};
use torquewise::model::model::Filter as FilterUsed;
use torquewise::signals::{Conditioning, Cutoff, Trim};

/// How the columns of a file become signals.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct ProfileArguments {
    /// What the columns are: units, gears, clock, rows; `torquewise inspect` suggests one
    #[arg(long, value_name = "FILE.toml")]
    profile: Option<PathBuf>,
    /// Topic of a bag that holds several
    #[arg(long, value_name = "NAME")]
    topic: Option<String>,
    /// Drop rows that repeat a time stamp, go back in time or hold no number, as a profile does
    #[arg(long)]
    repair: bool,
}

impl ProfileArguments {
    /// Whether a profile is named.
    pub(crate) fn is_given(&self) -> bool {
        self.profile.is_some()
    }

    /// Opens logs.
    pub(crate) fn open(&self, paths: &[PathBuf]) -> Result<Logs> {
        let profile = self.profile.as_ref().map(|file| Profile::read(file)).transpose()?;
        let clock = if self.repair { Clock::Repair } else { Clock::Strict };
        let options = Options { profile, topic: self.topic.clone(), clock };
        Ok(Logs::open_with(paths, &options)?)
    }
}

/// How signals are conditioned.
#[derive(Args, Clone, Debug)]
pub(crate) struct SignalArguments {
    /// Zero-phase low-pass filter: its cut-off in Hz, `auto` to filter logs without ddq at the
    /// cut-off of the model or, where there is none, at one that is chosen, or `none`
    #[arg(long, value_name = "auto|none|HZ", default_value = "auto", value_parser = filter)]
    filter: Filter,
    /// Seconds by which the torque lags the motion, or `auto` to estimate it where signals are
    /// filtered
    #[arg(long, value_name = "auto|S", default_value = "auto", value_parser = delay,
          allow_hyphen_values = true)]
    delay: Delay,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Filter {
    Auto,
    None,
    Hz(f64),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Delay {
    Auto,
    Seconds(f64),
}

fn filter(text: &str) -> Result<Filter, String> {
    match text {
        "auto" => Ok(Filter::Auto),
        "none" => Ok(Filter::None),
        _ => positive(text).map(Filter::Hz),
    }
}

fn positive(text: &str) -> Result<f64, String> {
    let known = text.parse().ok().filter(|hz: &f64| hz.is_finite() && *hz > 0.0);
    known.ok_or_else(|| "expected auto, none, or a cut-off above 0 Hz".to_owned())
}

fn delay(text: &str) -> Result<Delay, String> {
    if text == "auto" {
        return Ok(Delay::Auto);
    }
    let known = text.parse().ok().filter(|s: &f64| s.abs() <= 1.0);
    known.map(Delay::Seconds).ok_or_else(|| "expected auto, or seconds within ±1".to_owned())
}

/// How signals are conditioned where no model is at hand, or one that says how.
#[derive(Args, Clone, Debug)]
pub(crate) struct FilterArguments {
    /// Filter the logs as those of this model were
    #[arg(long, value_name = "MODEL.json")]
    model: Option<PathBuf>,
    #[command(flatten)]
    signals: SignalArguments,
}

/// Which rows are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wanted {
    /// As many as the filter leaves something new in.
    Filtered,
    /// Every one: none is left out.
    EveryRow,
    /// The filtered, and torque before its filter beside them.
    WithRaw,
}

impl FilterArguments {
    /// Logs filtered as asked for, or as those of the model.
    ///
    /// # Errors
    /// As [`SignalArguments::prepare`], and if the model cannot be read.
    pub(crate) fn prepare(&self, logs: Logs, wanted: Wanted) -> Result<Recorded> {
        match self.model.as_ref().map(|file| read_model(file)).transpose()? {
            Some(model) => self.signals.prepare_as(model.training.filter, logs, wanted),
            None => self.signals.prepare(logs, wanted),
        }
    }

    /// Logs to test on, filtered as those that were trained on.
    ///
    /// # Errors
    /// As [`Self::prepare`].
    pub(crate) fn prepare_like(&self, train: &Recorded, test: Logs) -> Result<Recorded> {
        self.signals.prepare_as(train.filter(), test, Wanted::Filtered)
    }
}

impl SignalArguments {
    /// The filter that logs go through, if any.
    fn cutoff(&self, logs: &Logs) -> Option<Cutoff> {
        match self.filter {
            Filter::Auto if logs.has_ddq() => None,
            Filter::None => None,
            Filter::Auto => Some(Cutoff::Auto),
            Filter::Hz(hz) => Some(Cutoff::Hz(hz)),
        }
    }

    /// Whether logs will be filtered, which their columns tell.
    pub(crate) fn filters(&self, logs: &Logs) -> bool {
        self.cutoff(logs).is_some()
    }

    /// Whether the cut-off is left to held-out rows.
    pub(crate) fn leaves_cutoff(&self) -> bool {
        self.filter == Filter::Auto
    }

    /// Logs as they are asked for: filtered, unless they hold accelerations or it is not wanted.
    ///
    /// # Errors
    /// [`CliError::Usage`] if a delay is given and nothing is filtered, and those of reading logs.
    pub(crate) fn prepare(&self, logs: Logs, wanted: Wanted) -> Result<Recorded> {
        let Some(cutoff) = self.cutoff(&logs) else {
            return match self.delay {
                Delay::Seconds(s) if s != 0.0 => Err(CliError::Usage(
                    "--delay is for filtered signals: give --filter HZ too".into(),
                )
                .into()),
                _ => Ok(Recorded::Plain(logs)),
            };
        };
        let (delay, find) = match self.delay {
            Delay::Auto => (0.0, true),
            Delay::Seconds(seconds) => (seconds, false),
        };
        let settings = Conditioning { cutoff, delay, ..Conditioning::default() };
        let every_row =
            || Conditioning { rate: Some(f64::MAX), trim: Trim::Seconds(0.0), ..settings };
        let filtered = |settings: &Conditioning, logs: Logs| -> Result<Recorded> {
            Ok(Recorded::Conditioned(Box::new(ConditionedLogs::new(logs, settings, find)?)))
        };
        match wanted {
            Wanted::Filtered => filtered(&settings, logs),
            Wanted::EveryRow => filtered(&every_row(), logs),
            Wanted::WithRaw => Ok(Recorded::Raw(Box::new(RawLogs::new(logs, &settings, find)?))),
        }
    }

    /// Logs filtered as those a model was fitted on, where nothing else is asked for: so that what
    /// is measured on them is what the fit measured, and they have no say in it.
    ///
    /// # Errors
    /// As [`Self::prepare`].
    pub(crate) fn prepare_as(
        &self,
        known: Option<FilterUsed>,
        logs: Logs,
        wanted: Wanted,
    ) -> Result<Recorded> {
        self.like(known, &logs).prepare(logs, wanted)
    }

    /// What is asked for; what is not, as it was in a fit.
    fn like(&self, known: Option<FilterUsed>, logs: &Logs) -> Self {
        let filter = match (self.filter, known) {
            (Filter::Auto, Some(known)) if !logs.has_ddq() => Filter::Hz(known.cutoff_hz),
            (Filter::Auto, _) => Filter::None,
            (asked, _) => asked,
        };
        let delay = match (self.delay, filter, known) {
            (Delay::Auto, Filter::Hz(_), Some(known)) => Delay::Seconds(known.delay),
            (Delay::Auto, _, _) => Delay::Seconds(0.0),
            (asked, _, _) => asked,
        };
        Self { filter, delay }
    }
}
