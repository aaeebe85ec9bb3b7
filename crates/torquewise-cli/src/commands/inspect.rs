//! `inspect`: what logs hold, and what they lack.

use crate::pattern_table::counts_text;
use crate::signal_arguments::FilterArguments;
use crate::{CliError, Outcome, Result, Table, object, watch};
use clap::Args;
use serde_json::json;
use std::path::PathBuf;
use torquewise::inspect::{Inspection, inspect};
use torquewise::logs::{LogError, LogInput, Suggestion, suggest};
use torquewise::model::number;
use torquewise::stepwise::{NoiseFloor, Survey};
use torquewise::summary::{repairs_note, repairs_text};
use torquewise::{Error, Rows};

/// Show what a log holds and what it lacks
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Logs of one arm
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    #[command(flatten)]
    filter: FilterArguments,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let log = match arguments.filter.signals.open(&arguments.logs) {
        Ok(log) => log,
        // Columns by other names are no mistake; a mistake in our own names is.
        Err(error @ CliError::Library(Error::Log(LogError::NoColumn { .. }))) => {
            let suggestion = suggestion(arguments)?.ok_or(error)?;
            return Ok(suggested(suggestion, arguments));
        }
        Err(error) => return Err(error),
    };
    // A torque by another name is no mistake either.
    let bare = log.files.require_tau();
    if matches!(bare, Err(LogError::NoTorque { file }) if Some(&file) == arguments.logs.first())
        && let Some(suggestion) = suggestion(arguments)?.filter(|own| own.has_torque)
    {
        return Ok(suggested(suggestion, arguments));
    }
    let recorded = arguments.filter.prepare(&log, Rows::Filtered)?;
    let inspection = inspect(&recorded, &watch())?;
    let repairs = recorded.repairs();
    let signals = recorded.report().map(|report| format!("\nsignals\n{report}\n"));
    let signals = signals.unwrap_or_default();
    Ok(Outcome {
        notes: repairs_note(&repairs).into_iter().collect(),
        text: text(&inspection) + &signals + &repairs_text(&repairs),
        json: object(&inspection),
        warnings: inspection.warnings().into_iter().chain(recorded.warnings()).collect(),
        ..Outcome::default()
    })
}

/// A profile for a log whose columns are not understood.
fn suggestion(arguments: &Arguments) -> Result<Option<Suggestion>> {
    if arguments.filter.signals.profile.is_some() {
        return Ok(None);
    }
    let logs: Vec<LogInput> = arguments.logs.iter().map(LogInput::from).collect();
    Ok(Some(suggest(&logs)?))
}

fn suggested(suggestion: Suggestion, arguments: &Arguments) -> Outcome {
    let again = match arguments.logs.first() {
        Some(first) if suggestion.takes_others => format!("inspect {} alone", first.display()),
        _ => "inspect again".to_owned(),
    };
    let what = format!(
        "the columns of this log need a profile; a suggestion is on standard output: save it as \
         profile.toml, correct it, and {again} with --profile profile.toml"
    );
    let json = json!({
        "profile": suggestion.toml,
        "reasons": suggestion.reasons,
        "complete": suggestion.is_complete,
    });
    Outcome {
        notes: std::iter::once(what).chain(suggestion.reasons).collect(),
        text: suggestion.toml,
        json,
        warnings: vec!["names and first rows of the columns were looked at, no more".to_owned()],
        is_unusable: false,
    }
}

fn text(inspection: &Inspection) -> String {
    let Survey { joints, rows, trajectories, seconds, .. } = &inspection.survey;
    let ignored = inspection.ignored_columns.iter().map(|name| name.escape_debug().to_string());
    let absent = [
        ("not recorded", inspection.missing.join(", ")),
        ("columns not read", ignored.collect::<Vec<_>>().join(", ")),
    ];
    let absent = absent.iter().filter(|(_, names)| !names.is_empty());
    let recorded = inspection.recorded.map(|rows| format!(", filtered, of {rows} recorded"));
    let recorded = recorded.unwrap_or_default();
    format!(
        "{rows} rows of {} joints, {seconds:.1} s at {} Hz{recorded}\n\
         trajectories: {trajectories}, files: {}, gaps: {}\n\
         \n{}\n{}\n{}{}",
        joints.len(),
        number(inspection.survey.rate()),
        inspection.files.len(),
        inspection.gaps(),
        motion_table(inspection).text(),
        noise_text(&inspection.survey),
        counts_text(inspection.counts),
        absent.map(|(what, names)| format!("\n{what}: {names}\n")).collect::<Vec<_>>().concat(),
    )
}

fn motion_table(inspection: &Inspection) -> Table {
    let survey = &inspection.survey;
    let motion = ["joint", "q from", "to [rad]", "dq to [rad/s]", "ddq to [rad/s²]"];
    let mut table = Table::new(motion.into_iter().chain(["tau mean", "std [N·m]"]));
    for (joint, name) in survey.joints.iter().enumerate() {
        let [low, high] = survey.q_range[joint];
        let torque = [survey.torque_mean[joint], survey.torque_std[joint]]
            .map(|tau| if inspection.has_tau() { number(tau) } else { "–".to_owned() });
        let motion = [low, high, survey.dq_peak[joint], survey.ddq_peak[joint]].map(number);
        table.row(name, motion.into_iter().chain(torque));
    }
    table
}

fn noise_text(survey: &Survey) -> String {
    let NoiseFloor { q, dq, ddq } = &survey.noise;
    if survey.noise.is_none() {
        return "no white noise seen\n".to_owned();
    }
    let mut table = Table::new(["noise floor", "q [rad]", "dq [rad/s]", "ddq [rad/s²]"]);
    for (joint, name) in survey.joints.iter().enumerate() {
        table.row(name, [q[joint], dq[joint], ddq[joint]].map(number));
    }
    table.text()
}
