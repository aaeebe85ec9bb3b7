//! Normal equations → the next parameters, what is certain of them, and what physics cost (E11)
//! (E14).

use super::linearisation::Linearisation;
use super::nominal::{Sizes, plain_arm, prior};
use super::pass::add_up;
use crate::error::IdentifyError;
use crate::held_out::{Trial, choose};
use faer::{ColRef, Mat};
use rayon::prelude::*;
use torquewise_model::model::Choice;
use torquewise_motion::Recording;
use torquewise_rigid::Geometry;
use torquewise_rigid::feasible::{Prior, Quadratic, curvature, minimise};
use torquewise_rigid::search::{pull_stiffness, right_angles_near};
use torquewise_sparse::normal_sums::{FOLDS, NormalSums, corrected};

/// Strengths of the prior that are tried, the strongest first.
const STRENGTHS: [f64; 9] = [1e4, 1e3, 1e2, 1e1, 1.0, 1e-1, 1e-2, 1e-3, 1e-4];
/// The strength where a log is too short to choose one.
const USUAL_STRENGTH: f64 = 1.0;
/// Fewer folds with rows are too few to choose by.
const LEAST_FOLDS: usize = 3;
/// Equations that the pull on the geometry counts as at most: it must not grow with the log.
const MOST_PULLED: f64 = 20_000.0;
/// Longest step of a parameter of the geometry: rad or m.
const LONGEST: f64 = 0.2;
/// A residual below this part of the torque is taken for it: weights stay finite.
const LEAST_RESIDUAL: f64 = 1e-7;
/// Ridge of the unconstrained optimum, relative to the curvature.
const RIDGE: f64 = 1e-9;
/// Parameters that move less than this part of their standard error are settled.
const SETTLED: f64 = 0.05;

/// What a pass over the rows came to.
#[derive(Clone, Debug)]
pub(crate) struct Solved {
    /// The new parameters, and weights by what was left of the torque before.
    pub(crate) at: Linearisation,
    /// Covariance of all parameters, p×p.
    pub(crate) covariance: Mat<f64>,
    /// How the strength of the prior was chosen.
    pub(crate) choice: Option<Choice>,
    /// By what part physics makes the residual larger (RMS) than it is at the optimum without.
    pub(crate) price: f64,
    /// The optimum without physics, p.
    pub(crate) unconstrained: Vec<f64>,
    /// Largest move of a parameter in its standard errors.
    pub(crate) moved: f64,
}

/// Passes over a recording from a linearisation until the parameters settle, `most` at most.
pub(crate) fn refine(
    recording: &(impl Recording + ?Sized),
    start: Linearisation,
    sizes: &Sizes,
    most: usize,
) -> Result<Solved, IdentifyError> {
    let mut solved = solve(&add_up(recording, &start)?, &start, sizes)?;
    for _ in 1..most {
        if solved.moved < SETTLED {
            break;
        }
        let at = solved.at.clone();
        solved = solve(&add_up(recording, &at)?, &at, sizes)?;
    }
    Ok(solved)
}

/// The normal equations in the units of the parameters.
struct Equations {
    hessian: Mat<f64>,
    right: Vec<f64>,
}

/// One step from a linearisation, by the sums that were made there.
///
/// # Errors
/// [`IdentifyError::Chain`] if the equations cannot be solved.
pub(crate) fn solve(
    sums: &NormalSums,
    at: &Linearisation,
    sizes: &Sizes,
) -> Result<Solved, IdentifyError> {
    let n = at.n_joints();
    let gram = sums.gram();
    let bias = sums.bias();
    let sizes = Sizes { mass: mass_of(&gram, at)?, ..sizes.clone() };
    let (prior, start) = prior(at, &sizes)?;
    let equations = (sums.rows() as f64 * n as f64).min(MOST_PULLED);
    let of = |gram: &Mat<f64>, bias: &Mat<f64>| Equations::new(gram, bias, at, equations);
    let all = of(&gram, &bias)?;
    let path = path(&all, &prior, &start, &STRENGTHS)?;
    let (place, choice) = choose_strength(sums, at, &prior, &path, equations)?;
    let parameters = bounded(at, &path[place]);
    let strength = STRENGTHS[place];

    let unconstrained = all.unconstrained()?;
    let before = at.parameters();
    let cost = |x: &[f64]| squares(&gram, at, &before, x).max(0.0);
    let (feasible, free) = (cost(&path[place]), cost(&unconstrained));
    let price = if free > 0.0 { (feasible / free).sqrt() - 1.0 } else { 0.0 };

    let covariance = covariance(sums, at, &all, &prior, strength, &path[place])?;
    let moved = (0..parameters.len())
        .map(|k| {
            let error = covariance[(k, k)].max(0.0).sqrt();
            let change = (parameters[k] - before[k]).abs();
            if change == 0.0 { 0.0 } else { change / error.max(f64::MIN_POSITIVE) }
        })
        .fold(0.0, f64::max);
    let mut next = at.at(&parameters);
    next.weights = weights(sums, &sizes);
    Ok(Solved { at: next, covariance, choice, price, unconstrained, moved })
}

/// One over the residual of each joint \[1/(N·m)\], n.
fn weights(sums: &NormalSums, sizes: &Sizes) -> Vec<f64> {
    let residuals = sums.weighted_rms().into_iter().zip(&sizes.torque);
    residuals
        .map(|(rms, torque)| {
            1.0 / rms.max(LEAST_RESIDUAL * if *torque > 0.0 { *torque } else { 1.0 })
        })
        .collect()
}

/// Mass of the plain links \[kg\] that take torques as large as those of the log.
fn mass_of(gram: &Mat<f64>, at: &Linearisation) -> Result<f64, IdentifyError> {
    let plain = plain_arm(&at.geometry, 1.0)?;
    let p = at.n_parameters();
    let scaled = |x: &[f64]| -> Vec<f64> {
        (0..=p)
            .map(|k| match x.get(k) {
                Some(x) if k < p => x / at.scales[k],
                _ => 0.0,
            })
            .collect()
    };
    let energy = |x: &[f64]| {
        let product = gram * ColRef::from_slice(x);
        x.iter().zip(product.iter()).map(|(x, y)| x * y).sum::<f64>()
    };
    // The torque is what the linear parameters explain and the residual.
    let mut torque = scaled(&at.linear);
    torque[p] = 1.0;
    let (torque, plain) = (energy(&torque), energy(&scaled(&plain)));
    let mass = if plain > 0.0 { (torque / plain).sqrt() } else { 1.0 };
    Ok(mass.clamp(1e-4, 1e4))
}

impl Equations {
    fn new(
        gram: &Mat<f64>,
        bias: &Mat<f64>,
        at: &Linearisation,
        equations: f64,
    ) -> Result<Self, IdentifyError> {
        let p = at.n_parameters();
        let part = |x: &Mat<f64>| x.submatrix(0, 0, p, p).to_owned();
        let corrected = corrected(&part(gram), &part(bias))?;
        let before = at.parameters();
        let mut hessian =
            Mat::from_fn(p, p, |i, j| corrected[(i, j)] / (at.scales[i] * at.scales[j]));
        let known = &hessian * ColRef::from_slice(&before);
        let mut right: Vec<f64> =
            (0..p).map(|j| (gram[(p, j)] - bias[(p, j)]) / at.scales[j] + known[j]).collect();
        let anchor = right_angles_near(&Geometry::new(&at.geometry)?);
        let linear = at.linear.len();
        for (place, &k) in at.structure.free.iter().enumerate() {
            let stiffness = equations * pull_stiffness(at.structure.pull, k);
            hessian[(linear + place, linear + place)] += stiffness;
            right[linear + place] += stiffness * anchor[k];
        }
        Ok(Self { hessian, right })
    }

    fn quadratic(&self) -> Quadratic<'_> {
        Quadratic { hessian: &self.hessian, right: &self.right }
    }

    /// The optimum without physics; what the log does not tell is held by a small ridge.
    fn unconstrained(&self) -> Result<Vec<f64>, IdentifyError> {
        let p = self.right.len();
        let mut ridged = self.hessian.clone();
        let most = (0..p).fold(0.0_f64, |most, j| most.max(ridged[(j, j)]));
        for j in 0..p {
            let own = ridged[(j, j)].max(RIDGE * most).max(f64::MIN_POSITIVE);
            ridged[(j, j)] += RIDGE * own;
        }
        let cost = Quadratic { hessian: &ridged, right: &self.right };
        let factor = curvature(cost, &Prior::default(), 0.0, &vec![0.0; p])?;
        Ok(factor.solve(&self.right))
    }
}

/// The best physical parameters at each strength, each from those before.
fn path(
    equations: &Equations,
    prior: &Prior,
    start: &[f64],
    strengths: &[f64],
) -> Result<Vec<Vec<f64>>, IdentifyError> {
    let mut x = start.to_vec();
    let mut path = Vec::with_capacity(strengths.len());
    for &strength in strengths {
        x = minimise(equations.quadratic(), prior, strength, &x)?;
        path.push(x.clone());
    }
    Ok(path)
}

/// Sum of squares at parameters x in the linearisation around `before`.
fn squares(gram: &Mat<f64>, at: &Linearisation, before: &[f64], x: &[f64]) -> f64 {
    let p = before.len();
    let z: Vec<f64> = (0..=p)
        .map(|k| if k < p { (before[k] - x[k]) / at.scales[k] } else { 1.0 })
        .collect();
    let product = gram * ColRef::from_slice(&z);
    z.iter().zip(product.iter()).map(|(z, y)| z * y).sum()
}

/// Chooses the strength of the prior on held-out folds of time.
fn choose_strength(
    sums: &NormalSums,
    at: &Linearisation,
    prior: &Prior,
    path_of_all: &[Vec<f64>],
    equations: f64,
) -> Result<(usize, Option<Choice>), IdentifyError> {
    let usual = STRENGTHS.iter().position(|&s| s <= USUAL_STRENGTH).unwrap_or(0);
    let folds: Vec<usize> = (0..FOLDS).filter(|&fold| sums.rows_of(fold) > 0).collect();
    if folds.len() < LEAST_FOLDS {
        return Ok((usual, None));
    }
    let (gram, bias, rows) = (sums.gram(), sums.bias(), sums.rows() as f64);
    let before = at.parameters();
    let errors = folds
        .par_iter()
        .map(|&fold| {
            let (held, count) = (sums.gram_of(fold), sums.rows_of(fold) as f64);
            let share = 1.0 - count / rows;
            let rest = Equations::new(
                &(&gram - &held),
                &(faer::Scale(share) * &bias),
                at,
                equations * share,
            )?;
            let mut errors = Vec::with_capacity(STRENGTHS.len());
            for (strength, start) in STRENGTHS.iter().zip(path_of_all) {
                let x = minimise(rest.quadratic(), prior, *strength, start)?;
                let mean = squares(&held, at, &before, &x) / (count * at.n_joints() as f64);
                errors.push(mean.max(0.0).sqrt());
            }
            Ok(errors)
        })
        .collect::<Result<Vec<Vec<f64>>, IdentifyError>>()?;
    let trials: Vec<Trial> = (STRENGTHS.iter().enumerate())
        .map(|(k, strength)| Trial {
            label: format!("{strength:e}"),
            complexity: at.n_parameters(),
            errors: errors.iter().map(|of_fold| of_fold[k]).collect(),
        })
        .collect();
    Ok(match choose(STRENGTH, &trials) {
        Some((place, choice)) => (place, Some(choice)),
        None => (usual, None),
    })
}

/// The choice, as the model file has it.
pub(crate) const STRENGTH: &str = "strength of the physical prior";

/// Parameters to go on with: the geometry takes no step that leaves its linearisation.
fn bounded(at: &Linearisation, parameters: &[f64]) -> Vec<f64> {
    let linear = at.linear.len();
    let before = at.parameters();
    let longest = parameters[linear..]
        .iter()
        .zip(&before[linear..])
        .fold(0.0_f64, |most, (x, b)| most.max((x - b).abs()));
    let share = if longest > LONGEST { LONGEST / longest } else { 1.0 };
    let mut bounded = parameters.to_vec();
    for (x, b) in bounded.iter_mut().zip(&before).skip(linear) {
        *x = b + share * (*x - b);
    }
    bounded
}

/// The sandwich A⁻¹ (Ω + prior) A⁻¹: Ω sums the scores of blocks of time, since neighbours are
/// alike; A is the curvature of the whole cost, and the prior is as uncertain as it is weak.
fn covariance(
    sums: &NormalSums,
    at: &Linearisation,
    equations: &Equations,
    prior: &Prior,
    strength: f64,
    x: &[f64],
) -> Result<Mat<f64>, IdentifyError> {
    let p = at.n_parameters();
    let factor = curvature(equations.quadratic(), prior, strength, x)?;
    let scores = sums.scores();
    let blocks = sums.blocks() as f64;
    // Few blocks scatter less than many would.
    let few = blocks / (blocks - 1.0).max(1.0);
    let mut middle =
        Mat::from_fn(p, p, |i, j| few * scores[(i, j)] / (at.scales[i] * at.scales[j]));
    prior.add_slopes(x, strength, &mut vec![0.0; p], &mut middle);
    let half = factor.solve_matrix(&middle);
    let whole = factor.solve_matrix(&half.transpose().to_owned());
    Ok(Mat::from_fn(p, p, |i, j| 0.5 * (whole[(i, j)] + whole[(j, i)])))
}
