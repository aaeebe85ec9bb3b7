//! Logs that are ready to be read, as they are or filtered, and what is known of their signals.

use crate::score_table::RawScores;
use anyhow::{Result, anyhow};
use std::collections::BTreeMap;
use torquewise::identify::score;
use torquewise::logs::conditioned::RawLogs;
use torquewise::logs::{ConditionedLogs, Logs};
use torquewise::model::Model;
use torquewise::model::model::Filter;
use torquewise::motion::{Motion, ReadError, Recording, Repairs};
use torquewise::signals::ConditionReport;

/// Logs ready to be read.
#[derive(Debug)]
pub(crate) enum Recorded {
    /// As they are.
    Plain(Logs),
    /// Filtered.
    Conditioned(Box<ConditionedLogs>),
    /// Filtered, with pieces at hand that can pass any other filter.
    Raw(Box<RawLogs>),
}

impl Recorded {
    /// The files.
    pub(crate) fn logs(&self) -> &Logs {
        match self {
            Self::Plain(logs) => logs,
            Self::Conditioned(logs) => logs.logs(),
            Self::Raw(raw) => raw.conditioned().logs(),
        }
    }

    /// The filtered logs, if anything is filtered.
    pub(crate) fn conditioned(&self) -> Option<&ConditionedLogs> {
        match self {
            Self::Plain(_) => None,
            Self::Conditioned(logs) => Some(logs),
            Self::Raw(raw) => Some(raw.conditioned()),
        }
    }

    fn rows(&self) -> &dyn Recording {
        match self.conditioned() {
            Some(logs) => logs,
            None => self.logs(),
        }
    }

    /// About how many rows there are, if that can be told without reading them.
    pub(crate) fn rows_hint(&self) -> Option<u64> {
        self.logs().rows_hint()
    }

    /// How a model that is fitted on them is told they were filtered.
    pub(crate) fn filter(&self) -> Option<Filter> {
        let logs = self.conditioned()?;
        Some(Filter { cutoff_hz: logs.report().cutoff?, delay: logs.settings().delay })
    }

    /// How a model predicts the torque as it was measured, on a sample of the rows, and the noise
    /// of that torque, which no model predicts. `None` where no torque before its filter is at
    /// hand.
    pub(crate) fn raw_scores(&self, model: &Model) -> Result<Option<RawScores>> {
        let Self::Raw(raw) = self else { return Ok(None) };
        let motion = raw.beside_raw_torque().map_err(|error| anyhow!(error))?;
        let Some(motion) = motion else { return Ok(None) };
        let signals = &raw.conditioned().report().signals;
        let noise = signals.iter().filter(|signal| signal.signal == "tau");
        let noise = noise.map(|signal| signal.noise.sigma).collect();
        Ok(Some(RawScores { scores: score(model, &motion)?, noise }))
    }

    /// What was done to the signals, if anything was.
    pub(crate) fn report(&self) -> Option<&ConditionReport> {
        self.conditioned().map(ConditionedLogs::report)
    }

    /// What was repaired in each log at its last complete reading, by its name.
    pub(crate) fn repairs(&self) -> BTreeMap<String, Repairs> {
        self.conditioned().map_or_else(|| self.logs().repairs(), ConditionedLogs::repairs)
    }

    /// What was done to the signals as text, one line per finding.
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

/// Faulty rows that reading left out.
fn dropped(logs: &Logs) -> Option<String> {
    let report = logs.report();
    let mut parts = Vec::new();
    if report.not_finite > 0 {
        parts.push(format!("{} rows without a number", report.not_finite));
    }
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
        self.rows().is_filtered()
    }

    fn read(
        &self,
        visit: &mut dyn FnMut(usize, &Motion) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        self.rows().read(visit)
    }

    fn n_logs(&self) -> usize {
        self.logs().n_logs()
    }

    fn read_log(
        &self,
        log: usize,
        visit: &mut dyn FnMut(usize, &Motion) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        self.rows().read_log(log, visit)
    }

    fn read_log_with_noise(
        &self,
        log: usize,
        seed: u64,
        visit: &mut dyn FnMut(usize, &Motion, &Motion) -> Result<(), ReadError>,
    ) -> Result<bool, ReadError> {
        self.rows().read_log_with_noise(log, seed, visit)
    }
}
