//! Search of the geometry: many starts, with axes at right angles or anywhere, the best of them refined.

use crate::geometry::{GRAVITY, PER_JOINT, RIGHT_ANGLES};
use crate::levenberg_marquardt::Target;
use crate::{
    ChainError, ChainRows, Coupling, Geometry, InertialFit, JointKinds, PER_BASE, PER_BODY, Result,
    UsualArm, expect,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::ops::ControlFlow;

pub use turned::turned;

mod turned;

/// How a chain is looked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Search {
    /// Starts at most: arms whose axes lie at right angles at random. Fewer are made where several
    /// of them lead to the same arm.
    pub starts: usize,
    /// Whether the axes of the starts lie anywhere instead; gravity too in every second start.
    pub is_oblique: bool,
    /// Rounds of refinement of a start.
    pub rounds: usize,
    /// Rounds of weighing joints by their residual and refining again, at least 1.
    pub weighings: usize,
    /// Ridge of the linear parameters (inertial, drive), relative to the mean square of a column.
    pub ridge: f64,
    /// Seed of the starts.
    pub seed: u64,
    /// How logged coordinates turn the joints of the starts.
    pub coupling: Coupling,
    /// Which of the joints of the starts turn and which slide.
    pub kinds: JointKinds,
}

impl Default for Search {
    fn default() -> Self {
        let (coupling, kinds) = (Coupling::default(), JointKinds::default());
        let (starts, is_oblique, rounds) = (48, false, 25);
        Self { starts, is_oblique, rounds, weighings: 3, ridge: 1e-4, seed: 0, coupling, kinds }
    }
}

/// A chain of rigid bodies with what was fitted beside it.
#[derive(Clone, Debug)]
pub struct Chain {
    /// Where its axes lie.
    pub geometry: Geometry,
    /// Inertial parameters of each body, 10 each: m, m·c, then moments about the origin of its
    /// frame xx, yy, zz, xy, xz, yz. Torque determines base parameters only; the ridge picks the
    /// smallest of the rest, so that a mass of its own may even be negative.
    pub inertial: Vec<f64>,
    /// Coefficients of the drive columns, e; units of each column (kg·m², N·m, N·m·s/rad).
    pub drive: Vec<f64>,
    /// RMS of the residual of each joint \[N·m\], n, on the rows it was refined on.
    pub residual_rms: Vec<f64>,
    /// Mean square of the weighted residual, with ridge and geometry prior; infinite before a fit.
    pub cost: f64,
}

impl Chain {
    /// A chain of which the geometry alone is known.
    pub fn at(geometry: Geometry) -> Self {
        let inertial = vec![0.0; PER_BODY * geometry.n_joints()];
        let (drive, residual_rms) = (Vec::new(), Vec::new());
        Self { geometry, inertial, drive, residual_rms, cost: f64::INFINITY }
    }

    /// Mass of a link and all beyond it \[kg\], as far as torque determines it.
    pub fn mass_beyond(&self, joint: usize) -> f64 {
        self.inertial.chunks(PER_BODY).skip(joint).map(|body| body[0]).sum()
    }

    /// The same arm, or its mirror image, which needs the same torques: that whose first axis points up,
    /// where joints turn and one of the two does.
    #[must_use]
    pub fn upright(mut self) -> Self {
        if !self.geometry.kinds().all_turn() || self.geometry.gravity()[2] < 0.5 * GRAVITY {
            return self;
        }
        self.geometry = self.geometry.mirrored();
        for body in self.inertial.chunks_mut(PER_BODY) {
            // m·z, and the products of inertia with z.
            for k in [3, 8, 9] {
                body[k] = 0.0 - body[k];
            }
        }
        self
    }

    pub(crate) fn new(fitted: &InertialFit, rows: &ChainRows, weights: &[f64]) -> Self {
        let of_bodies = PER_BODY * fitted.geometry.n_joints();
        let (inertial, drive) = fitted.coefficients.split_at(of_bodies);
        let (inertial, drive) = (inertial.to_vec(), drive.to_vec());
        let variances = fitted.variances(rows, weights);
        let residual_rms = variances.into_iter().map(f64::sqrt).collect();
        let geometry = fitted.geometry.clone();
        Self { geometry, inertial, drive, residual_rms, cost: fitted.cost }
    }

    /// Torques \[N·m\] of rows: m of joint 1, then m of joint 2 …
    pub fn torque(&self, rows: &ChainRows) -> Vec<f64> {
        let (m, n) = (rows.len(), rows.n_joints());
        let mut out = vec![0.0; m * n];
        let put = |row, joint, tau| out[joint * m + row] = tau;
        rows.kinematics(&self.geometry).torques(rows.signals(), &self.inertial, put);
        for (j, coefficient) in self.drive.iter().enumerate() {
            for (out, x) in out.iter_mut().zip(rows.extras.col_as_slice(j)) {
                *out += coefficient * x;
            }
        }
        out
    }
}

/// How many of the best starts are refined on [`FINAL_ROWS`] rows.
const FINALISTS: usize = 4;
/// Rows of the first look at a start, and of its refinement.
const GLANCE_ROWS: usize = 120;
const START_ROWS: usize = 400;
/// Rows on which a finalist is refined.
pub const FINAL_ROWS: usize = 1_200;
/// How strongly the geometry is held to that of usual arms: the mean square, in units of the noise,
/// that one spread of theirs counts.
const PRIOR: f64 = 7.5e-3;
/// Largest first guess of the place of an axis \[m\].
const PLACE: f64 = 0.2;
/// Sweeps through the joints of a start.
const SWEEPS: usize = 4;
/// Weighings of the joints of a start.
const START_WEIGHINGS: usize = 2;
/// Least RMS of a residual, in parts of the noise first guessed: weights stay finite.
const LEAST_RESIDUAL: f64 = 1e-6;

/// Part of the torque that is taken for noise before anything is fitted.
const FIRST_NOISE: f64 = 0.1;

/// One over the noise guessed of each joint, n.
fn first_weights(rows: &ChainRows) -> Vec<f64> {
    let weight = |joint| {
        let deviation = rows.deviation_of(joint);
        1.0 / (FIRST_NOISE * if deviation > 0.0 { deviation } else { 1.0 })
    };
    (0..rows.n_joints()).map(weight).collect()
}

/// Parameters that rows may move: the tilt of gravity and all axes.
pub fn all_parameters(n_joints: usize) -> Vec<usize> {
    (0..PER_BASE + PER_JOINT * n_joints.saturating_sub(1)).collect()
}

/// Starts that are made before it is looked whether they agree.
const BATCH: usize = 6;
/// Starts that must lead to the best arm before no more are made: where fewer do, the arm may be
/// another.
pub const AGREEING: usize = 3;
/// Two arms whose residuals differ by less than this part, geometric mean of the joints, are one.
const SAME: f64 = 0.02;
/// A residual below this part of the torque is nothing, when arms are compared.
const NOTHING: f64 = 1e-3;

/// How far a search or a refinement is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SearchStage {
    /// Work goes on: a round of refinement, or the trial of an axis, begins.
    Round,
    /// Starts were made.
    Starts {
        /// So many.
        made: usize,
        /// So many of them led to the best arm.
        agreeing: usize,
    },
}

/// Is told how far a search is, from several threads, and stops it by breaking.
pub type SearchWatch<'a> = &'a (dyn Fn(SearchStage) -> ControlFlow<()> + Sync + 'a);

/// Nobody watches.
pub const UNWATCHED: SearchWatch<'static> = &|_| ControlFlow::Continue(());

/// Fails where the work is not wanted any more.
pub(crate) fn tell(watch: SearchWatch<'_>, stage: SearchStage) -> Result<()> {
    if watch(stage).is_continue() { Ok(()) } else { Err(ChainError::Stopped) }
}

/// What a search came to.
#[derive(Clone, Debug)]
pub struct Found {
    /// Chains refined on at most [`FINAL_ROWS`] rows, the best first.
    pub chains: Vec<Chain>,
    /// Starts within 2 % of the lowest residual, the best among them, on their rows or once refined.
    pub times: usize,
    /// Starts that were made.
    pub starts: usize,
}

/// Learns chains from rows: random starts until three come within 2 % of the lowest residual, whatever
/// their geometry, or all are made; the best four are refined. The same seed gives the same chains at
/// any number of threads.
///
/// # Errors
/// [`ChainError::TooFewRows`], [`ChainError::Singular`] if no start can be fitted, or
/// [`ChainError::Stopped`].
pub fn search(rows: &ChainRows, search: &Search, watch: SearchWatch<'_>) -> Result<Found> {
    let n = rows.n_joints();
    let needed = PER_BODY * n;
    if rows.len() < needed {
        return Err(ChainError::TooFewRows { rows: rows.len(), joints: n, needed });
    }
    let weights = first_weights(rows);
    let (glance, start) = (rows.thinned(GLANCE_ROWS), rows.thinned(START_ROWS));
    let free = Geometry::straight(n).of_kinds(search.kinds.clone()).movable();
    let made = |place: usize| {
        let fitted = first_fit(&glance, &weights, (search, place), watch)?;
        // A joint whose torque is mostly noise must not dominate the others.
        let first = Chain::new(&fitted, &glance, &weights);
        let weighed = Search { weighings: START_WEIGHINGS, ..search.clone() };
        Some((place, refine(&start, &first, &free, &weighed, watch).ok()?))
    };
    let rank = |chain: &Chain| score(chain, &start, LEAST_RESIDUAL);
    let mut found: Vec<(usize, Chain)> = Vec::new();
    let (mut starts, mut times, within) = (0, 0, SAME * n as f64);
    while starts < search.starts && times < AGREEING {
        let batch = starts..(starts + BATCH).min(search.starts);
        starts = batch.end;
        found.extend(batch.into_par_iter().filter_map(made).collect::<Vec<_>>());
        found.sort_by(|a, b| rank(&a.1).total_cmp(&rank(&b.1)).then(a.0.cmp(&b.0)));
        let scores: Vec<f64> =
            found.iter().map(|own| score(&own.1, &start, NOTHING / FIRST_NOISE)).collect();
        times = scores.iter().filter(|own| (*own - scores[0]).abs() < within).count();
        tell(watch, SearchStage::Starts { made: starts, agreeing: times })?;
    }
    found.truncate(FINALISTS);
    let finals = rows.thinned(FINAL_ROWS);
    let refined = |(_, chain): (_, Chain)| refine(&finals, &chain, &free, search, watch).ok();
    let mut chains: Vec<Chain> = found.into_par_iter().filter_map(refined).collect();
    tell(watch, SearchStage::Round)?;
    let rank = |chain: &Chain| score(chain, &finals, LEAST_RESIDUAL);
    chains.sort_by(|a, b| rank(a).total_cmp(&rank(b)));
    // Some that seemed apart were not refined to the end.
    let coarse = |chain: &Chain| score(chain, &finals, NOTHING / FIRST_NOISE);
    let agree = |own: &&Chain| (coarse(own) - coarse(&chains[0])).abs() < within;
    let times = times.max(chains.iter().filter(agree).count());
    if chains.is_empty() { Err(ChainError::Singular) } else { Ok(Found { chains, times, starts }) }
}

/// What the best of the starts leaves of few rows, before any is refined: a first look at a
/// coupling, or at torques in another order. Residual RMS over standard deviation of the torque of each
/// joint, n; infinite where no start can be fitted, or the work is stopped.
pub fn glance(rows: &ChainRows, search: &Search, watch: SearchWatch<'_>) -> Vec<f64> {
    let weights = first_weights(rows);
    let left = (0..search.starts).into_par_iter().filter_map(|place| {
        let chain = Chain::new(&first_fit(rows, &weights, (search, place), watch)?, rows, &weights);
        Some((score(&chain, rows, LEAST_RESIDUAL), chain.residual_rms))
    });
    let best = left.min_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, rms)) = best else { return vec![f64::INFINITY; rows.n_joints()] };
    let part = |(rms, weight): (f64, &f64)| FIRST_NOISE * (rms * weight).max(LEAST_RESIDUAL);
    rms.into_iter().zip(&weights).map(part).collect()
}

/// Sum over joints of ln(residual RMS / noise first guessed), each ratio at least `least`: compares
/// chains of different weights.
fn score(chain: &Chain, rows: &ChainRows, least: f64) -> f64 {
    let parts = chain.residual_rms.iter().zip(first_weights(rows));
    parts.map(|(rms, weight)| (rms * weight).max(least).ln()).sum()
}

/// Refines the free parameters of a geometry, joints weighed by what is left of them; without rounds
/// only the linear parameters are fitted.
///
/// The residuals of `start` are the first weights, where it has any; `free` are the parameters that
/// may move.
///
/// # Errors
/// [`ChainError::Shape`] if the start is of another arm or has no such parameter,
/// [`ChainError::Singular`], [`ChainError::Stopped`].
pub fn refine(
    rows: &ChainRows,
    start: &Chain,
    free: &[usize],
    search: &Search,
    watch: SearchWatch<'_>,
) -> Result<Chain> {
    let expected = all_parameters(rows.n_joints()).len();
    expect("geometry", start.geometry.parameters().len(), expected)?;
    if let Some(&found) = free.iter().find(|&&parameter| parameter >= expected) {
        return Err(ChainError::Shape { what: "free", found, expected });
    }
    let first = first_weights(rows);
    let mut weights: Vec<f64> = weights_of(&start.residual_rms, &first);
    let mut geometry = start.geometry.clone();
    let mut chain = None;
    for _ in 0..search.weighings {
        let (usual, strength) = (UsualArm::near(&geometry), PRIOR);
        let target = Target { rows, weights: &weights, ridge: search.ridge, usual, strength };
        let fitted = target.descend(&geometry, free, search.rounds, watch)?;
        let found = Chain::new(&fitted, rows, &weights);
        weights = weights_of(&found.residual_rms, &first);
        geometry = found.geometry.clone();
        chain = Some(found);
    }
    chain.ok_or(ChainError::Singular)
}

/// One over the noise of each joint; the first guess where there is no residual.
fn weights_of(residual_rms: &[f64], first: &[f64]) -> Vec<f64> {
    let weight = |(joint, first): (usize, &f64)| {
        residual_rms.get(joint).map_or(*first, |rms| 1.0 / rms.max(LEAST_RESIDUAL / first))
    };
    first.iter().enumerate().map(weight).collect()
}

/// A direction, all alike, as the rotation vector that turns z to it.
fn anywhere(random: &mut ChaCha8Rng) -> [f64; 2] {
    let angle = random.random_range(-1.0_f64..1.0).acos();
    let (sin, cos) = random.random_range(0.0..TAU).sin_cos();
    [angle * cos, angle * sin]
}

/// A start, by its number: random right angles and places, then each axis in turn takes the right angle
/// that leaves least, until none changes; or random directions, of gravity in every second start.
fn first_fit(
    rows: &ChainRows,
    weights: &[f64],
    (search, place): (&Search, usize),
    watch: SearchWatch<'_>,
) -> Option<InertialFit> {
    let n = rows.n_joints();
    let mut random = ChaCha8Rng::seed_from_u64(search.seed);
    random.set_stream(place as u64);
    let mut geometry =
        Geometry::straight(n).coupled(search.coupling.clone()).of_kinds(search.kinds.clone());
    let (usual, strength) = (UsualArm::near(&geometry), 0.0);
    let target = Target { rows, weights, ridge: search.ridge, usual, strength };
    for joint in usize::from(!search.is_oblique || place % 2 == 1)..n {
        let mut right = || RIGHT_ANGLES[random.random_range(0..RIGHT_ANGLES.len())];
        let turn = if search.is_oblique { anywhere(&mut random) } else { right() };
        geometry.set_turn(joint, turn);
        let place = [random.random_range(-PLACE..PLACE), random.random_range(-PLACE..PLACE)];
        if geometry.has_place(joint) {
            geometry.set_place(joint, place);
        }
    }
    let mut best = target.fit(&geometry).ok()?;
    if search.is_oblique {
        return Some(best);
    }
    let mut least = logarithm(&best, &target);
    // How many axes had changed when an axis was tried last: none has since, its turn is over.
    let (mut changes, mut tried_at) = (0, vec![None; n]);
    for _ in 0..SWEEPS {
        let mut order: Vec<usize> = (0..n).collect();
        for k in (1..order.len()).rev() {
            order.swap(k, random.random_range(0..=k));
        }
        for joint in order {
            if tried_at[joint] == Some(changes) {
                continue;
            }
            tell(watch, SearchStage::Round).ok()?;
            for direction in RIGHT_ANGLES {
                let mut other = best.geometry.clone();
                other.set_turn(joint, direction);
                if other != best.geometry
                    && let Ok(found) = target.fit(&other)
                    && logarithm(&found, &target) < least
                {
                    (least, best) = (logarithm(&found, &target), found);
                    changes += 1;
                }
            }
            tried_at[joint] = Some(changes);
        }
        if tried_at.iter().all(|at| *at == Some(changes)) {
            break;
        }
    }
    Some(best)
}

/// Sum over joints of the logarithm of the mean square residual.
fn logarithm(fitted: &InertialFit, target: &Target<'_>) -> f64 {
    let variances = fitted.variances(target.rows, target.weights);
    let relative = variances.iter().zip(target.weights).map(|(v, w)| v * w * w);
    relative.map(|part| part.max(LEAST_RESIDUAL * LEAST_RESIDUAL).ln()).sum()
}
