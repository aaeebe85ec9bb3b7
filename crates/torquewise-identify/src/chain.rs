//! Survey → Reconstruction by a learned chain: geometry, masses, friction to energy terms (E8).

use crate::basis::{Energies, joint_sums};
use crate::beside::Beside;
use crate::error::IdentifyError;
use crate::found::{Progress, Reconstruction, StepReport};
use crate::learn::{Learned, learn};
use crate::noise::NoiseFloor;
use crate::overlooked::{Tried, overlooked};
use crate::patterns::Patterns;
use crate::plan::ChainOptions;
use crate::prune::prune;
use crate::survey::Survey;
use crate::warning::Warning;
use torquewise_chain::Chain;
use torquewise_model::{EnergyTerm, Form, FrictionTerm, Model, Weighted};
use torquewise_sparse::accumulate::Route;

/// Terms beyond those of a chain at most.
const MOST_FURTHER: usize = 12;
/// So many terms are refused before no other is offered: the log is too short to tell.
const MOST_REFUSED: usize = 2;

/// Learns a chain from the sample of a survey and lists the equations of motion that follow.
pub(crate) fn by_chain(
    survey: Survey,
    patterns: Patterns,
    options: &ChainOptions,
    seed: u64,
    progress: &mut dyn FnMut(Progress),
) -> Result<Reconstruction, IdentifyError> {
    progress(Progress::Geometry);
    let mut learned = learn(&survey.sample, options, seed)?;
    progress(Progress::Overlooked);
    let tried = complete(&mut learned, &survey, options)?;
    progress(Progress::Refit);
    let beside = &learned.recipe.beside;
    let all = energies(&learned.chain, beside)?;
    let friction = friction(&learned);
    let candidates = all.len() + friction.len();
    let few = |all: Energies| {
        prune(all.into_iter().collect(), &survey.sample, &learned.chain.residual_rms, seed)
    };
    let (products, sums) = (few(all.clone()), few(joint_sums(&all)));
    let without = (learned.without.iter())
        .map(|chain| energies(chain, beside))
        .collect::<Result<Vec<_>, _>>()?;
    // Parallel axes make sums shorter, others products.
    let (kept, without) = if sums.len() < products.len() {
        (sums, without.iter().map(joint_sums).collect())
    } else {
        (products, without)
    };
    let terms: Vec<Weighted<EnergyTerm>> = kept
        .into_iter()
        .map(|(term, coefficient)| {
            let others: Vec<f64> =
                without.iter().map(|all| all.get(&term).copied().unwrap_or(0.0)).collect();
            Weighted { std_error: jackknife(&others), term, coefficient, inclusion: None }
        })
        .collect();
    let mut warnings = Warning::of_survey(&survey);
    warnings.extend(tried.warning);
    progress(Progress::Done);
    let form = Form::Energy(terms);
    let joints = survey.joints.clone();
    let mut training = survey.training(learned.chain.residual_rms.clone());
    training.overlooked = Some(tried.certificate);
    let model =
        Model { joints, form, friction, stages: Vec::new(), training, choices: learned.choices };
    let step = StepReport {
        name: "all rows",
        rows: survey.rows,
        candidates,
        active: model.active(),
        route: Route::Direct,
    };
    let noise: NoiseFloor = survey.noise.clone();
    let (steps, dropped) = (vec![step], Vec::new());
    Ok(Reconstruction { model, survey, patterns, noise, candidates, steps, dropped, warnings })
}

/// Takes in, one by one, terms of the energy library that explain what no chain does, until no
/// other seems to, or too many were refused.
fn complete(
    learned: &mut Learned,
    survey: &Survey,
    options: &ChainOptions,
) -> Result<Tried, IdentifyError> {
    let mut refused = Vec::new();
    let mut tried = overlooked(learned, survey, options.friction, &refused)?;
    for _ in 0..MOST_FURTHER {
        let Some(term) = tried.missing.take() else { break };
        if !learned.offer(&term, &survey.sample)? {
            refused.push(term);
        }
        tried = overlooked(learned, survey, options.friction, &refused)?;
        if refused.len() == MOST_REFUSED {
            break;
        }
    }
    Ok(tried)
}

/// All energy terms of a chain and what stands beside it.
fn energies(chain: &Chain, beside: &[Beside]) -> Result<Energies, IdentifyError> {
    let mut all = Energies::new();
    let of_beside =
        beside.iter().zip(&chain.beside).flat_map(|(beside, &c)| beside.energy_terms(c));
    for (term, coefficient) in chain.energy_terms()?.into_iter().chain(of_beside) {
        *all.entry(term).or_insert(0.0) += coefficient;
    }
    Ok(all)
}

/// The friction that was learned, with standard errors.
fn friction(learned: &Learned) -> Vec<Weighted<FrictionTerm>> {
    let weighted = |(place, beside): (usize, &Beside)| {
        let Beside::Friction(term) = beside else { return None };
        let others: Vec<f64> = learned.without.iter().map(|chain| chain.beside[place]).collect();
        Some(Weighted {
            term: term.clone(),
            coefficient: learned.chain.beside[place],
            std_error: jackknife(&others),
            inclusion: None,
        })
    };
    learned.recipe.beside.iter().enumerate().filter_map(weighted).collect()
}

/// Standard error of a coefficient from its values with each block of the log left out.
///
/// Source: B. Efron, The Jackknife, the Bootstrap and Other Resampling Plans (1982), with blocks in
/// place of samples, since neighbours in time are alike.
fn jackknife(without: &[f64]) -> f64 {
    let count = without.len() as f64;
    let mean = without.iter().sum::<f64>() / count;
    let squares: f64 = without.iter().map(|x| (x - mean).powi(2)).sum();
    ((count - 1.0) / count * squares).sqrt()
}
