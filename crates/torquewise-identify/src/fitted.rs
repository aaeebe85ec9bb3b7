//! The model of a converged chain, its equations without terms near zero (E8) (E11).

use crate::basis::{Energies, Wanted, joint_sums};
use crate::drift::drifts;
use crate::estimate::Solved;
use crate::prune::prune;
use crate::torque_kind::{hardly_weighs, torque_kind};
use crate::{
    DriveTerm, HeldOut, HeldTo, Linearisation, Progress, Reconstruction, Sizes, Unseen, Warning,
    Watch, both_ways, geometric_mean, weightless,
};
use faer::Mat;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::prelude::*;
use std::ops::ControlFlow;
use torquewise_model::{
    Choice, Drive, EnergyTerm, Form, FrictionTerm, GeometryFound, Model, RigidChain, Torque,
    Training, Weighted,
};
use torquewise_regression::ascending;
use torquewise_rigid::PER_BODY;
use torquewise_stepwise::{IdentifyError, NoiseFloor, Patterns, StepReport, Survey, thinned};

/// Rows on which the error of blocks that were held out is found, at most.
const HELD_OUT_ROWS: usize = 4_000;
/// Draws of the parameters that the errors of the equations are estimated from.
const DRAWS: usize = 40;
/// Size of these draws in standard deviations: so small that all is linear even where torque leaves an
/// axis uncertain by a hundred metres, as it does those of a SCARA.
const DRAW_SIZE: f64 = 1e-7;
/// A term is of a loaded arm, where its coefficient changes by this part of the largest change.
const GAINED: f64 = 1e-3;

/// A chain that was fitted to every row.
#[derive(Debug)]
pub(crate) struct Fitted {
    pub(crate) solved: Solved,
    /// Usual sizes of the arm, that it was held to.
    pub(crate) sizes: Sizes,
    /// RMS of the residual of each joint \[N·m\], n.
    pub(crate) residual_rms: Vec<f64>,
    pub(crate) choices: Vec<Choice>,
    /// How often it found the geometry.
    pub(crate) found: Option<GeometryFound>,
    /// What is to be said of the passes, if anything.
    pub(crate) warning: Option<Warning>,
}

impl Fitted {
    /// The model of the chain: its parameters, and the equations that follow from them.
    pub(crate) fn report(
        self,
        survey: Survey,
        patterns: Patterns,
        seed: u64,
        watch: Watch<'_>,
    ) -> Result<Reconstruction, IdentifyError> {
        let Self { solved, sizes, residual_rms, choices, found, warning } = self;
        let mut training = survey.training(residual_rms);
        let narrowed = solved.at.narrowed();
        [training.held_out_rms, training.held_out_by_region_rms] =
            held_out_rms((&narrowed, solved.prior_rows, &sizes), &survey)?;
        let mut warnings = Warning::of_survey(&survey);
        training.geometry_found = found.map(|found| GeometryFound {
            unresolved: untold(found.unresolved, &survey.joints, &warnings),
            ..found
        });
        let residual_rms = &training.residual_rms;
        let covariance = faer::Scale(discrepancy(&training).powi(2)) * &solved.covariance;
        let error = |k: usize| covariance[(k, k)].max(0.0).sqrt();
        let (mut chain, friction, order) = parameters(&solved.at, &error);
        let p = order.len();
        chain.set_covariance(&Mat::from_fn(p, p, |i, j| covariance[(order[i], order[j])]))?;
        let (terms, candidates) =
            equations(&chain, &friction, (&survey, residual_rms), seed, watch)?;
        warnings.extend(warning);
        let mut model = Model {
            joints: survey.joints.clone(),
            form: Form::Energy(terms),
            chain: Some(chain),
            friction,
            training,
            choices,
            ..Model::default()
        };
        let noise = &solved.at.noise;
        Progress::Working.tell(watch)?;
        let kind = match torque_kind(&narrowed, (&survey.sample, &survey.dq_peak), seed, watch)? {
            // Axes that were learned may lie so that gravity does next to nothing.
            None if hardly_weighs(&model, &survey.sample)? => weightless(&survey, seed, watch),
            kind => kind,
        };
        warnings.extend(kind);
        Progress::Working.tell(watch)?;
        warnings.extend(drifts(&model, &survey.sample)?);
        model.training.unexplained_rms = unexplained(&model, &survey, noise)?;
        let step =
            StepReport { name: "all rows", rows: survey.rows, candidates, active: model.active() };
        let (steps, dropped, noise) = (vec![step], Vec::new(), survey.noise.clone());
        Ok(Reconstruction { model, survey, patterns, noise, candidates, steps, dropped, warnings })
    }
}

/// Joints whose axis is not resolved: those told, and those beyond the first of some that always move
/// together, up to the last.
fn untold(mut told: Vec<usize>, names: &[String], warnings: &[Warning]) -> Vec<usize> {
    for warning in warnings {
        if let Warning::Together { joints, .. } = warning {
            let is_of = |joint: &String| joints.contains(joint);
            let ends = names.iter().position(is_of).zip(names.iter().rposition(is_of));
            told.extend(ends.into_iter().flat_map(|(first, last)| first + 1..=last));
        }
    }
    ascending(told)
}

/// How many times as large as the residual is what is left of rows that were held out, the larger
/// of two ways to hold them out, geometric mean of the joints: what the model gets wrong scatters
/// less over its own rows than over others, and parameters err by as much more (E22).
fn discrepancy(training: &Training) -> f64 {
    let unseen = training.unseen_rms();
    // What was held out of a torque that never changes is judged by nothing.
    let pairs = unseen.iter().zip(&training.residual_rms).filter(|(unseen, _)| **unseen > 0.0);
    let ratios = pairs.map(|(unseen, residual)| unseen / residual.max(f64::MIN_POSITIVE));
    geometric_mean(&ratios.collect::<Vec<_>>())
}

/// The parameters of a linearisation as a model has them, without a covariance, and where each is.
///
/// - `error`: standard error of a parameter
fn parameters(
    at: &Linearisation,
    error: &dyn Fn(usize) -> f64,
) -> (RigidChain, Vec<Weighted<FrictionTerm>>, Vec<usize>) {
    let bodies = PER_BODY * at.n_joints();
    let links = at.linear[..bodies].as_chunks::<PER_BODY>().0.to_vec();
    let (mut drives, mut friction) = (Vec::new(), Vec::new());
    let (mut drive_at, mut friction_at) = (Vec::new(), Vec::new());
    for (k, term) in at.drive.iter().enumerate() {
        let (index, coefficient) = (bodies + k, at.linear[bodies + k]);
        match term {
            DriveTerm::Friction(term) => {
                friction_at.push(index);
                let std_error = error(index);
                friction.push(Weighted { std_error, ..Weighted::new(term.clone(), coefficient) });
            }
            DriveTerm::Rotor(shaft) => {
                drive_at.push(index);
                drives.push(Drive::Rotor { shaft: shaft.clone(), inertia: coefficient });
            }
            DriveTerm::Energy(term) => {
                drive_at.push(index);
                drives.push(Drive::Energy { term: term.clone(), coefficient });
            }
        }
    }
    let order: Vec<usize> = (0..bodies)
        .chain(drive_at)
        .chain(friction_at)
        .chain(at.free.iter().map(|&k| at.linear.len() + k))
        .collect();
    let chain = RigidChain {
        geometry: at.geometry.parameters().to_vec(),
        fitted: at.free.clone(),
        links,
        drives,
        coupling: at.geometry.coupling().clone(),
        kinds: at.geometry.kinds().clone(),
        robot: at.robot.clone(),
        covariance_root: Vec::new(),
    };
    (chain, friction, order)
}

/// The model of a linearisation as far as it moves: without its equations and its errors.
pub(crate) fn movable(at: &Linearisation, joints: &[String]) -> Model {
    let (chain, friction, _) = parameters(at, &|_| 0.0);
    let (joints, chain) = (joints.to_vec(), Some(chain));
    Model { joints, form: Form::Energy(Vec::new()), chain, friction, ..Model::default() }
}

/// RMS of what is left of the raw torque of each joint \[N·m\] on rows that were held out and that
/// noise does not explain, n.
fn unexplained(
    model: &Model,
    survey: &Survey,
    noise: &NoiseFloor,
) -> Result<Vec<f64>, IdentifyError> {
    let explained = noise.in_torque(&Torque::new(model), &survey.sample)?;
    let rows = survey.sample.n_rows().max(1) as f64;
    let of_joint = |(joint, rms): (usize, f64)| {
        let rms = rms.hypot(survey.removed_rms[joint]);
        let left = rms * rms - explained.col(joint).sum() / rows;
        // A mean square over so many rows is not known better than that.
        left.max((2.0 / model.training.rows.max(1) as f64).sqrt() * rms * rms).sqrt()
    };
    Ok(model.training.unseen_rms().into_iter().enumerate().map(of_joint).collect())
}

/// RMS of what is left of the torque of each joint \[N·m\] on whole logs, or on blocks of time of a
/// single one, that were held out; and on regions of configuration (E20). Nothing where there are
/// too few rows.
fn held_out_rms(
    (at, prior_rows, sizes): (&Linearisation, f64, &Sizes),
    survey: &Survey,
) -> Result<[Vec<f64>; 2], IdentifyError> {
    let few = thinned(&survey.sample, HELD_OUT_ROWS);
    let share = few.n_rows() as f64 / survey.rows.max(1) as f64;
    let held_to = HeldTo::of(at, sizes, share * prior_rows);
    let tau = few.require_tau()?.to_owned();
    let (target, columns) = ([(&tau, &tau)], at.columns_of(&few, true)?);
    let rms = |blocks: Vec<HeldOut>| {
        let unseen = Unseen::of_columns(columns.clone(), few.n_rows(), &target, &blocks)?;
        Some(unseen.physical_errors(&held_to)?.rms_by_joint())
    };
    Ok(both_ways(&few, &survey.sample).map(|blocks| rms(blocks).unwrap_or_default()))
}

/// The energy terms of a chain that its torque needs, with their standard errors; and how many there
/// were.
fn equations(
    chain: &RigidChain,
    friction: &[Weighted<FrictionTerm>],
    (survey, residual_rms): (&Survey, &[f64]),
    seed: u64,
    watch: Watch<'_>,
) -> Result<(Vec<Weighted<EnergyTerm>>, usize), IdentifyError> {
    let all = energies(chain)?;
    let candidates = all.len() + friction.len();
    let few = |all: Energies| prune(all.into_iter().collect(), &survey.sample, residual_rms, seed);
    let (products, sums) = (few(all.clone()), few(joint_sums(&all)));
    // Parallel axes make sums shorter, others products.
    let as_sums = sums.len() < products.len();
    let kept = if as_sums { sums } else { products };
    Ok((with_errors(kept, (chain, friction), seed, watch)?, candidates))
}

fn energies(chain: &RigidChain) -> Result<Energies, IdentifyError> {
    let mut all = Energies::new();
    for (term, coefficient) in chain.energy_terms()? {
        *all.entry(term).or_insert(0.0) += coefficient;
    }
    Ok(all)
}

/// The energy terms of a chain that carries a load: those of its model without it, and what the load
/// adds.
pub(crate) fn loaded_equations(
    model: &Model,
    [bare, loaded]: [&RigidChain; 2],
) -> Result<Vec<Weighted<EnergyTerm>>, IdentifyError> {
    let Form::Energy(before) = &model.form else { return Ok(Vec::new()) };
    let (mut without, mut with) = (energies(bare)?, energies(loaded)?);
    if !before.iter().all(|own| with.contains_key(&own.term)) {
        (without, with) = (joint_sums(&without), joint_sums(&with));
    }
    let gained = |(term, coefficient): (&EnergyTerm, &f64)| {
        (coefficient - without.get(term).unwrap_or(&0.0)).abs()
    };
    let least = GAINED * with.iter().map(gained).fold(0.0, f64::max);
    let is_kept = |own: &(&EnergyTerm, &f64)| {
        before.iter().any(|printed| printed.term == *own.0) || gained(*own) > least
    };
    let kept = with.iter().filter(is_kept).map(|(term, own)| (term.clone(), *own)).collect();
    with_errors(kept, (loaded, &model.friction), 0, &|_| ControlFlow::Continue(()))
}

/// Terms with their coefficients in a chain, with the standard errors that its covariance gives them.
fn with_errors(
    terms: Vec<(EnergyTerm, f64)>,
    (chain, friction): (&RigidChain, &[Weighted<FrictionTerm>]),
    seed: u64,
    watch: Watch<'_>,
) -> Result<Vec<Weighted<EnergyTerm>>, IdentifyError> {
    let wanted = Wanted::of(terms.iter().map(|(term, _)| term));
    let draws = draws(chain, friction, seed);
    let draws = draws.into_par_iter().map(|chain| {
        Progress::Working.tell(watch)?;
        Ok(wanted.coefficients_in(&chain)?)
    });
    let draws = draws.collect::<Result<Vec<Vec<f64>>, IdentifyError>>()?;
    let terms = terms.into_iter().enumerate().map(|(k, (term, coefficient))| {
        let change = |draw: &Vec<f64>| (draw[k] - coefficient) / DRAW_SIZE;
        let square: f64 = draws.iter().map(|draw| change(draw).powi(2)).sum();
        let std_error = (square / draws.len().max(1) as f64).sqrt();
        Weighted { term, coefficient, std_error, inclusion: None }
    });
    Ok(terms.collect())
}

/// Chains whose parameters scatter by the covariance, but less.
fn draws(chain: &RigidChain, friction: &[Weighted<FrictionTerm>], seed: u64) -> Vec<RigidChain> {
    let known = chain.parameters(friction);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut draw = || {
        let units: Vec<f64> = (&mut random).sample_iter(StandardNormal).take(known.len()).collect();
        let moved = |(x, root): (&f64, &Vec<f64>)| {
            x + DRAW_SIZE * root.iter().zip(&units).map(|(root, unit)| root * unit).sum::<f64>()
        };
        let moved: Vec<f64> = known.iter().zip(&chain.covariance_root).map(moved).collect();
        chain.at(&moved, friction.len())
    };
    (0..DRAWS).map(|_| draw()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_between_joints_that_move_together_are_not_resolved() {
        let names: Vec<String> = (1..=6).map(|joint| format!("joint{joint}")).collect();
        let joints = vec![names[2].clone(), names[4].clone()];
        let together = Warning::Together { joints, correlation: 1.0 };

        assert_eq!(untold(vec![5, 3], &names, &[together]), [3, 4, 5]);
        assert_eq!(untold(vec![1], &names, &[]), [1]);
    }
}
