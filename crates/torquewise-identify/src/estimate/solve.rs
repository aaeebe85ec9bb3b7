//! Normal equations → the next parameters, what is certain of them, and what physics cost (E11)
//! (E14).

use super::linearisation::Linearisation;
use super::nominal::{Sizes, plain_arm, prior};
use super::pass::add_up;
use faer::{ColRef, Mat};
use rayon::prelude::*;
use torquewise_model::model::{Choice, PriceOfPhysics};
use torquewise_motion::Recording;
use torquewise_regression::normal_sums::{FOLDS, NormalSums, corrected};
use torquewise_rigid::Geometry;
use torquewise_rigid::feasible::{Prior, Quadratic, curvature, minimise};
use torquewise_rigid::search::{pull_stiffness, right_angles_near};
use torquewise_survey::error::IdentifyError;
use torquewise_survey::held_out::{Trial, choose};

/// The choice of the prior's strength, as the model file has it.
pub(crate) const STRENGTH: &str = "strength of the physical prior";
/// Strengths of the prior that are tried, the strongest first, in units of what one independent
/// row tells. A weaker one would leave to noise what the log does not tell, and no held-out row of
/// the same log would object.
const STRENGTHS: [f64; 7] = [1e4, 3e3, 1e3, 3e2, 1e2, 1e1, 1.0];
/// The strength where a log is too short to choose one, 10.
const USUAL_PLACE: usize = 5;
/// Parts of the pull on the geometry that are tried once the prior is as strong as it should be.
const RELEASED: [f64; 4] = [0.1, 1e-2, 1e-3, 1e-4];
/// Fewer folds with rows are too few to choose by.
const LEAST_FOLDS: usize = 3;
/// Equations that the pull on the geometry counts as at most: it must not grow with the log.
const MOST_PULLED: f64 = 20_000.0;
/// Longest step of a parameter of the geometry: rad or m.
const LONGEST: f64 = 0.2;
/// A residual below this part of the torque is taken for it: weights stay finite.
const LEAST_RESIDUAL: f64 = 1e-7;
/// Blocks of time that a score test needs.
const LEAST_BLOCKS: u64 = 30;
/// A held parameter is released where its squared score is so many times ln m above its variance.
const STRICTNESS: f64 = 3.0;
/// Ridge of the unconstrained optimum, relative to the curvature.
const RIDGE: f64 = 1e-9;
/// Parameters that move less than this part of their standard error are settled.
const SETTLED: f64 = 0.1;
/// So much the sum of squares may fall for each parameter, in squares of the noise. A step along a
/// direction that the log hardly tells may be short and yet far too long for its linearisation.
const LEAST_GAIN: f64 = 0.05;

/// What a pass over the rows came to.
#[derive(Clone, Debug)]
pub(crate) struct Solved {
    /// The new parameters, and weights by what was left of the torque before.
    pub(crate) at: Linearisation,
    /// Covariance of all parameters, p×p.
    pub(crate) covariance: Mat<f64>,
    /// How the strength of the prior was chosen.
    pub(crate) choice: Option<Choice>,
    /// What physics costs, beside the optimum without.
    pub(crate) price: PriceOfPhysics,
    /// Whether another pass would change next to nothing: no parameter moves by a good part of its
    /// standard error, and the sum of squares does not fall.
    pub(crate) settled: bool,
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
        if solved.settled {
            break;
        }
        let at = solved.at.clone();
        solved = solve(&add_up(recording, &at)?, &at, sizes)?;
    }
    Ok(solved)
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
    let step = Step::new(sums, at, sizes)?;
    let (mut active, mut best) = (at.active(), step.best(&at.active())?);
    let released = step.released(&active, &best)?;
    if !released.is_empty() {
        let mut more: Vec<usize> = active.iter().copied().chain(released).collect();
        more.sort_unstable();
        let other = step.best(&more)?;
        let pair = [("held", &best), ("released", &other)].map(|(label, best)| Trial {
            label: label.to_owned(),
            complexity: best.solution.len(),
            errors: best.errors.clone(),
        });
        if !pair[0].errors.is_empty() && choose("geometry", &pair).is_some_and(|(k, _)| k == 1) {
            (active, best) = (more, other);
        }
    }
    step.finish(&active, best)
}

/// The normal equations of a pass, and what physics says of its parameters.
struct Step<'a> {
    sums: &'a NormalSums,
    at: &'a Linearisation,
    sizes: Sizes,
    prior: Prior,
    /// Parameters that the prior allows.
    start: Vec<f64>,
    /// Parameters of the linearisation.
    before: Vec<f64>,
    /// Without the pull on the geometry.
    all: Equations,
    /// Rows that tell as much as one independent one: neighbours err alike.
    repeats: f64,
}

/// The best parameters with some of them free to move.
struct Best {
    strength: f64,
    /// What the pull on the geometry counts as, in equations.
    pull: f64,
    choice: Option<Choice>,
    /// Values of the parameters that may move.
    solution: Vec<f64>,
    /// Errors on held-out folds; empty if there are too few.
    errors: Vec<f64>,
}

/// The normal equations in the units of the parameters.
struct Equations {
    hessian: Mat<f64>,
    right: Vec<f64>,
}

impl<'a> Step<'a> {
    fn new(
        sums: &'a NormalSums,
        at: &'a Linearisation,
        sizes: &Sizes,
    ) -> Result<Self, IdentifyError> {
        let gram = sums.gram();
        let sizes = Sizes { mass: mass_of(&gram, at)?, ..sizes.clone() };
        let (prior, start) = prior(at, &sizes)?;
        let all = Equations::new(&gram, &sums.bias(), at)?;
        let repeats = repeats(sums);
        Ok(Self { sums, at, sizes, prior, start, before: at.parameters(), all, repeats })
    }

    /// Parameters as they were, those that may move as a solution has them.
    fn whole(&self, active: &[usize], solution: &[f64]) -> Vec<f64> {
        let mut whole = self.before.clone();
        active.iter().zip(solution).for_each(|(&k, x)| whole[k] = *x);
        whole
    }

    /// The equations of the parameters that may move, the geometry pulled to right angles.
    fn equations(&self, active: &[usize], pull: f64) -> Equations {
        self.all.of(active, self.at, pull)
    }

    /// Fits the parameters that may move. How strong the prior is, and then how strongly the
    /// geometry is pulled, is chosen on held-out folds.
    fn best(&self, active: &[usize]) -> Result<Best, IdentifyError> {
        let most = self.sums.rows() as f64 * self.at.n_joints() as f64;
        let pull = most.min(MOST_PULLED);
        let equations = self.equations(active, pull);
        let mut path = Vec::with_capacity(STRENGTHS.len());
        let mut x: Vec<f64> = active.iter().map(|&k| self.start[k]).collect();
        for strength in STRENGTHS.map(|strength| strength * self.repeats) {
            x = minimise(equations.quadratic(), &self.prior, strength, &x)?;
            path.push((strength, pull, x.clone()));
        }
        let (place, choice, errors) = self.choose(STRENGTH, active, &path)?;
        let place = choice.as_ref().map_or(USUAL_PLACE, |_| place);
        let (strength, _, x) = path.swap_remove(place);
        let mut best = Best { strength, pull, choice, solution: x.clone(), errors };
        if best.choice.is_none() || active.len() == self.at.linear.len() {
            return Ok(best);
        }
        let mut path = vec![(strength, pull, x.clone())];
        for share in RELEASED {
            let equations = self.equations(active, share * pull);
            let x = minimise(equations.quadratic(), &self.prior, strength, &x)?;
            path.push((strength, share * pull, x));
        }
        // A pull has no error of its own to be preferred for: the best is taken.
        let errors = self.held_out(active, &path)?;
        let mean = |k: usize| errors.iter().map(|of_fold| of_fold[k]).sum::<f64>();
        let place = (0..path.len()).min_by(|&a, &b| mean(a).total_cmp(&mean(b))).unwrap_or(0);
        best.errors = errors.iter().map(|of_fold| of_fold[place]).collect();
        (_, best.pull, best.solution) = path.swap_remove(place);
        Ok(best)
    }

    /// Chooses among fits by the rule of one standard error; also its errors on the folds.
    fn choose(
        &self,
        what: &str,
        active: &[usize],
        path: &[(f64, f64, Vec<f64>)],
    ) -> Result<(usize, Option<Choice>, Vec<f64>), IdentifyError> {
        let errors = self.held_out(active, path)?;
        if errors.is_empty() {
            return Ok((0, None, Vec::new()));
        }
        let trial = |(k, (strength, ..)): (usize, &(f64, f64, Vec<f64>))| Trial {
            label: format!("{:.0}", strength / self.repeats),
            complexity: active.len(),
            errors: errors.iter().map(|of_fold| of_fold[k]).collect(),
        };
        let trials: Vec<Trial> = path.iter().enumerate().map(trial).collect();
        Ok(match choose(what, &trials) {
            Some((place, choice)) => (place, Some(choice), trials[place].errors.clone()),
            None => (0, None, Vec::new()),
        })
    }

    /// Errors on each fold of what the others teach, for each (strength, pull, start); nothing if
    /// folds are few.
    fn held_out(
        &self,
        active: &[usize],
        path: &[(f64, f64, Vec<f64>)],
    ) -> Result<Vec<Vec<f64>>, IdentifyError> {
        let sums = self.sums;
        let folds: Vec<usize> = (0..FOLDS).filter(|&fold| sums.rows_of(fold) > 0).collect();
        if folds.len() < LEAST_FOLDS {
            return Ok(Vec::new());
        }
        let (gram, bias, rows) = (sums.gram(), sums.bias(), sums.rows() as f64);
        let of_fold = |&fold: &usize| {
            let (held, count) = (sums.gram_of(fold), sums.rows_of(fold) as f64);
            let share = 1.0 - count / rows;
            let (gram, bias) = (&gram - &held, faer::Scale(share) * &bias);
            let rest = Equations::new(&gram, &bias, self.at)?;
            let mut errors = Vec::with_capacity(path.len());
            for (strength, pull, start) in path {
                let rest = rest.of(active, self.at, share * pull);
                let x = minimise(rest.quadratic(), &self.prior, *strength, start)?;
                let squares = self.squares(&held, &self.whole(active, &x));
                errors.push((squares / (count * self.at.n_joints() as f64)).sqrt());
            }
            Ok(errors)
        };
        folds.par_iter().map(of_fold).collect()
    }

    /// By what part the error on held-out folds is larger than that of the optimum without physics;
    /// `None` if folds are few.
    fn held_out_price(&self, active: &[usize], best: &Best) -> Result<Option<f64>, IdentifyError> {
        let sums = self.sums;
        let (gram, bias, rows) = (sums.gram(), sums.bias(), sums.rows() as f64);
        let (mut squares, mut count) = (0.0, 0.0);
        for fold in (0..FOLDS).filter(|&fold| sums.rows_of(fold) > 0 && !best.errors.is_empty()) {
            let (held, own) = (sums.gram_of(fold), sums.rows_of(fold) as f64);
            let share = 1.0 - own / rows;
            let rest = Equations::new(&(&gram - &held), &(faer::Scale(share) * &bias), self.at)?;
            let free = rest.of(active, self.at, share * best.pull).unconstrained()?;
            squares += (self.squares(&held, &self.whole(active, &free))
                / (own * self.at.n_joints() as f64))
                .sqrt();
            count += 1.0;
        }
        let mean = best.errors.iter().sum::<f64>() / best.errors.len().max(1) as f64;
        Ok((count > 0.0 && squares > 0.0).then(|| mean / (squares / count) - 1.0))
    }

    /// Sum of squares at parameters in the linearisation.
    fn squares(&self, gram: &Mat<f64>, x: &[f64]) -> f64 {
        let p = self.before.len();
        let z: Vec<f64> = (0..=p)
            .map(|k| if k < p { (self.before[k] - x[k]) / self.at.scales[k] } else { 1.0 })
            .collect();
        let product = gram * ColRef::from_slice(&z);
        z.iter().zip(product.iter()).map(|(z, y)| z * y).sum::<f64>().max(0.0)
    }

    /// The spread of the scores of some parameters: Σ s sᵀ over blocks of time, since neighbours
    /// are alike.
    fn scores(&self, indices: &[usize]) -> Mat<f64> {
        let (scores, blocks) = (self.sums.scores(), self.sums.blocks() as f64);
        // Few blocks scatter less than many would.
        let few = blocks / (blocks - 1.0).max(1.0);
        let scales = &self.at.scales;
        Mat::from_fn(indices.len(), indices.len(), |i, j| {
            let (i, j) = (indices[i], indices[j]);
            few * scores[(i, j)] / (scales[i] * scales[j])
        })
    }

    /// Parameters of the geometry that stay where the sample put them, yet all rows together pull
    /// away: a score test, the scores of blocks of time as its measure.
    fn released(&self, active: &[usize], best: &Best) -> Result<Vec<usize>, IdentifyError> {
        let p = self.before.len();
        let held: Vec<usize> = (0..p).filter(|k| active.binary_search(k).is_err()).collect();
        if held.is_empty() || self.sums.blocks() < LEAST_BLOCKS {
            return Ok(Vec::new());
        }
        let equations = self.equations(active, best.pull);
        let factor = curvature(equations.quadratic(), &self.prior, best.strength, &best.solution)?;
        let across =
            Mat::from_fn(active.len(), held.len(), |i, j| self.all.hessian[(active[i], held[j])]);
        let followed = factor.solve_matrix(&across);
        let x = self.whole(active, &best.solution);
        let product = &self.all.hessian * ColRef::from_slice(&x);
        let mut slope: Vec<f64> = equations.right.iter().map(|_| 0.0).collect();
        for (i, &k) in active.iter().enumerate() {
            slope[i] = self.all.right[k] - product[k];
        }
        let indices: Vec<usize> = active.iter().chain(&held).copied().collect();
        let scores = self.scores(&indices);
        let least = STRICTNESS * (self.sums.rows() as f64).ln();
        let a = active.len();
        let is_pulled = |&j: &usize| {
            // The score of a held parameter once the others have followed.
            let weights: Vec<f64> = (0..indices.len())
                .map(|i| if i < a { -followed[(i, j)] } else { f64::from(u8::from(i == a + j)) })
                .collect();
            let own = self.all.right[held[j]] - product[held[j]];
            let score: f64 = own + (0..a).map(|i| weights[i] * slope[i]).sum::<f64>();
            let spread = &scores * ColRef::from_slice(&weights);
            let variance: f64 = weights.iter().zip(spread.iter()).map(|(w, s)| w * s).sum();
            score * score > least * variance
        };
        Ok((0..held.len()).filter(is_pulled).map(|j| held[j]).collect())
    }

    /// All that the pass came to.
    fn finish(self, active: &[usize], best: Best) -> Result<Solved, IdentifyError> {
        let (p, linear) = (self.before.len(), self.at.linear.len());
        let gram = self.sums.gram();
        let feasible = self.whole(active, &best.solution);
        let equations = self.equations(active, best.pull);
        let unconstrained = self.whole(active, &equations.unconstrained()?);
        let [physical, free] = [&feasible, &unconstrained].map(|x| self.squares(&gram, x));
        let residual = if free > 0.0 { (physical / free).sqrt() - 1.0 } else { 0.0 };
        let price = PriceOfPhysics { residual, held_out: self.held_out_price(active, &best)? };

        let factor = curvature(equations.quadratic(), &self.prior, best.strength, &best.solution)?;
        let mut middle = self.scores(active);
        // The prior is as uncertain as it is weak.
        let mut unused = vec![0.0; active.len()];
        self.prior.add_slopes(&best.solution, best.strength, &mut unused, &mut middle);
        let half = factor.solve_matrix(&middle);
        let own = factor.solve_matrix(&half.transpose().to_owned());
        let mut covariance = Mat::zeros(p, p);
        for (i, &k) in active.iter().enumerate() {
            for (j, &l) in active.iter().enumerate() {
                covariance[(k, l)] = 0.5 * (own[(i, j)] + own[(j, i)]);
            }
        }
        let chosen = if self.at.structure.physical { &feasible } else { &unconstrained };
        let parameters = bounded(self.at, chosen);
        let in_errors = |&k: &usize| {
            let change = (parameters[k] - self.before[k]).abs();
            let error = covariance[(k, k)].max(0.0).sqrt();
            if change == 0.0 { 0.0 } else { change / error.max(f64::MIN_POSITIVE) }
        };
        let moved = active.iter().map(in_errors).fold(0.0, f64::max);
        let gain = self.squares(&gram, &self.before) - self.squares(&gram, &parameters);
        let settled = moved < SETTLED && gain < LEAST_GAIN * active.len() as f64;
        let mut next = self.at.at(&parameters);
        next.weights = weights(self.sums, &self.sizes);
        next.structure.free =
            active.iter().filter(|&&k| k >= linear).map(|&k| k - linear).collect();
        Ok(Solved { at: next, covariance, choice: best.choice, price, settled })
    }
}

/// How many rows tell as much as one independent one: by how much the scores of blocks of time
/// scatter more than those of independent rows would, at the median over the parameters.
fn repeats(sums: &NormalSums) -> f64 {
    let (gram, scores) = (sums.gram(), sums.scores());
    let mut ratios: Vec<f64> = (0..scores.ncols())
        .filter(|&k| gram[(k, k)] > 0.0)
        .map(|k| scores[(k, k)] / gram[(k, k)])
        .collect();
    ratios.sort_by(f64::total_cmp);
    ratios.get(ratios.len() / 2).copied().unwrap_or(1.0).max(1.0)
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
    fn new(gram: &Mat<f64>, bias: &Mat<f64>, at: &Linearisation) -> Result<Self, IdentifyError> {
        let p = at.n_parameters();
        let part = |x: &Mat<f64>| x.submatrix(0, 0, p, p).to_owned();
        let corrected = corrected(&part(gram), &part(bias))?;
        let hessian = Mat::from_fn(p, p, |i, j| corrected[(i, j)] / (at.scales[i] * at.scales[j]));
        let known = &hessian * ColRef::from_slice(&at.parameters());
        let right =
            (0..p).map(|j| (gram[(p, j)] - bias[(p, j)]) / at.scales[j] + known[j]).collect();
        Ok(Self { hessian, right })
    }

    /// The equations of some parameters, the others as they were.
    ///
    /// - `pull`: equations that a pull of the geometry to right angles counts as
    fn of(&self, active: &[usize], at: &Linearisation, pull: f64) -> Self {
        let mut held = at.parameters();
        active.iter().for_each(|&k| held[k] = 0.0);
        let known = &self.hessian * ColRef::from_slice(&held);
        let count = active.len();
        let mut own = Self {
            hessian: Mat::from_fn(count, count, |i, j| self.hessian[(active[i], active[j])]),
            right: active.iter().map(|&k| self.right[k] - known[k]).collect(),
        };
        let linear = at.linear.len();
        let anchor =
            Geometry::new(&at.geometry).map_or_else(|_| Vec::new(), |g| right_angles_near(&g));
        for (place, &k) in active.iter().enumerate().filter(|(_, k)| **k >= linear) {
            let stiffness = pull * pull_stiffness(at.structure.pull, k - linear);
            own.hessian[(place, place)] += stiffness;
            own.right[place] += stiffness * anchor.get(k - linear).unwrap_or(&0.0);
        }
        own
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
