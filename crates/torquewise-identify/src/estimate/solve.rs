//! Normal equations → the next parameters, what is certain of them, and what physics cost (E11)
//! (E14).

use super::equations::{Equations, cost_of_pull};
use super::linearisation::Linearisation;
use super::nominal::{Sizes, prior};
use crate::error::IdentifyError;
use crate::held_out::{Trial, choose, listed, mean};
use faer::{ColRef, Mat};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use torquewise_model::model::{Choice, PriceOfPhysics};
use torquewise_rigid::feasible::{Prior, curvature, minimise};
use torquewise_sparse::normal_sums::{FOLDS, NormalSums};

/// The choice of the prior's strength, as the model file has it.
pub(crate) const STRENGTH: &str = "strength of the physical prior";
/// Strengths of the prior that are tried, the strongest first, in units of what one independent
/// row tells. A weaker one would leave to noise what the log does not tell, and no held-out row of
/// the same log would object.
const STRENGTHS: [f64; 9] = [1e3, 1e2, 30.0, 10.0, 3.0, 1.0, 0.3, 0.1, 0.03];
/// The strength where a log is too short to choose one.
const USUAL_STRENGTH: f64 = 10.0;
/// Parts of the pull on the geometry that are tried once the prior is as strong as it should be.
const PULLS: [f64; 5] = [1.0, 0.1, 1e-2, 1e-3, 1e-4];
/// Fewer folds with rows are too few to choose by.
const LEAST_FOLDS: usize = 3;
/// Equations that the pull on the geometry counts as at most: it must not grow with the log.
const MOST_PULLED: f64 = 20_000.0;
/// Longest step of a parameter of the geometry: rad or m.
const LONGEST: f64 = 0.2;
/// A residual below this part of the torque is taken for it: weights stay finite.
const LEAST_RESIDUAL: f64 = 1e-4;
/// Blocks of time that a score test needs.
const LEAST_BLOCKS: u64 = 30;
/// A held parameter is released where its squared score is so many times ln m above its variance.
const STRICTNESS: f64 = 3.0;
/// So much the cost may still fall for each parameter, in squares of the noise of an independent
/// row: parameters are then within about a tenth of their standard errors.
const LEAST_GAIN: f64 = 0.005;
/// What a step of the geometry costs that would be too long without, in parts of its curvature.
const LEAST_DAMPING: f64 = 1e-6;
const MOST_DAMPING: f64 = 1e3;

/// What a fit is tuned by, chosen on held-out folds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Tuning {
    /// Strength of the prior.
    strength: f64,
    /// What the pull on the geometry counts as, in equations.
    pull: f64,
    /// How the strength was chosen; nothing where a log has too few folds.
    pub(super) choice: Option<Choice>,
    /// Errors on held-out folds; empty where they are too few.
    errors: Vec<f64>,
}

/// What the passes over the rows came to.
#[derive(Clone, Debug)]
pub(crate) struct Solved {
    /// The parameters, and weights by what they leave of the torque.
    pub(crate) at: Linearisation,
    /// Covariance of all parameters, p×p.
    pub(crate) covariance: Mat<f64>,
    /// How the strength of the prior was chosen.
    pub(crate) choice: Option<Choice>,
    /// What physics costs, beside the optimum without.
    pub(crate) price: PriceOfPhysics,
}

/// The place of the best of some ways to fit, and the errors of each on each fold.
type Judged = (usize, Vec<Vec<f64>>);

/// The normal equations of a pass, and what physics says of its parameters.
pub(super) struct Step<'a> {
    sums: &'a NormalSums,
    at: &'a Linearisation,
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

impl<'a> Step<'a> {
    pub(super) fn new(
        sums: &'a NormalSums,
        at: &'a Linearisation,
        sizes: &'a Sizes,
    ) -> Result<Self, IdentifyError> {
        let (prior, start) = prior(at, sizes)?;
        let all = Equations::new(&sums.gram(), &sums.bias(), at)?;
        let repeats = repeats(sums);
        Ok(Self { sums, at, prior, start, before: at.parameters(), all, repeats })
    }

    /// Parameters as they were, those that may move as a solution has them.
    fn whole(&self, active: &[usize], solution: &[f64]) -> Vec<f64> {
        let mut whole = self.before.clone();
        active.iter().zip(solution).for_each(|(&k, x)| whole[k] = *x);
        whole
    }

    /// Chooses what the fit is tuned by, and where the sample may be overruled which parameters of
    /// the geometry move: what the sample put at right angles may be wrong.
    pub(super) fn tuned(&self, may_release: bool) -> Result<(Vec<usize>, Tuning), IdentifyError> {
        let active = self.at.active();
        let held = self.tuning(&active)?;
        let released = if may_release { self.released(&active, &held)? } else { Vec::new() };
        if released.is_empty() {
            return Ok((active, held));
        }
        let mut more: Vec<usize> = active.iter().copied().chain(released).collect();
        more.sort_unstable();
        let free = self.tuning(&more)?;
        let pair = [("held", &held), ("released", &free)].map(|(label, tuning)| Trial {
            label: label.to_owned(),
            complexity: 0,
            errors: tuning.errors.clone(),
        });
        let is_better = choose("geometry", &pair).is_some_and(|(place, _)| place == 1);
        Ok(if is_better { (more, free) } else { (active, held) })
    }

    /// The best parameters that the geometry of the linearisation allows.
    pub(super) fn linear(&self, tuning: &Tuning) -> Result<Vec<f64>, IdentifyError> {
        let linear: Vec<usize> = (0..self.at.linear.len()).collect();
        let equations = self.all.of(&linear, self.at, (tuning.pull, 0.0));
        Ok(self.whole(&linear, &self.minimum(&equations, &linear, tuning)?))
    }

    /// Half the sum of squares at parameters in the linearisation, with what prior and pull add:
    /// infinite where the prior does not allow them.
    pub(super) fn cost(&self, x: &[f64], tuning: &Tuning) -> f64 {
        let prior = if self.at.structure.physical {
            tuning.strength * self.prior.value(x).unwrap_or(f64::INFINITY)
        } else {
            0.0
        };
        self.all.cost(self.at, x) + prior + cost_of_pull(self.at, x, tuning.pull)
    }

    /// The best parameters where some may move; the geometry takes no step that leaves its
    /// linearisation.
    pub(super) fn step(
        &self,
        active: &[usize],
        tuning: &Tuning,
    ) -> Result<Vec<f64>, IdentifyError> {
        let linear = self.at.linear.len();
        let mut damping = 0.0;
        loop {
            let equations = self.all.of(active, self.at, (tuning.pull, damping));
            let best = self.whole(active, &self.minimum(&equations, active, tuning)?);
            let moves = best.iter().zip(&self.before).skip(linear);
            let longest = moves.fold(0.0_f64, |most, (x, b)| most.max((x - b).abs()));
            if longest <= LONGEST || damping > MOST_DAMPING {
                return Ok(best);
            }
            damping = (10.0 * damping).max(LEAST_DAMPING);
        }
    }

    fn minimum(
        &self,
        equations: &Equations,
        active: &[usize],
        tuning: &Tuning,
    ) -> Result<Vec<f64>, IdentifyError> {
        if !self.at.structure.physical {
            return equations.unconstrained();
        }
        let allowed =
            if self.prior.value(&self.before).is_some() { &self.before } else { &self.start };
        let start: Vec<f64> = active.iter().map(|&k| allowed[k]).collect();
        Ok(minimise(equations.quadratic(), &self.prior, tuning.strength, &start)?)
    }

    /// Part of the cost that may be left: the parameters are then within a small part of their
    /// standard errors.
    pub(super) fn tolerance(&self, active: &[usize]) -> f64 {
        LEAST_GAIN * active.len() as f64 * self.repeats
    }

    /// Chooses how strong the prior is, and then how strongly the geometry is pulled, on held-out
    /// folds.
    ///
    /// A weaker prior makes no model longer: the best is taken, not the strongest near it.
    pub(super) fn tuning(&self, active: &[usize]) -> Result<Tuning, IdentifyError> {
        let equations = self.sums.rows() as f64 * self.at.n_joints() as f64;
        let pull = equations.min(MOST_PULLED);
        let strengths = STRENGTHS.map(|strength| (strength * self.repeats, pull));
        let Some((place, errors)) = self.best_of(active, &strengths)? else {
            let strength = USUAL_STRENGTH * self.repeats;
            return Ok(Tuning { strength, pull, choice: None, errors: Vec::new() });
        };
        let (strength, _) = strengths[place];
        let trials: Vec<Trial> = (STRENGTHS.iter().zip(&errors))
            .map(|(strength, errors)| Trial {
                label: strength.to_string(),
                complexity: active.len(),
                errors: errors.clone(),
            })
            .collect();
        let choice = Some(Choice {
            what: STRENGTH.into(),
            chosen: trials[place].label.clone(),
            rule: format!("least error, {} folds of blocks in time", errors[place].len()),
            from: listed(&trials),
        });
        let tuning = Tuning { strength, pull, choice, errors: errors[place].clone() };
        if active.len() == self.at.linear.len() {
            return Ok(tuning);
        }
        let pulls = PULLS.map(|share| (strength, share * pull));
        Ok(match self.best_of(active, &pulls)? {
            Some((place, errors)) => {
                Tuning { pull: pulls[place].1, errors: errors[place].clone(), ..tuning }
            }
            None => tuning,
        })
    }

    /// Which of some pairs of strength and pull does best on held-out folds, and the errors of each
    /// on each fold; nothing if folds are few.
    fn best_of(
        &self,
        active: &[usize],
        pairs: &[(f64, f64)],
    ) -> Result<Option<Judged>, IdentifyError> {
        let sums = self.sums;
        let folds: Vec<usize> = (0..FOLDS).filter(|&fold| sums.rows_of(fold) > 0).collect();
        if folds.len() < LEAST_FOLDS {
            return Ok(None);
        }
        let of_fold = |&fold: &usize| {
            let (held, rest, share) = self.without(fold)?;
            let mut x: Vec<f64> = active.iter().map(|&k| self.start[k]).collect();
            let mut errors = Vec::with_capacity(pairs.len());
            for (strength, pull) in pairs {
                let rest = rest.of(active, self.at, (share * pull, 0.0));
                x = minimise(rest.quadratic(), &self.prior, *strength, &x)?;
                errors.push(self.error(&held, fold, &self.whole(active, &x)));
            }
            Ok(errors)
        };
        let by_fold = folds.par_iter().map(of_fold).collect::<Result<Vec<_>, IdentifyError>>()?;
        let errors: Vec<Vec<f64>> = (0..pairs.len())
            .map(|pair| by_fold.iter().map(|errors| errors[pair]).collect())
            .collect();
        let best = (0..pairs.len()).min_by(|&a, &b| mean(&errors[a]).total_cmp(&mean(&errors[b])));
        Ok(best.map(|place| (place, errors)))
    }

    /// The Gram matrix of a fold, the equations of the others, and their part of all rows.
    fn without(&self, fold: usize) -> Result<(Mat<f64>, Equations, f64), IdentifyError> {
        let sums = self.sums;
        let held = sums.gram_of(fold);
        let share = 1.0 - sums.rows_of(fold) as f64 / sums.rows() as f64;
        let (gram, bias) = (sums.gram() - &held, faer::Scale(share) * sums.bias());
        let rest = Equations::new(&gram, &bias, self.at)?;
        Ok((held, rest, share))
    }

    /// RMS of the residual of a fold in units of the noise.
    fn error(&self, held: &Mat<f64>, fold: usize, x: &[f64]) -> f64 {
        let equations = self.sums.rows_of(fold) as f64 * self.at.n_joints() as f64;
        (self.squares(held, x) / equations.max(1.0)).sqrt()
    }

    /// By what part the error on held-out folds is larger than that of the optimum without physics;
    /// `None` if folds are few.
    fn held_out_price(
        &self,
        active: &[usize],
        tuning: &Tuning,
    ) -> Result<Option<f64>, IdentifyError> {
        let mut free = Vec::with_capacity(FOLDS);
        let with_rows = |fold: &usize| self.sums.rows_of(*fold) > 0 && !tuning.errors.is_empty();
        for fold in (0..FOLDS).filter(with_rows) {
            let (held, rest, share) = self.without(fold)?;
            let best = rest.of(active, self.at, (share * tuning.pull, 0.0)).unconstrained()?;
            free.push(self.error(&held, fold, &self.whole(active, &best)));
        }
        let (physical, free) = (mean(&tuning.errors), mean(&free));
        Ok((free > 0.0).then(|| physical / free - 1.0))
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
    fn released(&self, active: &[usize], tuning: &Tuning) -> Result<Vec<usize>, IdentifyError> {
        let p = self.before.len();
        let held: Vec<usize> = (0..p).filter(|k| active.binary_search(k).is_err()).collect();
        if held.is_empty() || self.sums.blocks() < LEAST_BLOCKS {
            return Ok(Vec::new());
        }
        let equations = self.all.of(active, self.at, (tuning.pull, 0.0));
        let solution = self.minimum(&equations, active, tuning)?;
        let factor = curvature(equations.quadratic(), &self.prior, tuning.strength, &solution)?;
        let across =
            Mat::from_fn(active.len(), held.len(), |i, j| self.all.hessian[(active[i], held[j])]);
        let followed = factor.solve_matrix(&across);
        let x = self.whole(active, &solution);
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

    /// All that the passes came to, once the parameters stay where they are.
    pub(super) fn solved(self, active: &[usize], tuning: Tuning) -> Result<Solved, IdentifyError> {
        let (p, linear) = (self.before.len(), self.at.linear.len());
        let gram = self.sums.gram();
        let equations = self.all.of(active, self.at, (tuning.pull, 0.0));
        let solution = self.minimum(&equations, active, &tuning)?;
        let feasible = self.whole(active, &solution);
        let unconstrained = self.whole(active, &equations.unconstrained()?);
        let [physical, free] = [&feasible, &unconstrained].map(|x| self.squares(&gram, x));
        let residual = if free > 0.0 { (physical / free).sqrt() - 1.0 } else { 0.0 };
        let held_out = self.held_out_price(active, &tuning)?;

        let own = if self.at.structure.physical {
            (self.prior.clone(), tuning.strength)
        } else {
            (Prior::default(), 0.0)
        };
        let factor = curvature(equations.quadratic(), &own.0, own.1, &solution)?;
        let mut middle = self.scores(active);
        // The prior is as uncertain as it is weak.
        own.0.add_slopes(&solution, own.1, &mut vec![0.0; active.len()], &mut middle);
        let half = factor.solve_matrix(&middle);
        let own = factor.solve_matrix(&half.transpose().to_owned());
        let mut covariance = Mat::zeros(p, p);
        for (i, &k) in active.iter().enumerate() {
            for (j, &l) in active.iter().enumerate() {
                covariance[(k, l)] = 0.5 * (own[(i, j)] + own[(j, i)]);
            }
        }
        let mut at = self.at.clone();
        at.structure.free = active.iter().filter_map(|k| k.checked_sub(linear)).collect();
        let price = PriceOfPhysics { residual, held_out };
        Ok(Solved { at, covariance, choice: tuning.choice, price })
    }
}

/// How many rows tell as much as one independent one: by how much the scores of blocks of time
/// scatter more than those of independent rows would, at the median over the parameters.
fn repeats(sums: &NormalSums) -> f64 {
    let (gram, scores) = (sums.gram(), sums.scores());
    let p = scores.ncols();
    let equations = sums.rows() as f64 * sums.residual_rms().len() as f64;
    // Mean square of a residual in units of the noise that weights are made of.
    let noise = (gram[(p, p)] / equations.max(1.0)).max(f64::MIN_POSITIVE);
    let mut ratios: Vec<f64> = (0..scores.ncols())
        .filter(|&k| gram[(k, k)] > 0.0)
        .map(|k| scores[(k, k)] / (gram[(k, k)] * noise))
        .collect();
    ratios.sort_by(f64::total_cmp);
    ratios.get(ratios.len() / 2).copied().unwrap_or(1.0).max(1.0)
}

/// One over the residual of each joint \[1/(N·m)\], n.
pub(super) fn weights(sums: &NormalSums, sizes: &Sizes) -> Vec<f64> {
    let residuals = sums.weighted_rms().into_iter().zip(&sizes.torque);
    residuals
        .map(|(rms, torque)| {
            1.0 / rms.max(LEAST_RESIDUAL * if *torque > 0.0 { *torque } else { 1.0 })
        })
        .collect()
}
