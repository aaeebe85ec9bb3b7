//! The model that fitting all logs of a moments file together gives.

use crate::arguments::{RobotArguments, fit_options, words};
use crate::commands::fit;
use crate::moments_file::read_moments;
use crate::selection::{FRICTION, SelectionArguments};
use crate::{Outcome, Result, check_files, object, staged, watch, write_whole};
use clap::Args;
use serde_json::json;
use std::path::PathBuf;
use torquewise::sums::{Solved, solve_sums};

/// Reconstruct the equations of motion from a moments file, as fit does from its logs
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Moments file
    #[arg(value_name = "ALL.moments")]
    moments: PathBuf,
    /// Model file to write
    #[arg(help_heading = "Output", short, long, value_name = "MODEL.json")]
    output: PathBuf,
    /// Where to write what the next pass over the logs is asked for, if a chain wants one
    /// [default: MODEL.request]
    #[arg(help_heading = "Output", long, value_name = "FILE.request")]
    request: Option<PathBuf>,
    /// Friction, where a chain is learned [default: auto]
    #[arg(help_heading = "Method", long, value_parser = words(&FRICTION))]
    friction: Option<String>,
    /// Random seed [default: that of the moments]
    #[arg(help_heading = "Method", long)]
    seed: Option<u64>,
    #[command(flatten)]
    robot: RobotArguments,
    #[command(flatten)]
    selection: SelectionArguments,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let request = arguments.request.clone();
    let request = request.unwrap_or_else(|| arguments.output.with_extension("request"));
    let inputs = std::iter::once(&arguments.moments).chain(&arguments.robot.urdf);
    check_files(inputs, [&arguments.output, &request].map(|file| (file.as_path(), &[][..])))?;
    let summary = read_moments(&arguments.moments)?;
    let seed = arguments.seed.unwrap_or(summary.settings.patterns.seed);
    let mut flags = object(&arguments.selection);
    (flags["seed"], flags["friction"]) = (json!(seed), json!(arguments.friction));
    let mut options = fit_options(flags)?;
    options.geometry = arguments.robot.geometry(summary.joints())?;
    match solve_sums(summary, &options, &watch())? {
        Solved::Model(fit) => {
            fit.model.save(staged(&arguments.output)?)?;
            let mut outcome = fit::outcome(&fit, None, false)?;
            let file = arguments.output.display().to_string();
            outcome.text.extend([format!("\nmodel: {file}\n")]);
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
            Ok(Outcome { text, json, ..Outcome::default() })
        }
    }
}
