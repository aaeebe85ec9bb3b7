//! Logs of an arm, and how their signals are conditioned before anything is fitted to them.

use crate::{Error, Observer, Result, Watched};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use torquewise_identify::warning::list;
use torquewise_identify::{Disagreement, Warning, disagreements};
use torquewise_logs::conditioned::RawLogs;
use torquewise_logs::{ConditionedLogs, LEAST_GAIN, Logs, Options};
use torquewise_model::Model;
use torquewise_model::model::TrainingFilter;
use torquewise_motion::repairs::counted;
use torquewise_motion::signals::{ConditionReport, Cutoff, SignalReport};
use torquewise_motion::{Conditioning, Motion, ReadError, Recording, Repairs};

/// Velocity over the slope of its position from which on it is told; of real logs the largest is 1.14.
const MOST_GAIN: f64 = 1.15;

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

/// Logs ready to be read.
#[derive(Debug)]
pub enum Prepared {
    /// As they are.
    Plain(Logs),
    /// Filtered.
    Conditioned(Box<ConditionedLogs>),
    /// Filtered, with pieces at hand that can pass any other filter.
    Raw(Box<RawLogs>),
}

impl Prepared {
    /// The files.
    pub fn logs(&self) -> &Logs {
        match self {
            Self::Plain(logs) => logs,
            Self::Conditioned(logs) => &logs.logs,
            Self::Raw(raw) => &raw.conditioned.logs,
        }
    }

    /// The filtered logs, if anything is filtered.
    pub fn conditioned(&self) -> Option<&ConditionedLogs> {
        match self {
            Self::Plain(_) => None,
            Self::Conditioned(logs) => Some(logs),
            Self::Raw(raw) => Some(&raw.conditioned),
        }
    }

    /// What can be read of them.
    pub fn rows(&self) -> &dyn Recording {
        match self.conditioned() {
            Some(logs) => logs,
            None => self.logs(),
        }
    }

    /// The same, counted for whoever watches.
    pub fn watched<'a>(&'a self, observer: Observer<'a>, doing: &'static str) -> Watched<'a> {
        Watched::new(self.rows(), observer, doing, self.logs().rows_hint())
    }

    /// The filter that a model fitted on them keeps.
    pub fn filter(&self) -> Option<TrainingFilter> {
        let logs = self.conditioned()?;
        Some(TrainingFilter { cutoff_hz: logs.report.cutoff, delay: logs.settings.delay })
    }

    /// A sample of the motion with the torque as it was measured, and the white noise in the torque
    /// of each joint \[N·m\], n; `None` where no torque before its filter is at hand.
    pub(crate) fn raw_torque(&self) -> Result<Option<(Motion, Vec<f64>)>, ReadError> {
        let Self::Raw(raw) = self else { return Ok(None) };
        let Some(motion) = raw.beside_raw_torque()? else { return Ok(None) };
        let signals = &raw.conditioned.report.signals;
        let noise = signals.iter().filter(|signal| signal.signal == "tau");
        Ok(Some((motion, noise.map(|signal| signal.noise).collect())))
    }

    /// What was done to the signals, if anything was.
    pub fn report(&self) -> Option<&ConditionReport> {
        self.conditioned().map(|logs| &logs.report)
    }

    /// What was repaired in each log at its last complete reading, by its name.
    pub fn repairs(&self) -> BTreeMap<String, Repairs> {
        self.conditioned().map_or_else(|| self.logs().repairs(), ConditionedLogs::repairs)
    }

    /// What was done to the signals as text, one line per finding.
    pub fn text(&self) -> String {
        self.report().map_or_else(String::new, |report| format!("{report}\n\n"))
    }

    /// Name of the file that a trajectory is in.
    pub fn file_of(&self, trajectory: usize) -> String {
        let file = self.logs().file_of(trajectory);
        file.map_or_else(|| format!("trajectory {}", trajectory + 1), |f| f.display().to_string())
    }

    /// Logs, or stretches of one between gaps, that differ in what gravity does, as after another
    /// load was taken up.
    pub(crate) fn at_odds(
        &self,
        model: &Model,
        observer: Observer<'_>,
    ) -> Result<Vec<Disagreement>> {
        let is_single = self.logs().paths().len() == 1;
        if is_single && self.repairs().values().all(|own| own.splits == 0) {
            return Ok(Vec::new());
        }
        let name =
            |k: usize| if is_single { format!("stretch {}", k + 1) } else { self.file_of(k) };
        let watched = self.watched(observer, "comparing the logs");
        Ok(disagreements(model, &watched, &name)?)
    }

    /// What should be known of torques of few levels, units, odd velocities and rows left out.
    pub fn warnings(&self) -> Vec<String> {
        let doubts = self.coarse_torques().into_iter().chain(self.logs().unit_doubts());
        let own = [self.odd_velocities(), dropped(self.logs()), jumps(self.logs())];
        let stuck = self.report().into_iter().flat_map(|report| &report.stuck);
        let stuck = self.logs().joints().iter().zip(stuck).filter(|(_, stuck)| **stuck > LONG);
        let stuck = stuck.map(|(joint, stuck)| {
            format!("the torque of {joint} does not change for {stuck:.2} s while it moves on: leave that out")
        });
        doubts.chain(own.into_iter().flatten()).chain(stuck).collect()
    }

    /// Torques that a limit cut off as they were measured.
    pub fn cut_off(&self) -> Vec<Warning> {
        let cut_off = self.torques().filter(|torque| torque.is_cut_off());
        let finding = |torque: &SignalReport| {
            let (joint, share) = (torque.joint.clone(), torque.at_ends.0);
            Warning::Clipped { joint, share }
        };
        cut_off.map(finding).collect()
    }

    fn torques(&self) -> impl Iterator<Item = &SignalReport> {
        let signals = self.report().into_iter().flat_map(|report| &report.signals);
        signals.filter(|signal| signal.signal == "tau")
    }

    fn coarse_torques(&self) -> Option<String> {
        let coarse = self.torques().filter(|torque| torque.is_coarse());
        let joints: Vec<String> = coarse.map(|signal| signal.joint.clone()).collect();
        (!joints.is_empty()).then(|| {
            format!(
                "the torque of {} has few levels for its size: its sensor is too coarse for what the \
                 joint does, expect a poor fit",
                list(&joints)
            )
        })
    }

    fn odd_velocities(&self) -> Option<String> {
        let filtered = self.report().map(|report| &report.dq_gain[..]);
        let gains = filtered.unwrap_or(self.logs().velocity_gains());
        // A filter or noise makes a gain smaller, never larger.
        let odd = |gain: &f64| !(LEAST_GAIN..MOST_GAIN).contains(gain);
        let joints = self.logs().joints().iter().zip(gains);
        let (joints, gains): (Vec<String>, Vec<String>) = joints
            .filter_map(|(joint, gain)| Some((joint.clone(), format!("{:.3}", gain.filter(odd)?))))
            .unzip();
        (!joints.is_empty()).then(|| {
            format!(
                "the measured velocity of {} is {} times the slope of its position: check units, scales, \
                 signs and the clock of the log",
                list(&joints),
                list(&gains)
            )
        })
    }
}

/// A torque that does not change for so long \[s\] while its joint moves on is no measurement.
const LONG: f64 = 0.2;

fn jumps(logs: &Logs) -> Option<String> {
    let (file, (row, joint, by)) = logs.first(|own| own.first_jump.clone())?;
    Some(format!(
        "the log is split at {}, the first by {by:.3} of {joint} in row {row} of {}: are rows missing, \
         does a counter wrap, or did the joint slip?",
        counted(logs.report().jumps, "jump", "of a position"),
        file.display()
    ))
}

fn dropped(logs: &Logs) -> Option<String> {
    let report = logs.report();
    let mut parts = Vec::new();
    let repairs = &report.repairs;
    if repairs.not_finite > 0 {
        parts.push(counted(repairs.not_finite, "row", "without a number"));
    }
    if let Some((file, (row, column, value))) = logs.first(|own| own.first_absurd.clone()) {
        parts.push(format!(
            "{}, the first is {column} = {value:e} in row {row} of {}",
            counted(repairs.absurd, "row", "with a value far beyond its neighbours"),
            file.display()
        ));
    }
    let stale = "with the position of the one before while the arm moves on";
    let anew = "if the clock began anew there, put what follows in a file of its own";
    let zeros = "of zeros alone, far from where the arm was";
    let [held, back] = [logs.first(|own| own.first_held), logs.first(|own| own.first_back)];
    for (first, rows, what, why) in [
        (logs.first(|own| own.first_zeros), repairs.zeros, zeros, "what it held was lost"),
        (held, repairs.held_rows, stale, "the device did not answer"),
        (back, repairs.earlier_stamps, "earlier than a row before", anew),
    ] {
        parts.extend(first.map(|(file, row)| {
            let rows = counted(rows, "row", what);
            format!("{rows}, the first is row {row} of {} ({why})", file.display())
        }));
    }
    (!parts.is_empty()).then(|| format!("left out: {}", parts.join(", ")))
}
