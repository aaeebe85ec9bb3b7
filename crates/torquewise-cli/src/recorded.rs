//! Words of the command line → recording: which files, by which profile, filtered how.

use crate::error::CliError;
use crate::files::read_model;
use crate::score_table::RawErrors;
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;
use torquewise::logs::{Clock, ConditionedLogs, Logs, Options, Profile};
use torquewise::model::model::Filter as FilterUsed;
use torquewise::model::{Model, Torque};
use torquewise::motion::{Motion, RawRecording, ReadError, Recording};
use torquewise::signals::{ConditionReport, Conditioning, Cutoff, Trim};

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
    /// Zero-phase low-pass filter: its cut-off in Hz, `auto` to filter logs without ddq at a
    /// cut-off chosen from the spectrum, or `none`
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

/// Logs ready to be read.
#[derive(Debug)]
pub(crate) enum Recorded {
    /// As they are.
    Plain(Logs),
    /// Filtered.
    Conditioned(Box<ConditionedLogs>),
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

impl FilterArguments {
    /// Logs filtered as asked for, or as those of the model.
    ///
    /// # Errors
    /// As [`SignalArguments::prepare`], and if the model cannot be read.
    pub(crate) fn prepare(&self, logs: Logs) -> Result<Recorded> {
        match self.known()? {
            Some(model) => self.signals.prepare_as(model.training.filter, logs),
            None => self.signals.prepare(logs),
        }
    }

    /// The same where every row is wanted.
    ///
    /// # Errors
    /// As [`Self::prepare`].
    pub(crate) fn prepare_all(&self, logs: Logs) -> Result<Recorded> {
        match self.known()? {
            Some(model) => self.signals.prepare_all_as(model.training.filter, logs),
            None => self.signals.prepare_from(logs, &all_rows()),
        }
    }

    /// Logs to test on, filtered as those that were trained on.
    ///
    /// # Errors
    /// As [`Self::prepare`].
    pub(crate) fn prepare_like(&self, train: &Recorded, test: Logs) -> Result<Recorded> {
        self.signals.prepare_as(train.filter(), test)
    }

    fn known(&self) -> Result<Option<Model>> {
        self.model.as_ref().map(|file| read_model(file)).transpose()
    }
}

/// Conditioning that leaves no row out.
fn all_rows() -> Conditioning {
    Conditioning { rate: Some(f64::MAX), trim: Trim::Seconds(0.0), ..Conditioning::default() }
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
    /// [`CliError::Usage`] if a delay is given and nothing is filtered.
    pub(crate) fn prepare(&self, logs: Logs) -> Result<Recorded> {
        self.prepare_from(logs, &Conditioning::default())
    }

    /// The same where more is known of how.
    fn prepare_from(&self, logs: Logs, settings: &Conditioning) -> Result<Recorded> {
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
        let settings = Conditioning { cutoff, delay, ..*settings };
        Ok(Recorded::Conditioned(Box::new(ConditionedLogs::new(logs, &settings, find)?)))
    }

    /// Logs filtered as those a model was fitted on, where nothing else is asked for: so that what
    /// is measured on them is what the fit measured, and they have no say in it.
    ///
    /// # Errors
    /// As [`Self::prepare`].
    pub(crate) fn prepare_as(&self, known: Option<FilterUsed>, logs: Logs) -> Result<Recorded> {
        self.like(known, &logs).prepare(logs)
    }

    /// The same where every row is wanted: none is left out.
    ///
    /// # Errors
    /// As [`Self::prepare`].
    pub(crate) fn prepare_all_as(&self, known: Option<FilterUsed>, logs: Logs) -> Result<Recorded> {
        self.like(known, &logs).prepare_from(logs, &all_rows())
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

impl Recorded {
    /// The files.
    pub(crate) fn logs(&self) -> &Logs {
        match self {
            Self::Plain(logs) => logs,
            Self::Conditioned(logs) => logs.logs(),
        }
    }

    /// About how many rows there are, if that can be told without reading them.
    pub(crate) fn rows_hint(&self) -> Option<u64> {
        self.logs().rows_hint()
    }

    /// How a model that is fitted on them is told they were filtered.
    pub(crate) fn filter(&self) -> Option<FilterUsed> {
        let Self::Conditioned(logs) = self else { return None };
        let (cutoff_hz, delay) = (logs.report().cutoff?, logs.settings().delay);
        Some(FilterUsed { cutoff_hz, delay })
    }

    /// What a model leaves of the torque as it was measured, and the noise of that torque, which no
    /// model predicts: RMS of each joint \[N·m\]; on a sample of the rows. `None` where nothing is
    /// filtered: then the rows are the raw ones.
    pub(crate) fn raw_errors(&self, model: &Model) -> Result<Option<RawErrors>> {
        let Self::Conditioned(logs) = self else { return Ok(None) };
        let Some(cutoff) = logs.report().cutoff else { return Ok(None) };
        let raw = logs.raw()?;
        let read = |error: ReadError| anyhow::anyhow!(error);
        let Some(motion) = raw.sample(cutoff).map_err(read)? else { return Ok(None) };
        let (predicted, target) = (Torque::new(model).over(&motion)?, raw.raw_torque());
        let m = target.nrows() as f64;
        let of = |joint: usize| -> (f64, f64) {
            let mean = target.col(joint).sum() / m;
            let pairs = || target.col(joint).iter().zip(predicted.col(joint).iter());
            let square: f64 = pairs().map(|(tau, hat)| (tau - hat).powi(2)).sum();
            let spread: f64 = pairs().map(|(tau, _)| (tau - mean).powi(2)).sum();
            ((square / m).sqrt(), (spread / m).sqrt())
        };
        let (rmse, std) = (0..target.ncols()).map(of).unzip();
        let signals = logs.report().signals.iter().filter(|signal| signal.signal == "tau");
        Ok(Some(RawErrors { rmse, std, noise: signals.map(|s| s.noise.sigma).collect() }))
    }

    /// What was done to the signals, if anything was.
    pub(crate) fn report(&self) -> Option<&ConditionReport> {
        match self {
            Self::Plain(_) => None,
            Self::Conditioned(logs) => Some(logs.report()),
        }
    }

    /// The same as text, one line per finding.
    pub(crate) fn text(&self) -> String {
        self.report().map_or_else(String::new, |report| format!("{report}\n\n"))
    }

    /// Name of the file that a trajectory is in.
    pub(crate) fn file_of(&self, trajectory: usize) -> String {
        let file = self.logs().file_of(trajectory);
        file.map_or_else(|| format!("trajectory {}", trajectory + 1), |f| f.display().to_string())
    }

    /// What should be known of torques of few levels, odd velocities and rows left out.
    pub(crate) fn warnings(&self) -> Vec<String> {
        let coarse = self.report().into_iter().flat_map(|report| &report.signals);
        coarse
            .filter(|signal| signal.signal == "tau" && signal.is_coarse())
            .map(|signal| {
                format!(
                    "the torque of {} has few levels for its size: its sensor is too coarse for \
                     what the joint does, expect a poor fit",
                    signal.joint
                )
            })
            .chain(self.odd_velocities())
            .chain(dropped(self.logs()))
            .collect()
    }

    /// Joints whose measured velocity is not the slope of their position.
    fn odd_velocities(&self) -> Vec<String> {
        let gains = self.report().into_iter().flat_map(|report| &report.dq_gain);
        let odd = |gain: &f64| !(LEAST_GAIN..1.0 / LEAST_GAIN).contains(gain);
        let joints = self.joints().iter().zip(gains);
        joints
            .filter_map(|(joint, gain)| Some((joint, gain.filter(odd)?)))
            .map(|(joint, gain)| {
                format!(
                    "the measured velocity of {joint} is {gain:.3} times the slope of its \
                     position: check units, scales, signs and the clock of the log"
                )
            })
            .collect()
    }
}

/// Velocities over slopes that filters of a robot may explain.
const LEAST_GAIN: f64 = 0.8;

/// What reading left out.
fn dropped(logs: &Logs) -> Option<String> {
    let report = logs.report();
    let parts = [
        (report.repeated, "with the time stamp of the row before"),
        (report.not_finite, "without a number"),
    ];
    let mut parts: Vec<String> = (parts.iter().filter(|(rows, _)| *rows > 0))
        .map(|(rows, what)| format!("{rows} rows {what}"))
        .collect();
    if let Some(first) = report.first_back {
        parts.push(format!(
            "{} rows earlier than a row before them, the first is row {first} (if the clock began \
             anew there, put what follows in a file of its own)",
            report.went_back
        ));
    }
    (!parts.is_empty()).then(|| format!("left out: {}", parts.join(", ")))
}

impl Recording for Recorded {
    fn joints(&self) -> &[String] {
        self.logs().joints()
    }

    fn is_filtered(&self) -> bool {
        matches!(self, Self::Conditioned(_))
    }

    fn read(
        &self,
        visit: &mut dyn FnMut(usize, &Motion) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        match self {
            Self::Plain(logs) => logs.read(visit),
            Self::Conditioned(logs) => logs.read(visit),
        }
    }

    fn n_logs(&self) -> usize {
        self.logs().n_logs()
    }

    fn read_log(
        &self,
        log: usize,
        visit: &mut dyn FnMut(usize, &Motion) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        match self {
            Self::Plain(logs) => logs.read_log(log, visit),
            Self::Conditioned(logs) => logs.read_log(log, visit),
        }
    }

    fn read_log_with_noise(
        &self,
        log: usize,
        seed: u64,
        visit: &mut dyn FnMut(usize, &Motion, &Motion) -> Result<(), ReadError>,
    ) -> Result<bool, ReadError> {
        match self {
            Self::Plain(logs) => logs.read_log_with_noise(log, seed, visit),
            Self::Conditioned(logs) => logs.read_log_with_noise(log, seed, visit),
        }
    }
}
