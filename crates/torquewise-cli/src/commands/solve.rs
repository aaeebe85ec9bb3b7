//! Moments file → model file: the model that fitting its logs together gives.

use crate::commands::fit;
use crate::files::{check_output, write_whole};
use crate::moments_file::read_moments;
use crate::outcome::Outcome;
use crate::physics::MassMatrix;
use crate::selection::{Friction, SelectionArguments};
use crate::timed::{Timed, TimedSolution, timed_solve};
use anyhow::Result;
use clap::Args;
use serde_json::json;
use std::path::PathBuf;
use torquewise::model::to_json;

/// Reconstruct the equations of motion from a moments file, as fit does from its logs
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Moments file
    #[arg(value_name = "ALL.moments")]
    moments: PathBuf,
    /// Model file to write
    #[arg(short, long, value_name = "MODEL.json")]
    output: PathBuf,
    /// Where to write what the next pass over the logs is asked for, if a chain wants one
    /// [default: MODEL.request]
    #[arg(long, value_name = "FILE.request")]
    request: Option<PathBuf>,
    /// Friction, where a chain is learned [default: auto]
    #[arg(long, value_enum)]
    friction: Option<Friction>,
    /// Seed of everything random [default: that of the moments]
    #[arg(long)]
    seed: Option<u64>,
    #[command(flatten)]
    selection: SelectionArguments,
}

/// Solves and writes a model, or what the next pass over the logs is asked for.
pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let request = arguments.request.clone();
    let request = request.unwrap_or_else(|| arguments.output.with_extension("request"));
    for output in [&arguments.output, &request] {
        check_output(output, std::slice::from_ref(&arguments.moments))?;
    }
    let summary = read_moments(&arguments.moments)?;
    let settings = summary.settings();
    let seed = arguments.seed.unwrap_or(settings.patterns.seed);
    let plan = arguments.selection.plan_of(settings, arguments.friction, seed)?;
    match timed_solve(summary, &plan)? {
        TimedSolution::Model(timed) => solved(arguments, &timed),
        TimedSolution::Request(next) => {
            write_whole(&request, next.to_bytes()?)?;
            let file = request.display();
            let text = format!(
                "A chain is fitted in passes over all rows; pass {} is wanted.\n\
                 Run `torquewise moments LOG… --request {file} -o PART` for each part of the logs, \
                 merge, and solve again.\nrequest: {file}\n",
                next.pass()
            );
            let json = json!({ "request": file.to_string(), "pass": next.pass() });
            Ok(Outcome { notes: Vec::new(), text, json, warnings: Vec::new() })
        }
    }
}

fn solved(arguments: &Arguments, timed: &Timed) -> Result<Outcome> {
    write_whole(&arguments.output, to_json(&timed.found.model)?)?;
    let mass = MassMatrix::of(&timed.found.model)?;
    let found = timed.found.warnings.iter().map(ToString::to_string);
    Ok(Outcome {
        notes: Vec::new(),
        text: mass.headline() + &fit::text(&arguments.output, timed),
        json: fit::json(&arguments.output, timed, &mass),
        warnings: mass.warning().into_iter().chain(found).collect(),
    })
}
