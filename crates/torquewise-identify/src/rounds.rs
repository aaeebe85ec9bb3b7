//! A chain in rounds: a search on a sample, then passes over every row (E8) (E11).
//!
//! A [`Request`] is all that the next pass needs. It can be saved, so that the logs of a pass may
//! be read apart and their sums merged.

use crate::basis::{Energies, joint_sums};
use crate::beside::Beside;
use crate::estimate::{Linearisation, Next, Passes, STRENGTH, Sizes, Solved, Structure, refine};
use crate::found::{Progress, Reconstruction, StepReport};
use crate::learn::{AT_REST, LAST_ROWS, Learned, learn};
use crate::overlooked::{Tried, overlooked};
use crate::plan::{ChainOptions, FrictionKind};
use crate::prune::prune;
use crate::warning::{UntriedTerm, Warning};
use faer::{ColRef, Mat};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use torquewise_model::model::{Choice, Overlooked};
use torquewise_model::{Drive, EnergyTerm, Form, FrictionTerm, Model, RigidChain, Weighted};
use torquewise_regression::accumulate::Route;
use torquewise_regression::normal_sums::{FOLDS, NormalSums};
use torquewise_rigid::recursion::PER_BODY;
use torquewise_stepwise::patterns::Patterns;
use torquewise_survey::error::IdentifyError;
use torquewise_survey::noise::NoiseFloor;
use torquewise_survey::survey::{Survey, thinned};

/// Terms beyond those of a chain at most.
const MOST_FURTHER: usize = 12;
/// So many terms are refused before no other is offered: the log is too short to tell.
const MOST_REFUSED: usize = 2;
/// Passes over all rows at most.
const MOST_PASSES: usize = 5;
/// Rows of a block of time, of which there should be many.
const BLOCK_ROWS: [usize; 2] = [16, 256];
/// Blocks that a log should have.
const BLOCKS: usize = 100;
/// Draws of the parameters that the errors of the equations are estimated from.
const DRAWS: usize = 40;
/// Size of these draws in standard deviations: small, so that all is linear.
const DRAW_SIZE: f64 = 1e-3;
/// Terms whose coefficient is below so many standard errors cannot be told from zero.
const LEAST_T: f64 = 2.0;

/// First bytes of the file of a request.
const REQUEST: [u8; 8] = *b"twreques";

/// What a pass over the logs is asked for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Request {
    joints: Vec<String>,
    passes: Passes,
    pub(crate) sizes: Sizes,
    choices: Vec<Choice>,
    overlooked: Overlooked,
    warning: Option<UntriedTerm>,
}

/// What a pass came to.
#[derive(Debug)]
pub(crate) enum Round {
    /// Another pass is wanted.
    Again(Box<Request>),
    /// Nothing moves any more.
    Done(Box<Fitted>),
}

/// A chain that was fitted to every row.
#[derive(Debug)]
pub(crate) struct Fitted {
    request: Request,
    solved: Solved,
    residual_rms: Vec<f64>,
}

impl Request {
    /// Searches a chain on the sample of a survey, and refines it there.
    ///
    /// # Errors
    /// [`IdentifyError::Chain`] if no chain can be fitted, [`IdentifyError::NoSuchJoint`].
    pub(crate) fn first(
        survey: &Survey,
        options: &ChainOptions,
        filtered: bool,
        seed: u64,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<Self, IdentifyError> {
        progress(Progress::Geometry);
        let mut learned = learn(&survey.sample, options, seed)?;
        progress(Progress::Overlooked);
        let Tried { certificate, warning, .. } = complete(&mut learned, survey, options.friction)?;
        progress(Progress::Refit);
        let sizes = Sizes { torque: survey.torque_std.clone(), speed: survey.dq_peak.clone() };
        let sample = thinned(&survey.sample, LAST_ROWS);
        let start = linearised(&learned, &sample, survey, options, (filtered, seed))?;
        let at = cut_for(refine(&sample, &start, &sizes)?, survey.rows);
        let passes = Passes::over_all(at, MOST_PASSES);
        let choices = learned.choices;
        let joints = survey.joints.clone();
        Ok(Self { joints, passes, sizes, choices, overlooked: certificate, warning })
    }

    /// What tells it from others: the pass it is for, and a checksum.
    pub fn name(&self) -> String {
        let bytes = postcard::to_stdvec(self).unwrap_or_default();
        format!("pass {} ({:08x})", self.pass(), crc32fast::hash(&bytes))
    }

    /// The pass over the logs that is asked for, counted from 1.
    pub fn pass(&self) -> usize {
        self.passes.made + 1
    }

    /// Fails unless it is for an arm of these joints.
    ///
    /// # Errors
    /// [`IdentifyError::Apart`]
    pub(crate) fn check_joints(&self, joints: &[String]) -> Result<(), IdentifyError> {
        if joints == self.joints {
            return Ok(());
        }
        let (expected, found) = (self.joints.join(", "), joints.join(", "));
        Err(IdentifyError::Apart { what: "joints", expected, found })
    }

    /// The request as the bytes of a file.
    ///
    /// # Errors
    /// [`IdentifyError::Moments`] if it cannot be written.
    pub fn to_bytes(&self) -> Result<Vec<u8>, IdentifyError> {
        crate::framed::framed(REQUEST, self)
    }

    /// The request that [`Self::to_bytes`] wrote.
    ///
    /// # Errors
    /// [`IdentifyError::Moments`] if the bytes are no request or were damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, IdentifyError> {
        let request: Self = crate::framed::unframed(REQUEST, bytes)?;
        if request.passes.at.is_sound(request.joints.len()) {
            return Ok(request);
        }
        Err(IdentifyError::Moments("its parts do not fit each other".into()))
    }

    /// Where the rows of the next pass are linearised.
    pub fn linearisation(&self) -> &Linearisation {
        &self.passes.at
    }

    /// Takes the step that a pass asks for; where that is next to nothing, all is done.
    ///
    /// # Errors
    /// [`IdentifyError::Chain`] if its sums cannot be solved.
    pub(crate) fn take(self, sums: &NormalSums) -> Result<Round, IdentifyError> {
        Ok(match self.passes.clone().take(sums, &self.sizes)? {
            Next::Pass(passes) => Round::Again(Box::new(Self { passes, ..self })),
            Next::Settled(solved) => {
                let residual_rms = sums.residual_rms();
                Round::Done(Box::new(Fitted { request: self, solved, residual_rms }))
            }
        })
    }
}

/// Blocks and folds for a log of so many rows.
fn cut_for(at: Linearisation, rows: usize) -> Linearisation {
    let [least, most] = BLOCK_ROWS;
    let block_rows = (rows / BLOCKS).next_power_of_two().clamp(least, most);
    let fold_rows = rows.div_ceil(FOLDS).div_ceil(block_rows).max(1) * block_rows;
    Linearisation { block_rows, fold_rows, ..at }
}

/// The chain as it was learned, ready for a pass over a sample.
fn linearised(
    learned: &Learned,
    sample: &torquewise_motion::Motion,
    survey: &Survey,
    options: &ChainOptions,
    (filtered, seed): (bool, u64),
) -> Result<Linearisation, IdentifyError> {
    let Learned { chain, recipe, laws, .. } = learned;
    let rest = if recipe.rubs() { AT_REST } else { 0.0 };
    let structure = Structure {
        drive: recipe.beside.clone(),
        free: recipe.free.clone(),
        physical: options.physical,
        pull: recipe.search.pull,
        rest: laws.width.iter().map(|width| rest * width).collect(),
    };
    let weights = chain
        .residual_rms
        .iter()
        .zip(&survey.torque_std)
        .map(|(rms, torque)| 1.0 / rms.max(1e-4 * if *torque > 0.0 { *torque } else { 1.0 }));
    // The noise of filtered rows is not white: it is drawn before the filter.
    let white = if options.noise_correction && !filtered {
        survey.noise.clone()
    } else {
        NoiseFloor::none(survey.joints.len())
    };
    let at = Linearisation {
        geometry: chain.geometry.parameters().to_vec(),
        linear: chain.inertial.iter().chain(&chain.beside).copied().collect(),
        weights: weights.collect(),
        scales: Vec::new(),
        structure,
        noise: white,
        raw_noise: options.noise_correction && filtered,
        block_rows: BLOCK_ROWS[0],
        fold_rows: 1,
        seed,
    };
    Ok(cut_for(at.scaled_by(sample)?, sample.n_rows()))
}

/// Takes in, one by one, terms of the energy library that explain what no chain does, until no
/// other seems to, or too many were refused.
fn complete(
    learned: &mut Learned,
    survey: &Survey,
    friction: FrictionKind,
) -> Result<Tried, IdentifyError> {
    let mut refused = Vec::new();
    let mut tried = overlooked(learned, survey, friction, &refused)?;
    for _ in 0..MOST_FURTHER {
        let Some(term) = tried.missing.take() else { break };
        if !learned.offer(&term, &survey.sample)? {
            refused.push(term);
        }
        tried = overlooked(learned, survey, friction, &refused)?;
        if refused.len() == MOST_REFUSED {
            break;
        }
    }
    Ok(tried)
}

impl Fitted {
    /// The model of the chain: its parameters, and the equations that follow from them.
    ///
    /// # Errors
    /// [`IdentifyError::Model`] if its energy cannot be listed.
    pub(crate) fn report(
        self,
        survey: Survey,
        patterns: Patterns,
        seed: u64,
    ) -> Result<Reconstruction, IdentifyError> {
        let Self { request, solved, residual_rms } = self;
        let (chain, friction) = parameters(&solved.at, &solved.covariance);
        let (terms, candidates) = equations(&chain, &friction, &survey, &residual_rms, seed)?;
        let mut choices = request.choices;
        choices.extend(solved.choice.filter(|choice| choice.what == STRENGTH));
        let mut warnings = Warning::of_survey(&survey);
        warnings.extend(request.warning.map(Warning::Overlooked));
        let mut training = survey.training(residual_rms);
        training.overlooked = Some(request.overlooked);
        training.price_of_physics = Some(solved.price);
        let model = Model {
            joints: survey.joints.clone(),
            form: Form::Energy(terms),
            chain: Some(chain),
            friction,
            stages: Vec::new(),
            training,
            choices,
        };
        let step = StepReport {
            name: "all rows",
            rows: survey.rows,
            candidates,
            active: model.active(),
            route: Route::Direct,
        };
        let (steps, dropped, noise) = (vec![step], Vec::new(), survey.noise.clone());
        Ok(Reconstruction { model, survey, patterns, noise, candidates, steps, dropped, warnings })
    }
}

/// The parameters of a linearisation as a model has them, with their covariance.
fn parameters(
    at: &Linearisation,
    covariance: &Mat<f64>,
) -> (RigidChain, Vec<Weighted<FrictionTerm>>) {
    let bodies = PER_BODY * at.n_joints();
    let links = at.linear[..bodies].chunks_exact(PER_BODY);
    let links = links.map(|p| std::array::from_fn(|k| p[k])).collect();
    let (mut drives, mut friction) = (Vec::new(), Vec::new());
    let (mut drive_at, mut friction_at) = (Vec::new(), Vec::new());
    for (k, term) in at.structure.drive.iter().enumerate() {
        let (index, coefficient) = (bodies + k, at.linear[bodies + k]);
        match term {
            Beside::Friction(term) => {
                friction_at.push(index);
                friction.push(Weighted {
                    term: term.clone(),
                    coefficient,
                    std_error: covariance[(index, index)].max(0.0).sqrt(),
                    inclusion: None,
                });
            }
            Beside::Rotor(shaft) => {
                drive_at.push(index);
                drives.push(Drive::Rotor { shaft: shaft.clone(), inertia: coefficient });
            }
            Beside::Energy(term) => {
                drive_at.push(index);
                drives.push(Drive::Energy { term: term.clone(), coefficient });
            }
        }
    }
    let order: Vec<usize> = (0..bodies)
        .chain(drive_at)
        .chain(friction_at)
        .chain(at.structure.free.iter().map(|&k| at.linear.len() + k))
        .collect();
    let covariance =
        Mat::from_fn(order.len(), order.len(), |i, j| covariance[(order[i], order[j])]);
    let (geometry, fitted) = (at.geometry.clone(), at.structure.free.clone());
    let mut chain = RigidChain { geometry, fitted, links, drives, covariance: Vec::new() };
    chain.set_covariance(&covariance);
    (chain, friction)
}

/// Equal energy terms joined.
fn energies(chain: &RigidChain) -> Result<Energies, IdentifyError> {
    let mut all = Energies::new();
    for (term, coefficient) in chain.energy_terms()? {
        *all.entry(term).or_insert(0.0) += coefficient;
    }
    Ok(all)
}

/// The energy terms of a chain that can be told from zero and that its torque needs, with their
/// standard errors; and how many there were.
fn equations(
    chain: &RigidChain,
    friction: &[Weighted<FrictionTerm>],
    survey: &Survey,
    residual_rms: &[f64],
    seed: u64,
) -> Result<(Vec<Weighted<EnergyTerm>>, usize), IdentifyError> {
    let all = energies(chain)?;
    let candidates = all.len() + friction.len();
    let few = |all: Energies| prune(all.into_iter().collect(), &survey.sample, residual_rms, seed);
    let (products, sums) = (few(all.clone()), few(joint_sums(&all)));
    // Parallel axes make sums shorter, others products.
    let as_sums = sums.len() < products.len();
    let kept = if as_sums { sums } else { products };
    let in_basis = |all: Energies| if as_sums { joint_sums(&all) } else { all };
    let draws = draws(chain, friction, seed)?;
    let draws = draws.into_par_iter().map(|chain| Ok(in_basis(energies(&chain)?)));
    let draws = draws.collect::<Result<Vec<Energies>, IdentifyError>>()?;
    let terms = kept.into_iter().map(|(term, coefficient)| {
        let change =
            |draw: &Energies| (draw.get(&term).copied().unwrap_or(0.0) - coefficient) / DRAW_SIZE;
        let square: f64 = draws.iter().map(|draw| change(draw).powi(2)).sum();
        let std_error = (square / draws.len().max(1) as f64).sqrt();
        Weighted { term, coefficient, std_error, inclusion: None }
    });
    let certain = |w: &Weighted<EnergyTerm>| w.coefficient.abs() >= LEAST_T * w.std_error;
    Ok((terms.filter(certain).collect(), candidates))
}

/// Chains whose parameters scatter as the covariance says, but less.
fn draws(
    chain: &RigidChain,
    friction: &[Weighted<FrictionTerm>],
    seed: u64,
) -> Result<Vec<RigidChain>, IdentifyError> {
    let covariance = chain.covariance_matrix();
    let p = covariance.nrows();
    let eigen = covariance
        .self_adjoint_eigen(faer::Side::Lower)
        .map_err(|_| torquewise_regression::SparseError::NotSolvable)?;
    let deviations: Vec<f64> =
        eigen.S().column_vector().iter().map(|value| value.max(0.0).sqrt()).collect();
    let known = chain.parameters(friction);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut draw = || {
        let units: Vec<f64> = (0..p)
            .map(|k| {
                let unit: f64 = StandardNormal.sample(&mut random);
                DRAW_SIZE * deviations[k] * unit
            })
            .collect();
        let moved = eigen.U() * ColRef::from_slice(&units);
        let parameters: Vec<f64> = known.iter().zip(moved.iter()).map(|(x, d)| x + d).collect();
        chain.at(&parameters, friction.len())
    };
    Ok((0..DRAWS).map(|_| draw()).collect())
}
