//! Logs → model file: the main job.

use crate::arguments::{Known, PlanArguments};
use crate::call_costs::CallCosts;
use crate::conditioning;
use crate::error::CliError;
use crate::files::{check_distinct, check_ending, check_output, write_whole};
use crate::outcome::Outcome;
use crate::physics::{MassMatrix, Physics, STATES};
use crate::progress::Watched;
use crate::recorded::Recorded;
use crate::score_table;
use crate::signal_arguments::{ProfileArguments, SignalArguments, Wanted};
use crate::table::{Table, counts, number};
use crate::timed::{Timed, timed_at_best};
use anyhow::Result;
use clap::{Args, ValueEnum};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use torquewise::diagnose::disagreement::disagreements;
use torquewise::identify::plan::Regression;
use torquewise::identify::verdict::{Grade, Verdict};
use torquewise::identify::{Plan, Reconstruction, Warning, diagnose, score};
use torquewise::logs::Logs;
use torquewise::model::{Model, to_json};
use torquewise::motion::Recording;
use torquewise::regression::accumulate::Route;
use torquewise::report::{Findings, fit_report};

/// Reconstruct the equations of motion from logs
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Logs of one arm
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Model file to write
    #[arg(short, long, value_name = "MODEL.json")]
    output: PathBuf,
    /// Report to write: what was found and how far to trust it, with charts
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Log of another motion to judge the model by, in the report too; repeat for several
    #[arg(long, value_name = "LOG")]
    test: Vec<PathBuf>,
    /// Standstill, uniform and variable velocity in turn, or all at once
    #[arg(long, value_enum, default_value_t)]
    method: MethodName,
    #[command(flatten)]
    plan: PlanArguments,
    #[command(flatten)]
    profile: ProfileArguments,
    #[command(flatten)]
    signals: SignalArguments,
}

/// One regression or three.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(crate) enum MethodName {
    /// Gravity from standstill, Coriolis from uniform, inertia from variable velocity
    #[default]
    Stepwise,
    /// One-shot SINDy: the product library on all rows, without noise correction
    Sindy,
}

impl MethodName {
    /// The regressions of that name.
    pub(crate) fn regression(self) -> Regression {
        match self {
            Self::Stepwise => Regression::Stepwise,
            Self::Sindy => Regression::OneShot,
        }
    }
}

/// Fits and writes.
pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    check_outputs(arguments)?;
    // Wrong usage is told before the log is read.
    arguments.plan.plan(arguments.method.regression(), Known::default())?;
    let Opened { logs, test, plan } = open(arguments)?;
    let (logs, mut timed) = timed_at_best(logs, &plan)?;
    timed.found.model.training.filter = logs.filter();
    compare_logs(&mut timed.found, &logs)?;
    timed.found.model.training.conditioning = logs.repairs();
    let model = &timed.found.model;
    write_whole(&arguments.output, to_json(model)?)?;

    let mass = MassMatrix::of(model)?;
    let mut text = vec![mass.headline(), logs.text(), text(&arguments.output, &timed)];
    let mut json = json(&arguments.output, &timed, &mass);
    let (notes, found): (Vec<&Warning>, Vec<&Warning>) =
        timed.found.warnings.iter().partition(|warning| warning.is_remark());
    let repaired = conditioning::notes(&model.training.conditioning);
    let notes = repaired.into_iter().chain(notes.into_iter().map(ToString::to_string)).collect();
    let found = found.into_iter().map(ToString::to_string);
    let mut warnings: Vec<String> =
        mass.warning().into_iter().chain(found).chain(logs.warnings()).collect();
    if let Some(test) = &test {
        let scores = score(model, &Watched::new(test, "predicting").of(test.rows_hint(), 1))?;
        let raw = test.raw_scores(model)?;
        let table = score_table::text(&scores, raw.as_ref());
        text.push(format!("\nOn the test log:\n\n{table}"));
        json["test"] = score_table::json_beside_raw(&scores, raw.as_ref());
        warnings.extend(score_table::warnings(&scores));
    }
    if let Some(file) = &arguments.report {
        let costs = CallCosts::of(model)?;
        write_whole(file, report(arguments, &timed.found, &logs, test.as_ref(), &costs)?)?;
        text.push(format!("{}\nreport: {}\n", costs.text(), file.display()));
        json["costs"] = costs.json();
        json["report"] = json!(file.display().to_string());
    }
    if let Some(verdict) = Verdict::of(&timed.found) {
        text.push(format!("\nverdict: {verdict}\n"));
        json["verdict"] = json!(verdict.grade.to_string());
        if verdict.grade == Grade::Unusable {
            warnings.push(format!("the model is {verdict}"));
        }
        json["because"] = json!(verdict.because);
    }
    Ok(Outcome { text: text.concat(), json, warnings, notes })
}

fn check_outputs(arguments: &Arguments) -> Result<()> {
    let outputs = || std::iter::once(&arguments.output).chain(&arguments.report);
    for file in outputs() {
        check_output(file, &arguments.logs)?;
        check_output(file, &arguments.test)?;
    }
    check_distinct(outputs())?;
    if let Some(report) = &arguments.report {
        check_ending(report, &["html", "htm"])?;
    }
    Ok(())
}

/// Logs, ready to be read.
struct Opened {
    /// To fit on.
    logs: Recorded,
    /// To judge by.
    test: Option<Recorded>,
    /// What is fitted.
    plan: Plan,
}

fn open(arguments: &Arguments) -> Result<Opened> {
    let open = |paths: &Vec<PathBuf>| -> Result<Logs> {
        let logs = arguments.profile.open(paths)?;
        logs.require_tau()?;
        Ok(logs)
    };
    let logs = open(&arguments.logs)?;
    let known = Known::of(&logs, &arguments.signals);
    let plan = arguments.plan.plan(arguments.method.regression(), known)?;
    let leaves_cutoff = arguments.signals.leaves_cutoff();
    let wanted = if leaves_cutoff { Wanted::WithRaw } else { Wanted::Filtered };
    let logs = arguments.signals.prepare(logs, wanted)?;
    let test = Some(&arguments.test).filter(|test| !test.is_empty());
    let test = test
        .map(|test| arguments.signals.prepare_as(logs.filter(), open(test)?, Wanted::WithRaw))
        .transpose()?;
    if let Some(test) = test.as_ref().filter(|test| test.joints() != logs.joints()) {
        let [found, expected] = [test, &logs].map(|logs| logs.joints().join(", "));
        return Err(CliError::TestOfAnotherArm { found, expected }.into());
    }
    Ok(Opened { logs, test, plan })
}

/// Warns of logs that one model cannot fit, such as those of different payloads.
fn compare_logs(found: &mut Reconstruction, logs: &Recorded) -> Result<()> {
    if logs.logs().paths().len() > 1 {
        let watched = Watched::new(logs, "comparing the logs");
        let at_odds = disagreements(&found.model, &watched, &|k| logs.file_of(k))?;
        found.warnings.extend(at_odds.into_iter().map(Warning::Disagreement));
    }
    Ok(())
}

/// The report of a model over its logs and those of another motion.
fn report(
    arguments: &Arguments,
    found: &Reconstruction,
    logs: &Recorded,
    test: Option<&Recorded>,
    costs: &CallCosts,
) -> Result<String> {
    let look = |logs: &Recorded| {
        let watched = Watched::new(logs, "looking at the residuals").of(logs.rows_hint(), 2);
        diagnose(&found.model, &found.patterns, &watched)
    };
    let (diagnosis, test) = (look(logs)?, test.map(look).transpose()?);
    let physics = Physics::of(&found.model, STATES)?;
    let names = |paths: &[PathBuf]| {
        let name = |path: &PathBuf| {
            path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
        };
        paths.iter().map(name).collect::<Vec<_>>().join(", ")
    };
    let logs = names(&arguments.logs);
    let title = match &arguments.test[..] {
        [] => format!("Torque model from {logs}"),
        test => format!("Torque model from {logs}, tested on {}", names(test)),
    };
    let (checks, test, costs) = (Some(physics.checks()), test.as_ref(), costs.of_each());
    Ok(fit_report(&Findings { found, diagnosis: &diagnosis, checks, test, costs }, &title)?)
}

/// What was found, for people.
pub(crate) fn text(output: &Path, timed: &Timed) -> String {
    let found = &timed.found;
    let mut steps = Table::new(&["step", "rows", "candidates", "active per joint", "seconds"]);
    for (step, seconds) in found.steps.iter().zip(&timed.step_seconds) {
        let (rows, candidates) = (step.rows.to_string(), step.candidates.to_string());
        steps.row(step.name, [rows, candidates, counts(&step.active), format!("{seconds:.3}")]);
    }
    let model = &found.model;
    let percent = |part: &str| format!("{part} [% of std]");
    let (own, held_out) = (percent("residual"), percent("held out"));
    let mut joints = Table::new(&["joint", "active", "residual [N·m]", &own, &held_out]);
    let training = model.training.residual_rms.iter().zip(&model.training.torque_std);
    let active = model.active();
    let mut unseen = held_out_percent(model).into_iter();
    for ((name, active), (&residual, &std)) in model.joints.iter().zip(active).zip(training) {
        let own = [active.to_string(), number(residual), number(100.0 * residual / std)];
        let unseen = unseen.next().map_or_else(String::new, number);
        joints.row(name, own.into_iter().chain([unseen]));
    }
    format!(
        "{} rows, {:.1} s at {} Hz\n\n{}\n{}\n{}{} of {} candidates kept, {:.2} s\n{}{}model: {}\n",
        found.survey.rows,
        found.survey.seconds,
        number(found.survey.rate()),
        steps.text(),
        joints.text(),
        choices(model),
        model.n_coefficients(),
        found.candidates,
        timed.seconds,
        line(model.training.overlooked.as_ref()),
        line(model.training.price_of_physics.as_ref()),
        output.display(),
    )
}

/// What is left of the torque of each joint on held-out blocks of time, of its spread \[%\].
fn held_out_percent(model: &Model) -> Vec<f64> {
    let pairs = model.training.held_out_rms.iter().zip(&model.training.torque_std);
    pairs.map(|(rms, std)| 100.0 * rms / std).collect()
}

/// A line of its own, if there is something to say.
fn line(what: Option<&impl ToString>) -> String {
    what.map_or_else(String::new, |what| what.to_string() + "\n")
}

/// What was chosen on held-out data, and how much worse the runner-up is.
fn choices(model: &Model) -> String {
    if model.choices.is_empty() {
        return String::new();
    }
    let mut table = Table::new(&["chosen on held-out rows", "", "error [%]", "from"]);
    for choice in &model.choices {
        let error = choice.from.iter().find(|candidate| candidate.label == choice.chosen);
        let error = error.map_or_else(String::new, |chosen| number(100.0 * chosen.error));
        let from = choice.from.len().to_string();
        table.row(&choice.what, [choice.chosen.clone(), error, from]);
    }
    table.text() + "\n"
}

/// The same for programs.
pub(crate) fn json(output: &Path, timed: &Timed, mass: &MassMatrix) -> Value {
    let found = &timed.found;
    let model = &found.model;
    let steps = found.steps.iter().zip(&timed.step_seconds).map(|(step, seconds)| {
        json!({
            "name": step.name,
            "rows": step.rows,
            "candidates": step.candidates,
            "active": step.active,
            "route": route_name(step.route),
            "seconds": seconds,
        })
    });
    let dropped = found
        .dropped
        .iter()
        .map(|dropped| json!({ "term": dropped.name, "inclusion": dropped.inclusion }));
    json!({
        "rows": found.survey.rows,
        "joints": model.joints,
        "candidates": found.candidates,
        "candidates_by_step":
            found.steps.iter().map(|step| step.candidates).collect::<Vec<_>>(),
        "active": model.active(),
        "active_total": model.n_coefficients(),
        "steps": steps.collect::<Vec<_>>(),
        "choices": model.choices,
        "overlooked": model.training.overlooked,
        "price_of_physics": model.training.price_of_physics,
        "residual_percent": model.training.residual_rms.iter().zip(&model.training.torque_std)
            .map(|(rms, std)| 100.0 * rms / std).collect::<Vec<_>>(),
        "held_out_percent": held_out_percent(model),
        "cutoff_hz": model.training.filter.map(|filter| filter.cutoff_hz),
        "conditioning": conditioning::json(&model.training.conditioning),
        "seconds": timed.seconds,
        "route": overall_route(found),
        "noise": {
            "q": found.noise.q,
            "dq": found.noise.dq,
            "ddq": found.noise.ddq,
        },
        "dropped": dropped.collect::<Vec<_>>(),
        "residual_rms": model.training.residual_rms,
        "torque_std": model.training.torque_std,
        "mass_matrix": mass.json(),
        "file": output.display().to_string(),
    })
}

/// How the normal equations were come by, if all steps agree.
fn overall_route(found: &Reconstruction) -> &'static str {
    let mut routes = found.steps.iter().map(|step| route_name(step.route));
    let first = routes.next().unwrap_or("none");
    if routes.all(|route| route == first) { first } else { "mixed" }
}

fn route_name(route: Route) -> &'static str {
    match route {
        Route::Moments => "moments",
        Route::Direct => "direct",
    }
}
