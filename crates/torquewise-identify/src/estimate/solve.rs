//! Parameters and covariance of converged sums (E11) (E14).

use super::equations::Equations;
use super::linearisation::Linearisation;
use super::step::Step;
use faer::{ColRef, Mat};
use rayon::prelude::*;
use torquewise_rigid::UsualArm;
use torquewise_rigid::feasible::{curvature, minimise};
use torquewise_stepwise::IdentifyError;
use torquewise_stepwise::held_out::{CvScore, record_worth};

/// Blocks of time that a score test needs.
const LEAST_BLOCKS: u64 = 30;
/// A held parameter is released where its squared score is so many times ln m above its variance.
const STRICTNESS: f64 = 3.0;
/// So much lower the error on held-out folds must be: where the model errs by more than noise, axes
/// leave their right angles to make up for it.
const WORTH: f64 = 0.02;
/// Fewer folds with rows are too few to choose by.
const LEAST_FOLDS: usize = 3;
/// A spread below this part of that by noise is rounding.
const NOTHING: f64 = 1e-6;

/// What the passes over the rows came to.
#[derive(Clone, Debug)]
pub(crate) struct Solved {
    /// The parameters, and weights by what they leave of the torque.
    pub(crate) at: Linearisation,
    /// Covariance of all parameters, p×p.
    pub(crate) covariance: Mat<f64>,
    /// Rows that the prior counts as, of all rows.
    pub(crate) prior_rows: f64,
}

impl Step<'_> {
    /// Parameters that move, with those of the geometry that the sample held wrongly: what it put at
    /// right angles may be off.
    pub(super) fn with_released(&self) -> Result<Vec<usize>, IdentifyError> {
        let active = self.at.active();
        let released = self.released(&active)?;
        if released.is_empty() {
            return Ok(active);
        }
        let mut more: Vec<usize> = active.iter().copied().chain(released).collect();
        more.sort_unstable();
        let mut trials = Vec::new();
        for (label, indices) in [("held", &active), ("released", &more)] {
            let errors = self.errors(indices)?;
            trials.push(CvScore { label: label.to_owned(), complexity: 0, errors });
        }
        let is_better = record_worth("geometry", &trials, WORTH, &mut Vec::new()) == 1;
        Ok(if is_better { more } else { active })
    }

    /// RMS of what is left of each held-out fold in units of the noise; nothing if folds are few.
    fn errors(&self, active: &[usize]) -> Result<Vec<f64>, IdentifyError> {
        let folds = self.sums.folds();
        if folds.len() < LEAST_FOLDS {
            return Ok(Vec::new());
        }
        let of_fold = |&fold: &usize| {
            let (held, share) = (self.sums.gram_of(fold), 1.0 - self.share_of(fold));
            let (gram, bias) = (&self.gram - &held, faer::Scale(share) * &self.bias);
            let rest = Equations::new(&gram, &bias, self.at);
            let rest = rest.of(active, self.at, (share * self.prior_rows, 0.0));
            let start: Vec<f64> = active.iter().map(|&k| self.start[k]).collect();
            let found = minimise(rest.quadratic(), &self.prior, self.strength(), &start)?;
            let equations = self.sums.rows_of(fold) as f64 * self.at.n_joints() as f64;
            let left = self.squares(&held, &self.whole(active, &found));
            Ok((left / equations.max(1.0)).sqrt())
        };
        folds.par_iter().map(of_fold).collect()
    }

    /// The spread of the scores of some parameters: Σ (s − s̄)(s − s̄)ᵀ over blocks of time, since
    /// neighbours are alike.
    fn scores(&self, indices: &[usize]) -> Mat<f64> {
        let (scores, blocks) = (self.sums.scores(), self.sums.blocks() as f64);
        let p = self.before.len();
        let sum = |j: usize| self.gram[(p, j)] - self.bias[(p, j)];
        // Few blocks scatter less than many would.
        let few = blocks / (blocks - 1.0).max(1.0);
        let scales = &self.at.scales;
        Mat::from_fn(indices.len(), indices.len(), |i, j| {
            let (i, j) = (indices[i], indices[j]);
            few * (scores[(i, j)] - sum(i) * sum(j) / blocks) / (scales[i] * scales[j])
        })
    }

    /// The same over regions of configuration, of which there are few: what the model gets wrong in one
    /// is alike in all of its blocks (E22).
    fn scores_by_region(&self, indices: &[usize]) -> Mat<f64> {
        let p = self.before.len();
        let folds = self.sums.folds();
        let few = folds.len() as f64 / (folds.len() as f64 - 1.0).max(1.0);
        let mut scores = Mat::zeros(indices.len(), indices.len());
        for fold in folds {
            let (gram, share) = (self.sums.gram_of(fold), self.share_of(fold));
            // The bias of noise is of all rows alike, and no part of what sets a region apart.
            let own = |k: usize| (gram[(p, k)] - share * self.gram[(p, k)]) / self.at.scales[k];
            let own: Vec<f64> = indices.iter().map(|&k| own(k)).collect();
            for i in 0..own.len() {
                (0..own.len()).for_each(|j| scores[(i, j)] += few * own[i] * own[j]);
            }
        }
        scores
    }

    /// The same over joints: where the model is wrong, they pull a parameter apart in all rows alike
    /// (E22). What they pull together is shared out by what each tells: nothing is left of one joint.
    fn scores_by_joint(&self, indices: &[usize]) -> Mat<f64> {
        let [scores, squares] = self.sums.apart();
        let n = scores.ncols() as f64;
        let own = Mat::from_fn(indices.len(), scores.ncols(), |i, joint| {
            let k = indices[i];
            let [pull, told] = [&scores, &squares].map(|of| of.row(k).sum());
            let share = if told > 0.0 { squares[(k, joint)] / told } else { 0.0 };
            (scores[(k, joint)] - share * pull) / self.at.scales[k]
        });
        faer::Scale(n / (n - 1.0).max(1.0)) * (&own * own.transpose())
    }

    /// Parameters of the geometry that stay where the sample put them, yet all rows together pull
    /// away: a score test, the scores of blocks of time as its measure.
    fn released(&self, active: &[usize]) -> Result<Vec<usize>, IdentifyError> {
        let p = self.before.len();
        let (linear, movable) = (self.at.linear.len(), self.at.geometry.movable());
        let moves = |k: usize| k.checked_sub(linear).is_none_or(|k| movable.contains(&k));
        let held: Vec<usize> =
            (0..p).filter(|&k| active.binary_search(&k).is_err() && moves(k)).collect();
        if held.is_empty() || self.sums.blocks() < LEAST_BLOCKS {
            return Ok(Vec::new());
        }
        let equations = self.all.of(active, self.at, (self.prior_rows, 0.0));
        let solution = self.minimum(&equations, active)?;
        let factor = curvature(equations.quadratic(), &self.prior, self.strength(), &solution)?;
        let across =
            Mat::from_fn(active.len(), held.len(), |i, j| self.all.hessian[(active[i], held[j])]);
        let followed = factor.solve_matrix(&across);
        let x = self.whole(active, &solution);
        let product = &self.all.hessian * ColRef::from_slice(&x);
        let slope: Vec<f64> = active.iter().map(|&k| self.all.right[k] - product[k]).collect();
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
    pub(super) fn solved(self, active: &[usize]) -> Result<Solved, IdentifyError> {
        let p = self.before.len();
        let equations = self.all.of(active, self.at, (self.prior_rows, 0.0));
        let solution = self.minimum(&equations, active)?;
        let strength = self.strength();
        let factor = curvature(equations.quadratic(), &self.prior, strength, &solution)?;
        // An arm differs from the nominal one by what is usual, however strongly the fit holds it there,
        // and by more where the prior is weaker than that of one independent row.
        let uncertain = |strength: f64| strength * strength.max(self.repeats);
        let linear = self.at.linear.len();
        let precision = UsualArm::near(&self.at.geometry).precision;
        let spread = |mut middle: Mat<f64>| -> Mat<f64> {
            self.prior.add_hessian(&solution, uncertain(strength), &mut middle);
            for (place, &k) in active.iter().enumerate().filter(|(_, k)| **k >= linear) {
                middle[(place, place)] += uncertain(self.prior_rows) * precision[k - linear];
            }
            factor.sandwiched(&middle)
        };
        let own = spread(self.scores(active));
        let by_region = spread(self.scores_by_region(active));
        // Blocks of a stretch, and stretches of a region, may err alike: the larger spread counts.
        let wider: Vec<f64> = (0..active.len())
            .map(|k| (by_region[(k, k)] / own[(k, k)]).sqrt().max(1.0))
            .map(|ratio| if ratio.is_finite() { ratio } else { 1.0 })
            .collect();
        let by_joint = factor.sandwiched(&self.scores_by_joint(active));
        let by_joint = faer::Scale(excess(&by_joint, &own)) * by_joint;
        // The prior leaves none without a rotor: what it pulls one up by may be all of it.
        let mut pulls = Mat::zeros(active.len(), active.len());
        for (k, pull) in self.prior.pulls_of_rotors(&solution) {
            pulls[(k, k)] = (strength * pull).powi(2);
        }
        let others = by_joint + factor.sandwiched(&pulls);
        let mut covariance = Mat::zeros(p, p);
        for (i, &k) in active.iter().enumerate() {
            for (j, &l) in active.iter().enumerate() {
                covariance[(k, l)] =
                    0.5 * wider[i] * wider[j] * (own[(i, j)] + own[(j, i)]) + others[(i, j)];
            }
        }
        let at = self.at.clone().freed(active);
        Ok(Solved { at, covariance, prior_rows: self.prior_rows })
    }
}

/// The part of a spread that another, which noise alone makes, does not explain: at the upper quartile
/// of the parameters that it is of.
fn excess(spread: &Mat<f64>, noise: &Mat<f64>) -> f64 {
    let ratio = |k: usize| spread[(k, k)] / noise[(k, k)].max(f64::MIN_POSITIVE);
    let mut ratios: Vec<f64> =
        (0..spread.nrows()).map(ratio).filter(|ratio| *ratio > NOTHING).collect();
    ratios.sort_by(f64::total_cmp);
    ratios.get(3 * ratios.len() / 4).map_or(0.0, |ratio| (1.0 - 1.0 / ratio).max(0.0))
}
