//! All that a fit needs of logs, in a file that adds to others.

use crate::arguments::PlanArguments;
use crate::commands::fit::MethodName;
use crate::conditioning;
use crate::files::check_output;
use crate::moments_file::{json, read_request, text, write_moments};
use crate::outcome::Outcome;
use crate::progress::watch;
use crate::signal_arguments::{ProfileArguments, SignalArguments};
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;
use torquewise::sums::sum_up;

/// Sum up logs into a file that adds to others: merge such files, then solve
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Logs of one arm
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Moments file to write
    #[arg(short, long, value_name = "PART.moments")]
    output: PathBuf,
    /// What `solve` asked for: sum up the rows for another pass of a chain
    #[arg(long, value_name = "FILE.request")]
    request: Option<PathBuf>,
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

/// Sums up and writes.
pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    check_output(&arguments.output, &arguments.logs)?;
    let options = arguments.plan.options(arguments.method.regression());
    // Wrong usage is told before the log is read.
    arguments.plan.refuse_selection()?;
    options.check()?;
    let log = arguments.profile.open(&arguments.logs, &arguments.signals)?;
    let request = arguments.request.as_deref().map(read_request).transpose()?;
    let (summary, log) = sum_up(&log, &options, request.as_ref(), &watch())?;
    let bytes = write_moments(&arguments.output, &summary)?;
    Ok(Outcome {
        notes: Vec::new(),
        text: log.text()
            + &text(&summary, &arguments.output, bytes)
            + &conditioning::text(&log.repairs()),
        json: json(&summary, &arguments.output, bytes),
        warnings: log.warnings(),
    })
}
