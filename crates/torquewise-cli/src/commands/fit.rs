//! The main job: logs to a model file.

use crate::arguments::{METHOD, PlanArguments, RobotArguments, words};
use crate::commands::payload::load_text;
use crate::signal_arguments::SignalArguments;
use crate::{
    Outcome, Result, Table, call_costs, check_files, object, score_table, staged, watch,
    write_whole,
};
use chrono::{DateTime, Utc};
use clap::Args;
use serde_json::json;
use std::ffi::OsString;
use std::path::PathBuf;
use std::time::SystemTime;
use torquewise::evaluate::evaluate_prepared;
use torquewise::identify::Warning;
use torquewise::model::model::Choice;
use torquewise::model::units::heading;
use torquewise::model::{Model, ModelError, number};
use torquewise::page::{LogFile, Origin, page};
use torquewise::payload::{LoadPlace, payload};
use torquewise::{Error, Evaluation, Fit, FitResult, Grade, Library, Log, Prepared, Rows};

/// Reconstruct the equations of motion from logs
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Logs of one arm
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Model file to write
    #[arg(help_heading = "Output", short, long, value_name = "MODEL.json")]
    output: PathBuf,
    /// Report to write: what was found and how far to trust it, with charts
    #[arg(help_heading = "Output", long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Log of another motion to judge the model by, in the report too; repeat for several
    #[arg(long, value_name = "LOG")]
    test: Vec<PathBuf>,
    /// Log of the arm with a load on its last link, which is weighed by the model; repeat for other
    /// loads
    #[arg(long, value_name = "LOG")]
    loaded: Vec<PathBuf>,
    /// Stepwise regression (default) or one-shot SINDy baseline
    #[arg(help_heading = "Method", long, value_parser = words(&METHOD), default_value = "stepwise")]
    method: String,
    /// Show what was chosen on the way: signals, steps, candidates, and what each call costs
    #[arg(help_heading = "Output", long)]
    explain: bool,
    #[command(flatten)]
    plan: PlanArguments,
    #[command(flatten)]
    robot: RobotArguments,
    #[command(flatten)]
    signals: SignalArguments,
}

pub(crate) fn run(arguments: &Arguments, words: &[OsString]) -> Result<Outcome> {
    let logs = [&arguments.logs, &arguments.test, &arguments.loaded];
    let inputs = logs.into_iter().flatten().chain(&arguments.robot.urdf);
    let html = arguments.report.iter().map(|file| (file.as_path(), &["html", "htm"][..]));
    check_files(inputs, html.chain([(arguments.output.as_path(), &[][..])]))?;
    let mut options = arguments.plan.options(&arguments.method)?;
    // Wrong usage is told before the log is read.
    options.check()?;
    let log = arguments.signals.open(&arguments.logs)?;
    options.geometry = arguments.robot.geometry(log.joints())?;
    let test = Some(&arguments.test).filter(|test| !test.is_empty());
    let test = test.map(|test| arguments.signals.open(test)).transpose()?;
    let loaded = arguments.loaded.iter();
    let loaded = loaded.map(|file| arguments.signals.open(std::slice::from_ref(file)));
    let loaded = loaded.collect::<Result<Vec<Log>>>()?;
    for other in test.iter().chain(&loaded) {
        other.files.require_tau()?;
        if other.joints() != log.joints() {
            let [found, expected] = [other, &log].map(|log| log.joints().join(", "));
            return Err(Error::OtherArm { found, expected }.into());
        }
    }
    if !loaded.is_empty() {
        options.library.get_or_insert(Library::Chain);
    }
    let mut fit = Fit::new(&log).options(options).observer(&watch()).run()?;
    let test = test.map(|test| test.prepare_as(fit.model.training.filter, Rows::WithRawTorque));
    let test = test.transpose()?;

    let judged = test.as_ref().map(|test| evaluate_prepared(&fit.model, test, &watch()));
    let judged = judged.transpose()?;
    if let Some(judged) = &judged {
        fit.judged_by(judged);
    }
    fit.model.save(staged(&arguments.output)?)?;
    let tested = judged.as_ref().map(|judged| (judged, arguments.test.len()));
    let mut outcome = outcome(&fit, tested, arguments.explain)?;
    outcome.json["file"] = json!(arguments.output.display().to_string());
    weigh(arguments, &loaded, &fit.model, &mut outcome)?;
    let costs = call_costs::of(&fit.model)?;
    if arguments.explain {
        outcome.text += &call_costs::text(&costs);
    }
    outcome.text.extend([format!("\nmodel: {}\n", arguments.output.display())]);
    if let Some(file) = &arguments.report {
        write_whole(file, report(arguments, words, &fit, test.as_ref().zip(judged.as_ref()))?)?;
        outcome.text.extend([format!("report: {}\n", file.display())]);
        outcome.json["costs"] = call_costs::json(&costs);
        outcome.json["report"] = json!(file.display().to_string());
    }
    Ok(outcome)
}

/// Weighs the load of each log that has one.
fn weigh(
    arguments: &Arguments,
    loaded: &[Log],
    model: &Model,
    outcome: &mut Outcome,
) -> Result<()> {
    if loaded.is_empty() {
        return Ok(());
    }
    let flange = LoadPlace::named(model, None, None).ok_or(Error::from(ModelError::NoChain))?;
    let mut loads = Vec::new();
    for (file, log) in arguments.loaded.iter().zip(loaded) {
        let load = payload(model, log, flange, &watch())?;
        outcome.text.extend([format!("\n{}: {}", file.display(), load_text(&load))]);
        outcome.warnings.extend(load.hints());
        loads.push(object(&load));
    }
    outcome.json["loads"] = json!(loads);
    Ok(())
}

fn report(
    arguments: &Arguments,
    words: &[OsString],
    fit: &FitResult,
    test: Option<(&Prepared, &Evaluation)>,
) -> Result<String> {
    let log_file = |path: &PathBuf| {
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let written = path.metadata().and_then(|metadata| metadata.modified());
        LogFile { name, date: written.map_or_else(|_| String::new(), date) }
    };
    let [logs, tests] = [&arguments.logs, &arguments.test]
        .map(|paths| paths.iter().map(log_file).collect::<Vec<_>>());
    let command: Vec<String> =
        words.iter().skip(1).map(|word| quoted(&word.to_string_lossy())).collect();
    let origin = Origin {
        logs: &logs,
        tests: &tests,
        model: &quoted(&arguments.output.display().to_string()),
        command: &format!("torquewise {}", command.join(" ")),
        date: &date(SystemTime::now()),
    };
    Ok(page(fit, test, origin, &watch())?.unwrap_or_default())
}

pub(super) fn date(time: SystemTime) -> String {
    DateTime::<Utc>::from(time).format("%Y-%m-%d %H:%M UTC").to_string()
}

/// A word as a shell takes it.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

/// What a fit came to: what can be acted on, and with `explain` what was chosen on the way.
///
/// - `test`: how it predicts others, and how many logs these are
pub(crate) fn outcome(
    fit: &FitResult,
    test: Option<(&Evaluation, usize)>,
    explain: bool,
) -> Result<Outcome> {
    let mut text = Vec::new();
    let flaw = fit.mass_matrix()?.flaw();
    let at_rest = |warning: &&Warning| matches!(warning, Warning::ConstantJoints { .. });
    let at_rest = fit.warnings.iter().find(at_rest);
    if let Some(flaw) = flaw {
        text.extend(at_rest.map(|cause| format!("{cause}\n")));
        text.push(format!("NOT PHYSICAL: {flaw}\n\n"));
    }
    if explain {
        text.extend(fit.log.as_ref().map(Prepared::text));
    }
    text.push(rows(fit));
    if explain {
        text.push(steps(fit) + "\n");
    }
    text.push(joints(fit));
    if explain {
        text.push(choices(&fit.model));
        text.push(format!(
            "\n{} of {} candidates kept, {:.2} s\n",
            fit.model.n_coefficients(),
            fit.candidates,
            fit.seconds
        ));
    }
    let warnings = fit.warnings.iter().filter(|warning| !warning.is_remark());
    let mut warnings: Vec<String> = warnings.map(ToString::to_string).collect();
    warnings.extend(fit.log.iter().flat_map(Prepared::warnings));
    let (mut notes, mut json) = (fit.notes(), fit.summary()?);
    let verdict = test.map_or_else(|| fit.verdict(), |(test, _)| test.verdict.clone());
    text.push(format!("\nverdict: {verdict}\n"));
    if let Some((scores, logs)) = test {
        let logs = if logs > 1 { format!("s, {logs} together") } else { String::new() };
        text.push(format!("\nOn the test log{logs}:\n\n"));
        text.push(score_table::text(scores, &fit.model.kinds()));
        json["test"] = object(scores);
        json["verdict"] = json!(verdict.grade);
        json["because"] = json!(verdict.because);
        warnings.extend_from_slice(&scores.warnings);
        notes.extend_from_slice(&scores.notes);
    }
    let is_unusable = verdict.grade == Grade::Unusable;
    Ok(Outcome { text: text.concat(), json, warnings, notes, is_unusable })
}

/// How long the log is, and how it was filtered.
fn rows(fit: &FitResult) -> String {
    let filter = fit.model.training.filter.map_or_else(String::new, |filter| {
        let delay = match filter.delay {
            0.0 => String::new(),
            delay if delay < 0.0 => format!(", torque {:.1} ms early", -1e3 * delay),
            delay => format!(", torque {:.1} ms late", 1e3 * delay),
        };
        format!(", filtered at {} Hz{delay}", number(filter.cutoff_hz))
    });
    let survey = &fit.survey;
    let rate = number(survey.rate());
    format!("{} rows, {:.1} s at {rate} Hz{filter}\n\n", survey.rows, survey.seconds)
}

fn steps(fit: &FitResult) -> String {
    let mut steps = Table::new(["step", "rows", "candidates", "active per joint", "seconds"]);
    for (step, seconds) in fit.steps.iter().zip(&fit.step_seconds) {
        let (rows, candidates) = (step.rows.to_string(), step.candidates.to_string());
        let active: Vec<String> = step.active.iter().map(ToString::to_string).collect();
        let cells = [rows, candidates, active.join(" "), format!("{seconds:.3}")];
        steps.row(step.name, cells);
    }
    steps.text()
}

fn joints(fit: &FitResult) -> String {
    let (model, training) = (&fit.model, &fit.model.training);
    let residual = heading(&model.kinds(), "residual [N·m]");
    let mut headings = vec!["joint", "terms", &residual, "residual [% of std]"];
    let percent = training.residual_rms.iter().zip(&training.torque_std);
    let percent: Vec<f64> = percent.map(|(rms, std)| 100.0 * rms / std).collect();
    let mut errors = vec![&training.residual_rms, &percent];
    // The same figure as in the verdict.
    let held_out = training.held_out_percent();
    if !held_out.is_empty() {
        headings.push("held out [% of std]");
        errors.push(&held_out);
    }
    let mut table = Table::new(headings);
    for ((joint, name), terms) in model.joints.iter().enumerate().zip(model.active()) {
        let errors = errors.iter().map(|values| values.get(joint).copied().unwrap_or(f64::NAN));
        table.row(name, std::iter::once(terms.to_string()).chain(errors.map(number)));
    }
    table.text()
}

fn choices(model: &Model) -> String {
    if model.choices.is_empty() {
        return String::new();
    }
    let mut table = Table::new(["choice", "chosen", "held out [%]", "from"]);
    for Choice { what, chosen, rule, from } in &model.choices {
        let error = from.iter().find(|candidate| candidate.label == *chosen);
        let error = error.map_or_else(String::new, |chosen| number(100.0 * chosen.error));
        // Without candidates it was given, or follows from what else was found.
        let from = if from.is_empty() { rule.clone() } else { from.len().to_string() };
        table.row(what, [chosen.clone(), error, from]);
    }
    format!("\n{}", table.text())
}
