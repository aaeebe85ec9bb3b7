//! Logs → model file: the main job.

use crate::arguments::PlanArguments;
use crate::files::{check_output, write_whole};
use crate::outcome::Outcome;
use crate::table::{Table, counts, number};
use crate::timed::{Timed, timed};
use anyhow::Result;
use clap::{Args, ValueEnum};
use serde_json::{Value, json};
use std::path::PathBuf;
use torquewise::identify::{Method, Reconstruction};
use torquewise::logs::Logs;
use torquewise::model::to_json;
use torquewise::sparse::accumulate::Route;

/// Reconstruct the equations of motion from logs
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Logs of one arm
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Model file to write
    #[arg(short, long, value_name = "MODEL.json")]
    output: PathBuf,
    /// Standstill, uniform and variable velocity in turn, or all at once
    #[arg(long, value_enum, default_value_t)]
    method: MethodName,
    #[command(flatten)]
    plan: PlanArguments,
}

/// One regression or three.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum MethodName {
    /// Gravity from standstill, Coriolis from uniform, inertia from variable velocity
    #[default]
    Stepwise,
    /// One-shot SINDy: the product library on all rows, without noise correction
    Sindy,
}

/// Fits and writes.
pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    check_output(&arguments.output, &arguments.logs)?;
    let plan = arguments.plan.plan(match arguments.method {
        MethodName::Stepwise => Method::Stepwise,
        MethodName::Sindy => Method::Sindy,
    })?;
    let logs = Logs::open(&arguments.logs)?;
    logs.require_tau()?;
    let timed = timed(&logs, &plan)?;
    write_whole(&arguments.output, &to_json(&timed.found.model)?)?;
    Ok(Outcome {
        text: text(arguments, &timed),
        json: json(arguments, &timed),
        warnings: timed.found.warnings.iter().map(ToString::to_string).collect(),
    })
}

fn text(arguments: &Arguments, timed: &Timed) -> String {
    let found = &timed.found;
    let mut steps = Table::new(&["step", "rows", "candidates", "active per joint", "seconds"]);
    for (step, seconds) in found.steps.iter().zip(&timed.step_seconds) {
        let (rows, candidates) = (step.rows.to_string(), step.candidates.to_string());
        steps.row(step.name, [rows, candidates, counts(&step.active), format!("{seconds:.3}")]);
    }
    let model = &found.model;
    let mut joints = Table::new(&["joint", "active", "residual [N·m]", "of std(tau) [%]"]);
    let training = model.training.residual_rms.iter().zip(&model.training.torque_std);
    let active = model.form.active(model.n_joints());
    for ((name, active), (&residual, &std)) in model.joints.iter().zip(active).zip(training) {
        let cells = [active.to_string(), number(residual), number(100.0 * residual / std)];
        joints.row(name, cells);
    }
    format!(
        "{} rows, {:.1} s at {} Hz\n\n{}\n{}\n{} of {} candidates kept, {:.2} s\nmodel: {}\n",
        found.survey.rows,
        found.survey.seconds,
        number(found.survey.rate()),
        steps.text(),
        joints.text(),
        model.form.n_coefficients(),
        found.candidates,
        timed.seconds,
        arguments.output.display(),
    )
}

fn json(arguments: &Arguments, timed: &Timed) -> Value {
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
        "active": model.form.active(model.n_joints()),
        "active_total": model.form.n_coefficients(),
        "steps": steps.collect::<Vec<_>>(),
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
        "file": arguments.output.display().to_string(),
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
