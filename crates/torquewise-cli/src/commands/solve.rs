//! The model that fitting all logs of a moments file together gives.

use crate::arguments::RobotArguments;
use crate::commands::fit;
use crate::files::{check_output, staged, write_whole};
use crate::moments_file::read_moments;
use crate::outcome::Outcome;
use crate::progress::watch;
use crate::selection::{Friction, SelectionArguments};
use anyhow::Result;
use clap::Args;
use serde_json::json;
use std::fmt::Write;
use std::path::PathBuf;
use torquewise::FitOptions;
use torquewise::sums::{Solved, solve_sums};

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
    robot: RobotArguments,
    #[command(flatten)]
    selection: SelectionArguments,
}

/// Solves and writes a model, or what the next pass over the logs is asked for.
pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let request = arguments.request.clone();
    let request = request.unwrap_or_else(|| arguments.output.with_extension("request"));
    for output in [&arguments.output, &request] {
        check_output(output, std::slice::from_ref(&arguments.moments))?;
        check_output(output, arguments.robot.file())?;
    }
    let summary = read_moments(&arguments.moments)?;
    let seed = arguments.seed.unwrap_or(summary.settings().patterns.seed);
    let friction = arguments.friction.map(Into::into);
    let geometry = arguments.robot.geometry(summary.joints())?;
    let options = FitOptions { seed, friction, geometry, ..FitOptions::default() };
    match solve_sums(summary, &arguments.selection.apply_to(options), &watch())? {
        Solved::Model(fit) => {
            fit.model.save(staged(&arguments.output)?)?;
            let mut outcome = fit::outcome(&fit, &fit.summary()?, false);
            let file = arguments.output.display().to_string();
            write!(outcome.text, "\nmodel: {file}\n")?;
            outcome.json["file"] = json!(file);
            Ok(outcome)
        }
        Solved::Request(next) => {
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
