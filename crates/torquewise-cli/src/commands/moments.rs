//! Logs → moments file: all that a fit needs of them, to be added to others.

use crate::arguments::Known;
use crate::arguments::PlanArguments;
use crate::commands::fit::MethodName;
use crate::conditioning;
use crate::error::CliError;
use crate::files::check_output;
use crate::moments_file::{json, read_request, text, write_moments};
use crate::outcome::Outcome;
use crate::progress::Watched;
use crate::recorded::Recorded;
use crate::signal_arguments::{ProfileArguments, SignalArguments, Wanted};
use crate::timed::doing;
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;
use torquewise::identify::plan::{ChainOptions, FrictionKind, LibraryOptions};
use torquewise::identify::summary::summarise_again;
use torquewise::identify::{Method, Plan, summarise};

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

/// Why logs with friction are not summed up.
const FRICTION: &str = "the laws of friction follow from all logs together, so that parts with \
                        friction do not add up: fit the logs with fit, or use --library chain";

/// Sums up and writes.
pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    check_output(&arguments.output, &arguments.logs)?;
    let regression = arguments.method.regression();
    // Wrong usage is told before the log is read.
    arguments.plan.refuse_selection()?;
    arguments.plan.plan(regression, Known::default())?;
    let logs = arguments.profile.open(&arguments.logs)?;
    logs.require_tau()?;
    let request = arguments.request.as_deref().map(read_request).transpose()?;
    let plan = arguments.plan.plan(regression, Known::of(&logs, &arguments.signals))?;
    let plan = match (&request, &plan.method) {
        (Some(_), Method::Library(_)) => {
            Plan { method: Method::Chain(ChainOptions::default()), ..plan }
        }
        _ => plan,
    };
    if let Method::Library(LibraryOptions { friction, .. }) = &plan.method
        && *friction != FrictionKind::None
    {
        return Err(CliError::Usage(FRICTION.into()).into());
    }
    let logs = arguments.signals.prepare(logs, Wanted::Filtered)?;

    let watched = Watched::new(&logs, "summing").of(logs.rows_hint(), 2);
    let bar = watched.bar();
    let mut told = |progress| bar.set_message(doing(progress));
    let summary = match &request {
        None => summarise(&watched, &plan, &how(&logs), &mut told)?,
        Some(request) => summarise_again(&watched, &plan, &how(&logs), request, &mut told)?,
    };
    let bytes = write_moments(&arguments.output, &summary)?;
    Ok(Outcome {
        notes: Vec::new(),
        text: logs.text()
            + &text(&summary, &arguments.output, bytes)
            + &conditioning::text(&logs.repairs()),
        json: json(&summary, &arguments.output, bytes),
        warnings: logs.warnings(),
    })
}

/// How the signals were filtered: parts that were filtered otherwise do not add up.
fn how(logs: &Recorded) -> String {
    let Some(logs) = logs.conditioned() else { return "as recorded".to_owned() };
    let settings = logs.settings();
    format!("{:?}, torque {:?} s late", settings.cutoff, settings.delay)
}
