//! From Raw logs to their bandwidth: where a learned chain predicts held-out raw torque best (E12).

use crate::plan::Plan;
use crate::reconstruct::{Solution, solve};
use crate::reconstruction::Progress;
use crate::rounds::Request;
use crate::summary::summarise;
use crate::unseen::{BLOCKS, Errors, even_blocks, held_out};
use rayon::prelude::*;
use torquewise_model::model::{Candidate, Choice};
use torquewise_motion::RawRecording;
use torquewise_stepwise::error::IdentifyError;
use torquewise_stepwise::held_out::standard_error;

/// Of cut-offs whose errors differ by no more than this part, the lowest is taken: it lets the
/// least noise through.
const ALIKE: f64 = 0.005;
/// Chains that are searched at most.
const SEARCHES: usize = 2;
/// A chain that was searched at a bandwidth this little worse than the best need not be searched
/// again there.
const NEAR: f64 = 0.02;

/// Logs at their bandwidth.
#[derive(Debug)]
pub struct Tuned<R> {
    /// The logs, filtered.
    pub recording: R,
    /// The chain that was searched, and the first pass over all rows that it asks for.
    pub request: Request,
    /// How the cut-off was chosen.
    pub choice: Option<Choice>,
}

/// One target for all bandwidths: errors of each can be compared.
struct Tried {
    cutoff: f64,
    errors: Errors,
}

/// Searches a chain, and the bandwidth at which it predicts the raw torque of held-out blocks of
/// time best (E12).
///
/// Each candidate filters the motion by itself, the chain's parameters are fitted to the torque of
/// the other blocks at that bandwidth, and what they predict is compared with the torque as it was
/// measured. A low cut-off loses torque, a high one lets noise into q̇ and q̈. Where the best is far
/// from where the chain was searched, it is searched again halfway: a geometry needs more rows than
/// a narrow band has, and less noise than a wide one.
///
/// - `plan`: for a chain
///
/// # Errors
/// As [`reconstruct`](crate::reconstruct()).
pub fn tune<L: RawRecording>(
    logs: &L,
    plan: &Plan,
    progress: &mut dyn FnMut(Progress),
) -> Result<Tuned<L::Filtered>, IdentifyError> {
    let mut cutoff = logs.first_cutoff();
    let mut searches = 0;
    loop {
        let recording = logs.filtered(cutoff).map_err(IdentifyError::Read)?;
        let summary = summarise(&recording, plan, "", progress)?;
        let Solution::Request(request) = solve(summary, plan, progress)? else {
            return Err(IdentifyError::NoLibrary);
        };
        searches += 1;
        let Some(judged) = judge(logs, &request)? else {
            return Ok(Tuned { recording, request: *request, choice: None });
        };
        if judged.is_near(cutoff) || searches == SEARCHES {
            return judged.tuned(logs, *request);
        }
        cutoff = (cutoff * judged.best).sqrt();
    }
}

/// Chooses the bandwidth alone, for a chain that was searched on other logs of the arm (E12).
///
/// # Errors
/// [`IdentifyError`]: the reader's message, or an arm of other joints.
pub fn tune_from<L: RawRecording>(
    logs: &L,
    request: Request,
) -> Result<Tuned<L::Filtered>, IdentifyError> {
    if let Some(judged) = judge(logs, &request)? {
        return judged.tuned(logs, request);
    }
    let recording = logs.filtered(logs.first_cutoff()).map_err(IdentifyError::Read)?;
    Ok(Tuned { recording, request, choice: None })
}

/// Candidates that were tried, at least one.
struct Judged {
    tried: Vec<Tried>,
    /// Error of the best.
    least: f64,
    /// The lowest cut-off near it.
    best: f64,
}

fn judge(logs: &impl RawRecording, request: &Request) -> Result<Option<Judged>, IdentifyError> {
    let tried = tried(logs, request)?;
    let Some(least) = tried.iter().map(|tried| tried.errors.all()).reduce(f64::min) else {
        return Ok(None);
    };
    let lowest = tried.iter().find(|tried| tried.errors.all() <= (1.0 + ALIKE) * least);
    Ok(lowest.map(|tried| tried.cutoff).map(|best| Judged { tried, least, best }))
}

impl Judged {
    /// Whether a cut-off does about as well as the best.
    fn is_near(&self, cutoff: f64) -> bool {
        let here = self.tried.iter().rfind(|tried| tried.cutoff <= cutoff);
        here.is_some_and(|here| here.errors.all() <= (1.0 + NEAR) * self.least)
    }

    /// Logs at the best cut-off.
    fn tuned<L: RawRecording>(
        &self,
        logs: &L,
        request: Request,
    ) -> Result<Tuned<L::Filtered>, IdentifyError> {
        let recording = logs.filtered(self.best).map_err(IdentifyError::Read)?;
        Ok(Tuned { recording, request, choice: Some(choice(&self.tried, self.best)) })
    }
}

/// What candidates leave of the target: every second one, then those beside the best.
fn tried(logs: &impl RawRecording, request: &Request) -> Result<Vec<Tried>, IdentifyError> {
    let one = |cutoff: f64| -> Result<Option<Tried>, IdentifyError> {
        let motion = logs.sample(cutoff).map_err(IdentifyError::Read)?;
        let Some(motion) = motion else { return Ok(None) };
        let errors =
            held_out(request.linearisation(), &motion, logs.raw_torque(), &even_blocks(&motion))?;
        Ok(errors.map(|errors| Tried { cutoff, errors }))
    };
    let all = |cutoffs: Vec<f64>| -> Result<Vec<Tried>, IdentifyError> {
        let found = cutoffs.par_iter().map(|&cutoff| one(cutoff));
        Ok(found.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
    };
    let cutoffs = logs.cutoffs();
    let mut tried = all(cutoffs.iter().step_by(2).copied().collect())?;
    let best = tried.iter().min_by(|a, b| a.errors.all().total_cmp(&b.errors.all()));
    let Some(best) = best.map(|best| best.cutoff) else { return Ok(tried) };
    // Half an octave is a factor of 1.41.
    let is_beside = |cutoff: &f64| (1.2..1.6).contains(&(cutoff / best).max(best / cutoff));
    tried.extend(all(cutoffs.into_iter().filter(is_beside).collect())?);
    tried.sort_by(|a, b| a.cutoff.total_cmp(&b.cutoff));
    Ok(tried)
}

fn choice(tried: &[Tried], chosen: f64) -> Choice {
    let label = |cutoff: f64| format!("{cutoff:.2} Hz");
    let candidate = |tried: &Tried| Candidate {
        label: label(tried.cutoff),
        error: tried.errors.all(),
        std_error: standard_error(&tried.errors.by_block()),
        complexity: 1,
    };
    Choice {
        what: "cut-off of the filter".into(),
        chosen: label(chosen),
        rule: format!(
            "lowest near the least error in raw torque, {BLOCKS} blocks of time held out"
        ),
        from: tried.iter().map(candidate).collect(),
    }
}
