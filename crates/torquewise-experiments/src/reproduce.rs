//! Settings → results: every experiment, one after the other on all cores.

use crate::agenda::{Agenda, Progress};
use crate::claims::judge_claims;
use crate::error::ExperimentError;
use crate::results::Results;
use crate::settings::Settings;
use crate::study::ablation;
use crate::study::arms;
use crate::study::cases::{self, true_terms};
use crate::study::coefficients::judge_coefficients;
use crate::study::cost;
use crate::study::order_curves::study_orders;
use crate::study::patterns::study_patterns;
use crate::study::steps::study_steps;
use crate::study::sweeps;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Work of the experiments that are no trials, in units of a small reconstruction.
const PATTERN_WORK: usize = 6;
const ORDER_WORK: usize = 60;
const EVALUATION_WORK: usize = 30;

/// Does every experiment.
///
/// `progress` is called when work begins or is done, from any thread.
///
/// # Errors
/// [`ExperimentError::Setting`] for settings that ask for nothing, else what kept an experiment from
/// being done.
pub fn reproduce(
    settings: &Settings,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<Results, ExperimentError> {
    settings.check()?;
    let mut agenda = Agenda::default();
    let costs = cost::ask(&mut agenda, settings);
    let cases = cases::ask(&mut agenda, settings);
    let ablation = ablation::ask(&mut agenda, settings);
    let noise = sweeps::ask_noise(&mut agenda, settings);
    let lengths = sweeps::ask_lengths(&mut agenda, settings);
    let arms = arms::ask(&mut agenda, settings);

    let total = agenda.work() + PATTERN_WORK + ORDER_WORK + EVALUATION_WORK;
    let done = AtomicUsize::new(0);
    let advance = |doing: &'static str, work: usize| {
        let done = done.fetch_add(work, Ordering::Relaxed) + work;
        progress(Progress { doing, done, total });
    };
    advance("patterns", 0);
    let patterns = study_patterns(settings)?;
    advance("orders", PATTERN_WORK);
    let orders = study_orders(settings)?;
    advance("timed trials", ORDER_WORK);
    let trials = agenda.run(settings.seed, &advance)?;
    advance("evaluating whole libraries", 0);
    let costs = cost::costs(&costs, settings, &trials)?;
    advance("results", EVALUATION_WORK);

    let judged = cases.iter().filter(|case| case.case > 1);
    let second = cases.iter().find(|case| case.case == 2);
    let mut results = Results {
        settings: settings.clone(),
        patterns,
        orders,
        costs,
        true_terms: true_terms(settings.arm)?,
        cases: cases.iter().map(|c| c.results(settings, &trials)).collect::<Result<_, _>>()?,
        steps: second.map_or(Ok(Vec::new()), |case| study_steps(case, settings, &trials))?,
        ablation: ablation.iter().map(|v| v.result(settings, &trials)).collect::<Result<_, _>>()?,
        noise_sweep: noise.iter().map(|p| p.result(&trials)).collect::<Result<_, _>>()?,
        length_sweep: lengths.iter().map(|p| p.result(&trials)).collect::<Result<_, _>>()?,
        arms: arms.iter().map(|arm| arm.result(&trials)).collect::<Result<_, _>>()?,
        coefficients: judged
            .map(|case| judge_coefficients(case, settings, &trials))
            .collect::<Result<_, _>>()?,
        claims: Vec::new(),
    };
    results.claims = judge_claims(&results);
    Ok(results)
}
