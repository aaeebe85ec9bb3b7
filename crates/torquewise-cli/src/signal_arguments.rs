//! Which log files are read, by which profile, and how their signals are filtered.

use crate::arguments::{parsed, parsed_unless_auto};
use crate::{Result, read_model};
use clap::Args;
use std::path::PathBuf;
use torquewise::logs::{Options, Profile};
use torquewise::{Filter, Log, Prepared, Rows};

/// How the columns of a file become signals, and how these are conditioned.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Log")]
pub(crate) struct SignalArguments {
    /// What the columns are: units, gears, clock, rows; `torquewise inspect` suggests one, those of
    /// public data sets are built in, such as `ur10`
    #[arg(long, value_name = "FILE.toml|NAME")]
    pub(crate) profile: Option<PathBuf>,
    /// Topic of a bag that holds several
    #[arg(long, value_name = "NAME")]
    topic: Option<String>,
    /// Drop rows that repeat a time stamp, go back in time or hold no number, as a profile does
    #[arg(long)]
    repair: bool,
    /// Zero-phase low-pass filter: its cut-off in Hz, `auto` to filter logs without ddq at the
    /// cut-off of the model or, where there is none, at one that is chosen, or `none`
    #[arg(help_heading = "Filter", long, value_name = "auto|none|HZ", default_value = "auto")]
    #[arg(value_parser = filter)]
    filter: Filter,
    /// Seconds by which the torque lags the motion, or `auto`: that of the model or, in a fit of
    /// filtered signals, the one that predicts held-out torque best
    #[arg(help_heading = "Filter", long, value_name = "auto|S", default_value = "auto")]
    #[arg(value_parser = delay, allow_hyphen_values = true)]
    // Named in full, since clap takes a plain Option for one that may be left out.
    delay: std::option::Option<f64>,
}

impl SignalArguments {
    pub(crate) fn profile(&self) -> Result<Option<Profile>> {
        Ok(self.profile.as_ref().map(|file| Profile::read(file)).transpose()?)
    }

    pub(crate) fn open(&self, paths: &[PathBuf]) -> Result<Log> {
        let profile = self.profile()?;
        let options = Options { profile, topic: self.topic.clone(), repair: self.repair };
        let mut log = Log::open_all(paths, &options)?;
        (log.filter, log.delay) = (self.filter, self.delay);
        Ok(log)
    }
}

fn filter(text: &str) -> Result<Filter, String> {
    match text {
        "auto" => Ok(Filter::Auto),
        "none" => Ok(Filter::None),
        _ => {
            let is_cutoff = |hz: &f64| hz.is_finite() && *hz > 0.0;
            let expected = "expected auto, none, or a cut-off above 0 Hz";
            parsed(text, is_cutoff, expected).map(Filter::Hz)
        }
    }
}

fn delay(text: &str) -> Result<Option<f64>, String> {
    let expected = "expected auto, or seconds within ±1";
    parsed_unless_auto(text, |s: &f64| s.abs() <= 1.0, expected)
}

/// The same where no model is at hand, or one that says how signals are filtered.
#[derive(Args, Clone, Debug)]
pub(crate) struct FilterArguments {
    #[command(flatten)]
    pub(crate) signals: SignalArguments,
    /// Filter the logs as those of this model were
    #[arg(help_heading = "Filter", long, value_name = "MODEL.json")]
    model: Option<PathBuf>,
}

impl FilterArguments {
    pub(crate) fn prepare(&self, log: &Log, rows: Rows) -> Result<Prepared> {
        Ok(match &self.model {
            Some(file) => log.prepare_as(read_model(file)?.training.filter, rows)?,
            None => log.prepare(rows)?,
        })
    }
}
