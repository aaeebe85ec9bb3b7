//! Cut-off of the filter and delay of the torque: where a learned chain predicts held-out raw torque
//! best (E12) (E19).

use crate::reconstruct::surveyed;
use crate::rounds::{Request, Searched};
use crate::unseen::{BLOCKS, Errors};
use crate::{Linearisation, Method, Plan, Progress, Unseen, Watch, even_blocks, summarise};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use torquewise_model::Choice;
use torquewise_model::model::Candidate;
use torquewise_motion::RawRecording;
use torquewise_motion::signals::bandwidth::Band;
use torquewise_stepwise::IdentifyError;
use torquewise_stepwise::held_out::{mean, standard_error};

/// Of cut-offs whose errors differ by no more than this part, the lowest is taken: it lets the
/// least noise through.
const ALIKE: f64 = 0.005;
/// The first search is made so much above the first cut-off: what is friction at a reversal is
/// seen in a wide band only.
const WIDER: f64 = 2.5;
/// A chain that was searched at a bandwidth this little worse than the best need not be searched
/// again there.
const NEAR: f64 = 0.02;
/// Near a reversal friction that no law holds looks like a torque that is early: a delay is chosen by the
/// rows at which a joint has more than this part of its RMS speed.
const SLOW: f64 = 0.1;
/// A delay must lower the error by this part, and by so many standard errors of the gain over the
/// blocks: what friction lacks can pass for a small one.
const LEAST_GAIN: f64 = 0.03;
const LEAST_CERTAINTY: f64 = 2.0;

/// So many delays more are tried beyond the longest where that leaves least, and so often.
const MORE_DELAYS: (u32, usize) = (8, 5);

/// Cut-offs beside the best of every second one, at most.
const BESIDE: usize = 2;

/// Logs at their bandwidth.
#[derive(Debug)]
pub struct Tuned<R> {
    /// The logs, filtered.
    pub recording: R,
    /// The chain that was searched, and the first pass over all rows that it asks for.
    pub request: Request,
    /// How cut-off and delay were chosen.
    pub choices: Vec<Choice>,
}

/// A cut-off \[Hz\] and a delay of the torque \[s\], and what they leave of raw torque.
struct Tried {
    cutoff: f64,
    delay: f64,
    errors: Errors,
}

/// Searches a chain, and the bandwidth and the delay at which it predicts the raw torque of held-out
/// blocks of time best (E12) (E19).
///
/// Each candidate filters the motion by itself, the chain's parameters are fitted to the torque of
/// the other blocks at that bandwidth, and what they predict is compared with the torque as it was
/// measured. A low cut-off loses torque, a high one lets noise into q̇ and q̈. Where the best is far
/// from where the chain was searched, it is searched again halfway, what its joints are taken as found:
/// a geometry needs more rows than a narrow band has, and less noise than a wide one. A delay is taken
/// only for a clear gain, and the chain searched again with it.
///
/// - `plan`: for a chain
///
/// # Errors
/// As [`reconstruct`](crate::reconstruct()).
pub fn tune<L: RawRecording>(
    logs: &L,
    plan: &Plan,
    watch: Watch<'_>,
) -> Result<Tuned<L::Filtered>, IdentifyError> {
    let widest = logs.cutoffs().last().copied().unwrap_or_else(|| logs.first_cutoff());
    let mut cutoff = (WIDER * logs.first_cutoff()).min(widest);
    let mut delay = no_delay(logs);
    let Method::Chain(options) = &plan.method else { return Err(IdentifyError::NoLibrary) };
    let mut before = None;
    loop {
        let recording = logs.filtered(cutoff, delay)?;
        let summary = summarise(&recording, plan, "", watch)?;
        let survey = match surveyed(&summary) {
            // Long rest or slow motion makes for a cut-off that leaves few rows.
            Err(IdentifyError::TooFewRows { .. }) if cutoff < widest => {
                let lowest = logs.cutoffs().first().copied().unwrap_or(widest);
                cutoff = (2.0 * cutoff).clamp(lowest, widest);
                continue;
            }
            survey => survey?,
        };
        let (of_logs, is_second) = ((summary.settings.filtered, plan.seed), before.is_some());
        let searched = Searched::of(&survey, options, of_logs, before, watch)?;
        // Torques that never change choose nothing.
        let tells = survey.torque_std.iter().any(|std| *std > 0.0);
        let grid = if tells { Grid::of(logs, &searched.at, watch)? } else { None };
        let Some(grid) = grid else {
            let request = searched.refined(watch)?;
            return Ok(Tuned { recording, request, choices: Vec::new() });
        };
        let is_last = grid.is_near(cutoff) && grid.delay.total_cmp(&delay).is_eq();
        (cutoff, delay) = ((cutoff * grid.cutoff).sqrt(), grid.delay);
        if is_last || is_second {
            return grid.tuned(logs, searched.refined(watch)?);
        }
        before = Some(searched.learned);
    }
}

/// The delay that is set, or none.
fn no_delay(logs: &impl RawRecording) -> f64 {
    if let [set] = logs.delays()[..] { set } else { 0.0 }
}

/// What candidates leave of raw torque: cut-offs without a delay and with the best one, and delays
/// at the best cut-off.
struct Grid {
    /// At the chosen delay, by ascending cut-off.
    cutoffs: Vec<Tried>,
    /// At the best cut-off, by ascending delay; the one that is set.
    delays: Vec<Tried>,
    /// The best cut-off, and the delay that is chosen.
    cutoff: f64,
    delay: f64,
}

impl Grid {
    /// `None` where the logs are too short.
    fn of(
        logs: &impl RawRecording,
        chain: &Linearisation,
        watch: Watch<'_>,
    ) -> Result<Option<Self>, IdentifyError> {
        let none = no_delay(logs);
        let mut cutoffs = cutoffs(logs, (chain, none), watch)?;
        let Some(cutoff) = lowest_near_best(&cutoffs) else { return Ok(None) };
        let delays = delays(logs, (chain, cutoff), watch)?;
        let mut delay = none;
        if let Some(best) = best_delay(&delays)
            && is_clear(&at(logs, chain, (cutoff, &[none, best]), SLOW, watch)?)
        {
            delay = best;
            cutoffs = self::cutoffs(logs, (chain, delay), watch)?;
        }
        let best = lowest_near_best(&cutoffs);
        Ok(best.map(|cutoff| Self { cutoffs, delays, cutoff, delay }))
    }

    /// Whether a cut-off does about as well as the best.
    fn is_near(&self, cutoff: f64) -> bool {
        let errors = self.cutoffs.iter().map(|tried| tried.errors.all());
        let least = errors.fold(f64::INFINITY, f64::min);
        let here = self.cutoffs.iter().rfind(|tried| tried.cutoff <= cutoff);
        here.is_some_and(|here| here.errors.all() <= (1.0 + NEAR) * least)
    }

    fn tuned<L: RawRecording>(
        &self,
        logs: &L,
        request: Request,
    ) -> Result<Tuned<L::Filtered>, IdentifyError> {
        let Self { cutoff, delay, .. } = *self;
        let recording = logs.filtered(cutoff, delay)?;
        let hertz = |cutoff: f64| format!("{cutoff:.2} Hz");
        let milliseconds = |delay: f64| format!("{:.1} ms", 1e3 * delay);
        let of = |tried: &Tried, label: String| Candidate {
            label,
            error: tried.errors.all(),
            std_error: standard_error(&tried.errors.by_block()),
            complexity: 1,
        };
        let cutoffs = self.cutoffs.iter().map(|tried| of(tried, hertz(tried.cutoff))).collect();
        let delays = self.delays.iter().map(|tried| of(tried, milliseconds(tried.delay))).collect();
        let lowest =
            ("cut-off of the filter", hertz(cutoff), "lowest near the least error", cutoffs);
        let rule = "lowest of a parabola, but none without a clear gain, in motion,";
        let clear = ("delay of the torque", milliseconds(delay), rule, delays);
        let choice = |(what, chosen, rule, from): (&str, String, &str, Vec<Candidate>)| Choice {
            what: what.to_owned(),
            chosen,
            rule: format!("{rule} in raw torque, {BLOCKS} blocks of time held out"),
            from,
        };
        let mut choices: Vec<Choice> = [lowest, clear].map(choice).into();
        choices.retain(|choice| choice.from.len() > 1);
        Ok(Tuned { recording, request, choices })
    }
}

/// Of cut-offs near the least error the lowest.
fn lowest_near_best(tried: &[Tried]) -> Option<f64> {
    let least = tried.iter().map(|tried| tried.errors.all()).reduce(f64::min)?;
    let near = tried.iter().filter(|tried| tried.errors.all() <= (1.0 + ALIKE) * least);
    near.map(|tried| tried.cutoff).reduce(f64::min)
}

/// The delay of least error, unless that is at an end of those that were tried: where a parabola
/// through the squared errors of the best and the two beside it is least.
fn best_delay(tried: &[Tried]) -> Option<f64> {
    let square = |own: &Tried| own.errors.all().powi(2);
    let numbered = tried.iter().enumerate();
    let (at, best) = numbered.min_by(|(_, a), (_, b)| square(a).total_cmp(&square(b)))?;
    let [before, after] = [tried.get(at.checked_sub(1)?)?, tried.get(at + 1)?];
    let [falls, rises] = [before, after].map(|beside| square(beside) - square(best));
    let step = 0.5 * (after.delay - before.delay);
    Some(best.delay + 0.5 * step * (falls - rises) / (falls + rises).max(f64::MIN_POSITIVE))
}

/// Whether the second of two delays is clearly better than the first.
fn is_clear(tried: &[Tried]) -> bool {
    let [without, with] = tried else { return false };
    let pairs = without.errors.by_block().into_iter().zip(with.errors.by_block());
    let gains: Vec<f64> = pairs.map(|(without, with)| (without / with).ln()).collect();
    let gain = (without.errors.all() / with.errors.all()).ln();
    gain > LEAST_GAIN && mean(&gains) > LEAST_CERTAINTY * standard_error(&gains)
}

/// What cut-offs leave with a delay: every second one, then those beside the best.
fn cutoffs(
    logs: &impl RawRecording,
    (chain, delay): (&Linearisation, f64),
    watch: Watch<'_>,
) -> Result<Vec<Tried>, IdentifyError> {
    let cutoffs = logs.cutoffs();
    let most = cutoffs.len().div_ceil(2) + BESIDE;
    let made = AtomicUsize::new(0);
    let all = |cutoffs: Vec<f64>| -> Result<Vec<Tried>, IdentifyError> {
        let found = cutoffs.par_iter().map(|&cutoff| {
            let made = made.fetch_add(1, Ordering::Relaxed);
            Progress::Bandwidth { made, most }.tell(watch)?;
            at(logs, chain, (cutoff, &[delay]), 0.0, watch)
        });
        Ok(found.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
    };
    let mut tried = all(cutoffs.iter().step_by(2).copied().collect())?;
    let best = tried.iter().min_by(|a, b| a.errors.all().total_cmp(&b.errors.all()));
    let Some(best) = best.map(|best| best.cutoff) else { return Ok(tried) };
    // Half an octave is a factor of 1.41.
    let is_beside = |cutoff: &f64| (1.2..1.6).contains(&(cutoff / best).max(best / cutoff));
    tried.extend(all(cutoffs.into_iter().filter(is_beside).collect())?);
    tried.sort_by(|a, b| a.cutoff.total_cmp(&b.cutoff));
    Ok(tried)
}

/// What delays leave at a cut-off, longer ones too where the longest leaves least.
fn delays(
    logs: &impl RawRecording,
    (chain, cutoff): (&Linearisation, f64),
    watch: Watch<'_>,
) -> Result<Vec<Tried>, IdentifyError> {
    let mut tried = at(logs, chain, (cutoff, &logs.delays()), SLOW, watch)?;
    for _ in 0..MORE_DELAYS.1 {
        let [.., before, last] = &tried[..] else { break };
        if tried.iter().any(|own| own.errors.all() < last.errors.all()) {
            break;
        }
        let step = last.delay - before.delay;
        let more = (1..=MORE_DELAYS.0).map(|k| last.delay + f64::from(k) * step);
        tried.extend(at(logs, chain, (cutoff, &more.collect::<Vec<f64>>()), SLOW, watch)?);
    }
    Ok(tried)
}

/// What delays leave at a cut-off; nothing where the logs are too short.
fn at(
    logs: &impl RawRecording,
    chain: &Linearisation,
    (cutoff, delays): (f64, &[f64]),
    slow: f64,
    watch: Watch<'_>,
) -> Result<Vec<Tried>, IdentifyError> {
    Progress::Working.tell(watch)?;
    let band = logs.band(cutoff, delays)?;
    let Some(Band { motion, torques }) = band else { return Ok(Vec::new()) };
    let targets: Vec<_> = torques.iter().map(|torque| (&torque.filtered, &torque.raw)).collect();
    let blocks = even_blocks(&motion);
    let unseen = Unseen::new(chain, &motion, &targets, &blocks, slow)?;
    let errors = unseen.and_then(|unseen| unseen.errors_of_all());
    let tried = torques.iter().zip(errors.into_iter().flatten());
    Ok(tried.map(|(torque, errors)| Tried { cutoff, delay: torque.delay, errors }).collect())
}
