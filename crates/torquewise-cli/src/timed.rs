//! Recording, plan → reconstruction, and the seconds that each of its steps took.

use crate::progress::{Watched, bar};
use crate::recorded::Recorded;
use indicatif::ProgressBar;
use std::time::Instant;
use torquewise::identify::bandwidth::{Tuned, tune};
use torquewise::identify::reconstruct::{Solution, reconstruct_from};
use torquewise::identify::rounds::Request;
use torquewise::identify::{
    IdentifyError, Method, Plan, Reconstruction, Summary, reconstruct, solve,
};
use torquewise::motion::Recording;
use torquewise::survey::Progress;

/// A reconstruction and the time it took by the clock.
#[derive(Debug)]
pub(crate) struct Timed {
    /// What was found.
    pub(crate) found: Reconstruction,
    /// All of it \[s\].
    pub(crate) seconds: f64,
    /// Each step from its beginning to the next event \[s\].
    pub(crate) step_seconds: Vec<f64>,
}

/// Reconstructs under the eyes of the user, who is told the time left if the rows are known.
///
/// # Errors
/// As [`reconstruct()`].
pub(crate) fn timed(
    recording: &(impl Recording + ?Sized),
    rows: Option<u64>,
    plan: &Plan,
) -> Result<Timed, IdentifyError> {
    let watched = Watched::new(recording, "reading").of(rows, 2);
    let bar = watched.bar();
    let (found, seconds, step_seconds) =
        record(&bar, |progress| reconstruct(&watched, plan, progress))?;
    Ok(Timed { found, seconds, step_seconds })
}

/// The same at the bandwidth that held-out rows ask for, where logs are filtered; returns the logs
/// at that bandwidth too (E12).
///
/// # Errors
/// As [`reconstruct()`], and those of reading logs.
pub(crate) fn timed_at_best(
    recorded: Recorded,
    plan: &Plan,
) -> Result<(Recorded, Timed), anyhow::Error> {
    let rows = recorded.rows_hint();
    let Recorded::Raw(raw) = recorded else {
        let timed = timed(&recorded, rows, plan)?;
        return Ok((recorded, timed));
    };
    let by_chain = match &plan.method {
        Method::Chain(_) => plan.clone(),
        Method::Library(_) => Plan { seed: plan.seed, ..Plan::chain() },
    };
    let ((tuned, found), seconds, step_seconds) = record(&bar("reading"), |progress| {
        let Tuned { recording, request, choice } = tune(raw.as_ref(), &by_chain, progress)?;
        let logs = Recorded::Conditioned(Box::new(recording));
        let watched = Watched::new(&logs, "reading").of(rows, 2);
        let mut found = match &plan.method {
            Method::Chain(_) => reconstruct_from(&watched, request, plan, progress)?,
            Method::Library(_) => reconstruct(&watched, plan, progress)?,
        };
        found.model.choices.splice(0..0, choice);
        Ok((logs, found))
    })?;
    Ok((tuned, Timed { found, seconds, step_seconds }))
}

/// What solving under the eyes of the user came to.
pub(crate) enum TimedSolution {
    /// The equations of motion.
    Model(Box<Timed>),
    /// Another pass over the logs is wanted.
    Request(Box<Request>),
}

/// Solves under the eyes of the user.
///
/// # Errors
/// As [`solve()`].
pub(crate) fn timed_solve(summary: Summary, plan: &Plan) -> Result<TimedSolution, IdentifyError> {
    let (solution, seconds, step_seconds) =
        record(&bar("solving"), |progress| solve(summary, plan, progress))?;
    Ok(match solution {
        Solution::Model(found) => {
            TimedSolution::Model(Box::new(Timed { found: *found, seconds, step_seconds }))
        }
        Solution::Request(request) => TimedSolution::Request(request),
    })
}

/// Does some work, the seconds it took, and those of each of its steps.
fn record<T>(
    bar: &ProgressBar,
    work: impl FnOnce(&mut dyn FnMut(Progress)) -> Result<T, IdentifyError>,
) -> Result<(T, f64, Vec<f64>), IdentifyError> {
    let mut events: Vec<(Progress, Instant)> = Vec::new();
    let start = Instant::now();
    let found = work(&mut |progress| {
        bar.set_message(doing(progress));
        events.push((progress, Instant::now()));
    })?;
    let mut step_seconds: Vec<f64> = Vec::new();
    for pair in events.windows(2) {
        let spent = pair[1].1.duration_since(pair[0].1).as_secs_f64();
        match pair[0].0 {
            Progress::Step(_) | Progress::Geometry => step_seconds.push(spent),
            // A chain grows by what it had overlooked.
            Progress::Overlooked => step_seconds.last_mut().into_iter().for_each(|s| *s += spent),
            _ => {}
        }
    }
    Ok((found, start.elapsed().as_secs_f64(), step_seconds))
}

/// What is being done, in words.
pub(crate) fn doing(progress: Progress) -> String {
    match progress {
        Progress::Survey => "looking through the log".to_owned(),
        Progress::Patterns => "clustering".to_owned(),
        Progress::Geometry => "learning the geometry".to_owned(),
        Progress::Evidence => "summing".to_owned(),
        Progress::Step(step) => format!("selecting terms, step {step}"),
        Progress::Refit => "fitting all rows".to_owned(),
        Progress::Overlooked => "testing omitted terms".to_owned(),
        Progress::Done => "done".to_owned(),
    }
}
