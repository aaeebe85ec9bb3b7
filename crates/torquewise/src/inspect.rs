//! What a log holds and what it lacks, before anything is fitted to it.

use crate::fit::timed;
use crate::options::MOST_BY_TERMS;
use crate::summary::all_repairs;
use crate::{Observer, Prepared, Result};
use serde::Serialize;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use torquewise_identify::{
    PatternPlan, Patterns, Survey, Warning, find_patterns, survey, weightless,
};
use torquewise_motion::{Pattern, Recording, Repairs};
use torquewise_stepwise::progress::Watch;

/// Counts of the rows of all patterns with their names, least active first.
pub fn pattern_rows(counts: [u64; 3]) -> Value {
    let counts = Pattern::ALL.iter().zip(counts);
    counts.map(|(pattern, rows)| json!({ "name": pattern.name(), "rows": rows })).collect()
}

/// All that is known about logs.
#[derive(Clone, Debug)]
pub struct Inspection {
    /// Rows, ranges, noise.
    pub survey: Survey,
    /// Clusters of rows.
    pub patterns: Patterns,
    /// Rows of each pattern, least active first.
    pub counts: [u64; 3],
    /// The files, as given.
    pub files: Vec<String>,
    /// Columns that are not read.
    pub ignored_columns: Vec<String>,
    /// Signals that are not recorded: of `dq`, `ddq`, `tau`.
    pub missing: Vec<&'static str>,
    /// Rows of a log before it was filtered, where it was filtered in one piece.
    pub recorded: Option<usize>,
    /// Whether it is filtered, for which a chain is fitted.
    pub is_filtered: bool,
    /// What its torques seem to be, if not all of the torque: without gravity, cut off.
    pub torque: Vec<Warning>,
    repairs: BTreeMap<String, Repairs>,
}

/// Looks through a log.
///
/// # Errors
/// Those of reading it.
///
/// ```no_run
/// # fn main() -> Result<(), torquewise::Error> {
/// use torquewise::{Log, inspect::inspect, log::Rows, observe::NOBODY};
///
/// let log = Log::open("train.csv")?.prepare(Rows::Filtered)?;
/// for warning in inspect(&log, NOBODY)?.warnings() {
///     println!("{warning}");
/// }
/// # Ok(())
/// # }
/// ```
pub fn inspect(log: &Prepared, observer: Observer<'_>) -> Result<Inspection> {
    let watched = log.watched(observer, "looking through the log");
    let survey = survey(&watched)?;
    let patterns = find_patterns(&survey, &PatternPlan::default())?;
    let mut counts = [0; 3];
    watched.read(&mut |_, block| {
        count_patterns(&mut counts, &patterns.label(block));
        Ok(())
    })?;
    let logs = log.logs();
    let signals = [("dq", logs.has_dq()), ("ddq", logs.has_ddq()), ("tau", logs.has_tau())];
    let missing = signals.into_iter().filter(|(_, present)| !present).map(|(name, _)| name);
    let look = |watch: Watch<'_>| Ok(weightless(&survey, 0, watch));
    let kind = if logs.has_tau() { timed(observer, look)?.0 } else { None };
    let filtered = log.conditioned().map(|own| &own.report);
    let whole = filtered.filter(|own| own.rows_out == survey.rows);
    Ok(Inspection {
        recorded: whole.map(|own| own.rows_in),
        is_filtered: filtered.is_some(),
        torque: kind.into_iter().chain(log.cut_off()).collect(),
        survey,
        patterns,
        counts,
        files: logs.paths().iter().map(|path| path.display().to_string()).collect(),
        ignored_columns: logs.ignored_columns(),
        missing: missing.collect(),
        repairs: log.repairs(),
    })
}

/// Adds rows to the counts of their patterns, least active first.
pub fn count_patterns(counts: &mut [u64; 3], rows: &[Pattern]) {
    for (count, pattern) in counts.iter_mut().zip(Pattern::ALL) {
        *count += rows.iter().filter(|&&found| found == pattern).count() as u64;
    }
}

/// The warning that patterns are not among `present`, and what for they are needed.
pub fn missing_patterns(present: &[Pattern]) -> Option<String> {
    let missing = Pattern::ALL.into_iter().filter(|pattern| !present.contains(pattern));
    let names: Vec<&str> = missing.map(Pattern::name).collect();
    (!names.is_empty()).then(|| {
        format!(
            "the log shows no {}: reconstruction step by step wants dwells, strokes of constant \
             speed and brakes; a chain does not",
            names.join(" and no ")
        )
    })
}

impl Inspection {
    /// Whether torque was recorded.
    pub fn has_tau(&self) -> bool {
        !self.missing.contains(&"tau")
    }

    /// Gaps at which files were split.
    pub fn gaps(&self) -> usize {
        self.survey.trajectories.saturating_sub(self.files.len())
    }

    /// What a fit would suffer from.
    pub fn warnings(&self) -> Vec<String> {
        let mut open = Warning::of_survey(&self.survey);
        open.retain(|own| self.has_tau() || !matches!(own, Warning::ConstantTorque { .. }));
        // A chain, which is fitted to other logs, needs no patterns.
        let is_stepwise = !self.is_filtered && self.survey.joints.len() <= MOST_BY_TERMS;
        let patterns = missing_patterns(&self.patterns.present).filter(|_| is_stepwise);
        open.extend(self.torque.iter().cloned());
        open.iter().map(ToString::to_string).chain(patterns).collect()
    }
}

impl Serialize for Inspection {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let survey = &self.survey;
        let noise = &survey.noise;
        let joints = survey.joints.iter().enumerate().map(|(joint, name)| {
            json!({
                "name": name,
                "q_range": survey.q_range[joint],
                "dq_peak": survey.dq_peak[joint],
                "ddq_peak": survey.ddq_peak[joint],
                "tau_mean": self.has_tau().then_some(survey.torque_mean[joint]),
                "tau_std": self.has_tau().then_some(survey.torque_std[joint]),
                "noise": { "q": noise.q[joint], "dq": noise.dq[joint], "ddq": noise.ddq[joint] },
            })
        });
        let absent = Pattern::ALL.iter().filter(|name| !self.patterns.present.contains(name));
        let found = json!({
            "files": self.files,
            "joints": joints.collect::<Vec<_>>(),
            "rows": survey.rows,
            "rows_recorded": self.recorded,
            "trajectories": survey.trajectories,
            "gaps": self.gaps(),
            "seconds": survey.seconds,
            "rate_hz": survey.rate(),
            "patterns": pattern_rows(self.counts),
            "missing": self.missing,
            "missing_patterns": absent.map(|name| name.name()).collect::<Vec<_>>(),
            "ignored_columns": self.ignored_columns,
            "conditioning": all_repairs(&self.repairs),
        });
        found.serialize(serializer)
    }
}
