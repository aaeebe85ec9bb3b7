//! Moments file → model file: the model that fitting its logs together gives.

use crate::commands::fit::{json, text};
use crate::files::{check_output, write_whole};
use crate::moments_file::read_moments;
use crate::outcome::Outcome;
use crate::physics::MassMatrix;
use crate::selection::{Friction, SelectionArguments};
use crate::timed::timed_solve;
use anyhow::Result;
use clap::Args;
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
    /// Friction, where a chain is learned [default: auto]
    #[arg(long, value_enum)]
    friction: Option<Friction>,
    /// Seed of everything random [default: that of the moments]
    #[arg(long)]
    seed: Option<u64>,
    #[command(flatten)]
    selection: SelectionArguments,
}

/// Solves and writes.
pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    check_output(&arguments.output, std::slice::from_ref(&arguments.moments))?;
    let summary = read_moments(&arguments.moments)?;
    let settings = summary.settings();
    let seed = arguments.seed.unwrap_or(settings.patterns.seed);
    let plan = arguments.selection.plan_of(settings, arguments.friction, seed)?;
    let timed = timed_solve(summary, &plan)?;
    write_whole(&arguments.output, to_json(&timed.found.model)?)?;
    let mass = MassMatrix::of(&timed.found.model)?;
    let found = timed.found.warnings.iter().map(ToString::to_string);
    Ok(Outcome {
        text: mass.headline() + &text(&arguments.output, &timed),
        json: json(&arguments.output, &timed, &mass),
        warnings: mass.warning().into_iter().chain(found).collect(),
    })
}
