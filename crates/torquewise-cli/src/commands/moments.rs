//! All that a fit needs of logs, in a file that adds to others.

use crate::arguments::{METHOD, PlanArguments, words};
use crate::moments_file::{read_request, write_moments};
use crate::signal_arguments::SignalArguments;
use crate::{Outcome, Result, check_files, watch};
use clap::Args;
use std::path::PathBuf;
use torquewise::motion::signals::CutoffFrom;
use torquewise::summary::repairs_text;
use torquewise::sums::sum_up;

/// Write mergeable sufficient statistics of logs: merge such files, then solve
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Logs of one arm
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Moments file to write
    #[arg(help_heading = "Output", short, long, value_name = "PART.moments")]
    output: PathBuf,
    /// What `solve` asked for: sum up the rows for another pass of a chain
    #[arg(long, value_name = "FILE.request")]
    request: Option<PathBuf>,
    /// Stepwise regression (default) or one-shot SINDy baseline
    #[arg(help_heading = "Method", long, value_parser = words(&METHOD), default_value = "stepwise")]
    method: String,
    #[command(flatten)]
    plan: PlanArguments,
    #[command(flatten)]
    signals: SignalArguments,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let inputs = arguments.logs.iter().chain(&arguments.request);
    check_files(inputs, [(arguments.output.as_path(), &[][..])])?;
    let options = arguments.plan.options(&arguments.method)?;
    // Wrong usage is told before the log is read.
    arguments.plan.selection.refuse()?;
    options.check()?;
    let log = arguments.signals.open(&arguments.logs)?;
    let request = arguments.request.as_deref().map(read_request).transpose()?;
    let (summary, log) = sum_up(&log, &options, request.as_ref(), &watch())?;
    let written = write_moments(&arguments.output, &summary)?;
    let text = log.text() + &written.text + &repairs_text(&log.repairs());
    let is_chosen = log.report().is_some_and(|own| own.cutoff_from == CutoffFrom::Motion);
    let notes = is_chosen.then(|| {
        "moments keep their cut-off and take torque to be on time, as a fit of one of the logs might \
         not: give its --filter and --delay"
            .to_owned()
    });
    Ok(Outcome { text, warnings: log.warnings(), notes: notes.into_iter().collect(), ..written })
}
