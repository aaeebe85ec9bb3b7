//! Logs summed up apart, and solved together for the model that fitting all of them gives.

use crate::fit::timed;
use crate::{Error, Event, FitOptions, FitResult, Log, Observer, Prepared, Result, Rows};
use torquewise_identify::rounds::Request;
use torquewise_identify::summary::summarise_again;
use torquewise_identify::{
    ChainOptions, FrictionKind, LibraryOptions, Method, Plan, Solution, Summary, solve, summarise,
};

/// What solving sums of logs came to.
#[derive(Debug)]
pub enum Solved {
    /// The equations of motion.
    Model(Box<FitResult>),
    /// A chain asks for another pass over the rows of all logs.
    Request(Box<Request>),
}

/// Sums up logs, to be merged with the sums of others and solved.
///
/// - `request`: what [`solve_sums`] asked for, if it did
///
/// # Errors
/// [`Error::FrictionOfSums`], [`Error::UnusedOption`], and those of reading.
pub fn sum_up(
    log: &Log,
    options: &FitOptions,
    request: Option<&Request>,
    observer: Observer<'_>,
) -> Result<(Summary, Prepared)> {
    log.files.require_tau()?;
    let plan = options.plan(log.joints().len(), log.is_filtered())?;
    let plan = match (request, &plan.method) {
        (Some(_), Method::Library(_)) => {
            Plan { method: Method::Chain(ChainOptions::default()), ..plan }
        }
        _ => plan,
    };
    if let Method::Library(LibraryOptions { friction, .. }) = &plan.method
        && *friction != FrictionKind::None
    {
        return Err(Error::FrictionOfSums);
    }
    let log = log.prepare(Rows::Filtered)?;
    let watched = log.watched(observer, "summing");
    let watch = |stage| observer(Event::Stage(stage));
    let signals = conditioning(&log);
    let mut summary = match request {
        None => summarise(&watched, &plan, &signals, &watch)?,
        Some(request) => summarise_again(&watched, &plan, &signals, request, &watch)?,
    };
    summary.settings.filter = log.filter();
    Ok((summary, log))
}

/// How the signals were filtered: parts that were filtered otherwise do not add up.
fn conditioning(log: &Prepared) -> String {
    let Some(logs) = log.conditioned() else { return "as recorded".to_owned() };
    let settings = &logs.settings;
    format!("{:?}, torque {:?} s late", settings.cutoff, settings.delay)
}

/// Solves for the model of logs that were summed up apart.
///
/// # Errors
/// [`Error::UnusedOption`] if an option does not go with what the logs were summed for,
/// [`Error::Identify`] if the sums cannot be solved.
pub fn solve_sums(
    summary: Summary,
    options: &FitOptions,
    observer: Observer<'_>,
) -> Result<Solved> {
    let plan = options.plan_for_sums(&summary.settings)?;
    let filter = summary.settings.filter;
    let (solution, spent) = timed(observer, |progress| solve(summary, &plan, progress))?;
    Ok(match solution {
        Solution::Request(request) => Solved::Request(request),
        Solution::Model(found) => {
            let mut fit = FitResult::of(*found, None, spent);
            fit.found.model.training.filter = filter;
            Solved::Model(Box::new(fit.judged()?))
        }
    })
}
