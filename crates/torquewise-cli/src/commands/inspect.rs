//! From logs to what they hold, and what they lack.

use crate::conditioning;
use crate::outcome::{Outcome, object};
use crate::pattern_table::{PatternTable, counts_json, counts_text, missing};
use crate::progress::watch;
use crate::signal_arguments::{FilterArguments, ProfileArguments};
use crate::table::Table;
use anyhow::{Result, anyhow};
use clap::Args;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::PathBuf;
use torquewise::Error;
use torquewise::diagnose::excitation::findings;
use torquewise::identify::{PatternPlan, Patterns, Survey, Warning, find_patterns, survey};
use torquewise::log::Prepared;
use torquewise::log::Rows;
use torquewise::logs::{LogError, Logs, UnitWarning, suggest, unit_warnings};
use torquewise::model::number;
use torquewise::motion::{Pattern, Recording};
use torquewise::observe::Watched;
use torquewise::summary::AllRepairs;
use torquewise::survey::NoiseFloor;

/// Show what a log holds and what it lacks
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Logs of one arm
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    #[command(flatten)]
    profile: ProfileArguments,
    #[command(flatten)]
    filter: FilterArguments,
}

/// All that is known about the logs.
struct Inspection {
    logs: Logs,
    survey: Survey,
    patterns: Patterns,
    counts: [u64; 3],
    units: Vec<UnitWarning>,
}

/// Looks through the logs.
pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let log = match arguments.filter.open(&arguments.profile, &arguments.logs) {
        Ok(log) => log,
        // Columns by other names are no mistake; a mistake in our own names is.
        Err(error)
            if matches!(error.downcast_ref(), Some(Error::Log(LogError::NoColumn { .. }))) =>
        {
            return suggested(&arguments.logs, &arguments.profile).ok_or(error);
        }
        Err(error) => return Err(error),
    };
    let recorded = arguments.filter.prepare(&log, Rows::Filtered)?;
    let shown = watch();
    let watched = Watched::new(&recorded, &shown, "looking through the log", (None, 1));
    let survey = survey(&watched)?;
    let patterns = find_patterns(&survey, &PatternPlan::default())?;
    let mut table = PatternTable::create(None)?;
    let mut units: BTreeMap<String, UnitWarning> = BTreeMap::new();
    watched
        .read(&mut |_, block| {
            for warning in unit_warnings(block) {
                let known = units.entry(warning.column.clone()).or_insert(warning.clone());
                known.value = known.value.max(warning.value);
            }
            Ok(table.append(&patterns.label(block))?)
        })
        .map_err(|error| anyhow!(error))?;
    drop(shown);
    let (counts, units) = (table.finish()?, units.into_values().collect());
    let inspection = Inspection { logs: recorded.logs().clone(), survey, patterns, counts, units };
    let repairs = recorded.repairs();
    let mut json = inspection.json();
    json["conditioning"] = object(&AllRepairs::of(&repairs));
    Ok(Outcome {
        notes: conditioning::notes(&repairs),
        text: inspection.text() + &signals_text(&recorded) + &conditioning::text(&repairs),
        json,
        warnings: inspection.warnings().into_iter().chain(recorded.warnings()).collect(),
    })
}

/// What was done to the signals before they were looked at.
fn signals_text(recorded: &Prepared) -> String {
    recorded.report().map_or_else(String::new, |report| format!("\nsignals\n{report}\n"))
}

/// A profile for a log whose columns are not understood.
fn suggested(logs: &[PathBuf], known: &ProfileArguments) -> Option<Outcome> {
    let suggestion = logs.first().filter(|_| !known.is_given()).map(|log| suggest(log))?.ok()?;
    let reasons: Vec<String> =
        suggestion.reasons.iter().map(|reason| format!("- {reason}\n")).collect();
    Some(Outcome {
        notes: Vec::new(),
        text: format!(
            "The columns of this log need a profile. A suggestion, to be saved as profile.toml \
             and used with --profile profile.toml:\n\n{}\n{}",
            suggestion.toml,
            reasons.concat()
        ),
        json: json!({
            "profile": suggestion.toml,
            "reasons": suggestion.reasons,
            "complete": suggestion.is_complete,
        }),
        warnings: vec![
            "names and first rows of the columns were looked at, no more: save the profile, \
             correct it, and inspect again with --profile"
                .to_owned(),
        ],
    })
}

impl Inspection {
    fn gaps(&self) -> usize {
        self.survey.trajectories.saturating_sub(self.logs.paths().len())
    }

    /// Signals that are not recorded.
    fn missing(&self) -> Vec<&'static str> {
        let signals = [
            ("dq", self.logs.has_dq()),
            ("ddq", self.logs.has_ddq()),
            ("tau", self.logs.has_tau()),
        ];
        signals.into_iter().filter(|(_, present)| !present).map(|(name, _)| name).collect()
    }

    fn warnings(&self) -> Vec<String> {
        let constant = self.survey.constant_joints().into_iter();
        let names = constant.filter_map(|joint| self.survey.joints.get(joint).cloned());
        let constant = names.map(|joint| Warning::ConstantJoint { joint }.to_string());
        let units = self.units.iter().map(ToString::to_string);
        let open = findings(&self.survey).into_iter().map(|finding| finding.to_string());
        constant.chain(units).chain(open).chain(missing(&self.patterns.present)).collect()
    }

    fn text(&self) -> String {
        let Survey { joints, rows, trajectories, seconds, .. } = &self.survey;
        let absent = [
            ("not recorded", self.missing().join(", ")),
            ("columns not read", self.logs.ignored_columns().join(", ")),
        ];
        let absent = absent.iter().filter(|(_, names)| !names.is_empty());
        format!(
            "{rows} rows of {} joints, {seconds:.1} s at {} Hz\n\
             trajectories: {trajectories}, files: {}, gaps: {}\n\
             \n{}\n{}\n{}{}",
            joints.len(),
            number(self.survey.rate()),
            self.logs.paths().len(),
            self.gaps(),
            self.motion_table().text(),
            self.noise_text(),
            counts_text(self.counts),
            absent.map(|(what, names)| format!("\n{what}: {names}\n")).collect::<Vec<_>>().concat(),
        )
    }

    fn motion_table(&self) -> Table {
        let survey = &self.survey;
        let headings = [
            "joint",
            "q from",
            "to [rad]",
            "dq to [rad/s]",
            "ddq to [rad/s²]",
            "tau mean",
            "std [N·m]",
        ];
        let mut table = Table::new(&headings);
        for (joint, name) in survey.joints.iter().enumerate() {
            let [low, high] = survey.q_range[joint];
            let torque = [survey.torque_mean[joint], survey.torque_std[joint]]
                .map(|tau| if self.logs.has_tau() { number(tau) } else { "–".to_owned() });
            let motion = [low, high, survey.dq_peak[joint], survey.ddq_peak[joint]].map(number);
            table.row(name, motion.into_iter().chain(torque));
        }
        table
    }

    fn noise_text(&self) -> String {
        let NoiseFloor { q, dq, ddq } = &self.survey.noise;
        if self.survey.noise.is_none() {
            return "no white noise seen\n".to_owned();
        }
        let headings = ["noise floor", "q [rad]", "dq [rad/s]", "ddq [rad/s²]"];
        let mut table = Table::new(&headings);
        for (joint, name) in self.survey.joints.iter().enumerate() {
            table.row(name, [q[joint], dq[joint], ddq[joint]].map(number));
        }
        table.text()
    }

    fn json(&self) -> Value {
        let survey = &self.survey;
        let has_tau = self.logs.has_tau();
        let joint = |(joint, name): (usize, &String)| {
            json!({
                "name": name,
                "q_range": survey.q_range[joint],
                "dq_peak": survey.dq_peak[joint],
                "ddq_peak": survey.ddq_peak[joint],
                "tau_mean": has_tau.then_some(survey.torque_mean[joint]),
                "tau_std": has_tau.then_some(survey.torque_std[joint]),
                "noise": {
                    "q": self.survey.noise.q[joint],
                    "dq": self.survey.noise.dq[joint],
                    "ddq": self.survey.noise.ddq[joint],
                },
            })
        };
        let files = self.logs.paths().iter().map(|path| path.display().to_string());
        let absent = Pattern::ALL.iter().filter(|name| !self.patterns.present.contains(name));
        json!({
            "files": files.collect::<Vec<_>>(),
            "joints": survey.joints.iter().enumerate().map(joint).collect::<Vec<_>>(),
            "rows": survey.rows,
            "trajectories": survey.trajectories,
            "gaps": self.gaps(),
            "seconds": survey.seconds,
            "rate_hz": survey.rate(),
            "patterns": counts_json(self.counts),
            "missing": self.missing(),
            "missing_patterns": absent.map(|name| name.name()).collect::<Vec<_>>(),
            "ignored_columns": self.logs.ignored_columns(),
        })
    }
}
