//! Merit of a pass, and the best step from there (E11) (E14).

use super::equations::{Equations, cost_of_pull};
use super::linearisation::Linearisation;
use super::nominal::{Sizes, prior};
use faer::{ColRef, Mat};
use torquewise_motion::median;
use torquewise_regression::NormalSums;
use torquewise_rigid::feasible::{Prior, minimise};
use torquewise_stepwise::IdentifyError;

/// A residual below this part of the torque is taken for it: weights stay finite.
pub(crate) const LEAST_RESIDUAL: f64 = 1e-4;
/// Noise of a torque that was not measured, in spreads of the largest.
const UNMEASURED: f64 = 1e3;
/// Strength of the prior in units of what one independent row determines. A weaker one would leave to
/// noise what the log does not tell, and no held-out row of the same log would object.
pub(crate) const STRENGTH: f64 = 0.03;
/// So much the cost may still fall for each parameter, in squares of the noise of an independent
/// row: parameters are then within a small part of their standard errors.
const LEAST_GAIN: f64 = 0.002;
/// Exponents of ten between which the price of a step of the geometry is looked for, in parts of
/// its curvature.
const DAMPING: [f64; 2] = [-12.0, 3.0];
/// Exponents that are closer are one.
const CLOSE: f64 = 0.1;

/// The normal equations of a pass, and the physical constraints on its parameters.
pub(super) struct Step<'a> {
    pub(super) sums: &'a NormalSums,
    pub(super) at: &'a Linearisation,
    /// Of all rows.
    pub(super) gram: Mat<f64>,
    pub(super) bias: Mat<f64>,
    pub(super) prior: Prior,
    /// Parameters that the prior allows.
    pub(super) start: Vec<f64>,
    pub(super) before: Vec<f64>,
    /// Without the prior of the geometry.
    pub(super) all: Equations,
    /// Rows per independent row: errors of neighbours are correlated.
    pub(super) repeats: f64,
    /// Rows that the prior of the geometry, which is that of arms, counts as: one independent row of
    /// the first pass, so that all passes are judged alike.
    pub(super) prior_rows: f64,
}

impl<'a> Step<'a> {
    pub(super) fn new(sums: &'a NormalSums, at: &'a Linearisation, sizes: &Sizes) -> Self {
        let (prior, start) = prior(at, sizes);
        let (gram, bias) = (sums.gram(), sums.bias());
        let all = Equations::new(&gram, &bias, at);
        let (before, repeats) = (at.parameters(), repeats(sums, &gram));
        let prior_rows = repeats;
        Self { sums, at, gram, bias, prior, start, before, all, repeats, prior_rows }
    }

    pub(super) fn strength(&self) -> f64 {
        STRENGTH * self.prior_rows
    }

    /// Parameters as they were, those that may move as a solution has them.
    pub(super) fn whole(&self, active: &[usize], solution: &[f64]) -> Vec<f64> {
        let mut whole = self.before.clone();
        active.iter().zip(solution).for_each(|(&k, x)| whole[k] = *x);
        whole
    }

    /// The best parameters that the geometry of the linearisation allows.
    pub(super) fn linear(&self) -> Result<Vec<f64>, IdentifyError> {
        let linear: Vec<usize> = (0..self.at.linear.len()).collect();
        let equations = self.all.of(&linear, self.at, (self.prior_rows, 0.0));
        Ok(self.whole(&linear, &self.minimum(&equations, &linear)?))
    }

    /// The mean of the best linear parameters and of the best where what was chosen is all there is:
    /// both are physical arms, and so is their mean (E21).
    pub(super) fn averaged(&self, best: &[f64], sizes: &Sizes) -> Result<Vec<f64>, IdentifyError> {
        if self.at.chosen == self.at.drive.len() {
            return Ok(best.to_vec());
        }
        let (mut at, chosen) = (self.at.clone(), self.at.chosen_indices());
        at.linear[chosen.len()..].fill(0.0);
        let (prior, start) = prior(&self.at.narrowed(), sizes);
        let own = self.all.of(&chosen, &at, (0.0, 0.0));
        let solution = minimise(own.quadratic(), &prior, self.strength(), &start[..chosen.len()])?;
        let mut few = at.parameters();
        few[..chosen.len()].copy_from_slice(&solution);
        Ok(best.iter().zip(&few).map(|(best, few)| 0.5 * (best + few)).collect())
    }

    /// Half the sum of squares at parameters in the linearisation, with what the priors add:
    /// infinite where the prior does not allow them.
    pub(super) fn cost(&self, x: &[f64]) -> f64 {
        let prior = self.strength() * self.prior.value(x).unwrap_or(f64::INFINITY);
        self.all.cost(self.at, x) + prior + cost_of_pull(self.at, x, self.prior_rows)
    }

    /// The best parameters where some may move, none of the geometry by more than `reach`
    /// \[rad, m\].
    pub(super) fn step(&self, active: &[usize], reach: f64) -> Result<Vec<f64>, IdentifyError> {
        let linear = self.at.linear.len();
        let damped = |damping: f64| -> Result<(Vec<f64>, f64), IdentifyError> {
            let equations = self.all.of(active, self.at, (self.prior_rows, damping));
            let best = self.whole(active, &self.minimum(&equations, active)?);
            let moves = best.iter().zip(&self.before).skip(linear);
            let longest = moves.fold(0.0_f64, |most, (x, b)| most.max((x - b).abs()));
            Ok((best, longest))
        };
        let (mut best, mut longest) = damped(0.0)?;
        // Exponents of ten of a damping that is too weak, and of one that is strong enough.
        let [mut weak, mut strong] = DAMPING;
        while longest > reach || (longest < 0.5 * reach && strong < DAMPING[1]) {
            let middle = 0.5 * (weak + strong);
            if strong - weak < CLOSE {
                return Ok(damped(10_f64.powf(strong))?.0);
            }
            (best, longest) = damped(10_f64.powf(middle))?;
            if longest > reach { weak = middle } else { strong = middle }
        }
        Ok(best)
    }

    pub(super) fn minimum(
        &self,
        equations: &Equations,
        active: &[usize],
    ) -> Result<Vec<f64>, IdentifyError> {
        let is_allowed = self.prior.value(&self.before).is_some();
        let start = if is_allowed { &self.before } else { &self.start };
        let start: Vec<f64> = active.iter().map(|&k| start[k]).collect();
        Ok(minimise(equations.quadratic(), &self.prior, self.strength(), &start)?)
    }

    /// Part of all rows that a fold has.
    pub(super) fn share_of(&self, fold: usize) -> f64 {
        self.sums.rows_of(fold) as f64 / self.sums.rows() as f64
    }

    /// Part of the cost that may be left: the parameters are then within a small part of their
    /// standard errors.
    pub(super) fn tolerance(&self, active: &[usize]) -> f64 {
        LEAST_GAIN * active.len() as f64 * self.repeats
    }

    /// Sum of squares at parameters in the linearisation.
    pub(super) fn squares(&self, gram: &Mat<f64>, x: &[f64]) -> f64 {
        let p = self.before.len();
        let z: Vec<f64> = (0..=p)
            .map(|k| if k < p { (self.before[k] - x[k]) / self.at.scales[k] } else { 1.0 })
            .collect();
        let product = gram * ColRef::from_slice(&z);
        z.iter().zip(product.iter()).map(|(z, y)| z * y).sum::<f64>().max(0.0)
    }
}

/// How many rows tell as much as one independent one: by how much the scores of blocks of time
/// scatter more than those of independent rows would, at the median over the parameters.
fn repeats(sums: &NormalSums, gram: &Mat<f64>) -> f64 {
    let scores = sums.scores();
    let p = scores.ncols();
    let equations = sums.rows() as f64 * sums.residual_rms().len() as f64;
    // Mean square of a residual in units of the noise that weights are made of.
    let noise = (gram[(p, p)] / equations.max(1.0)).max(f64::MIN_POSITIVE);
    let mut ratios: Vec<f64> = (0..scores.ncols())
        .filter(|&k| gram[(k, k)] > 0.0)
        .map(|k| scores[(k, k)] / (gram[(k, k)] * noise))
        .collect();
    median(&mut ratios).max(1.0)
}

/// One over the residual of each joint \[1/(N·m)\], n. A torque that never changes is none that was
/// measured: it counts next to nothing.
pub(crate) fn weights(residual_rms: &[f64], sizes: &Sizes) -> Vec<f64> {
    let largest = sizes.torque.iter().fold(0.0_f64, |most, torque| most.max(*torque));
    let unmeasured = UNMEASURED * if largest > 0.0 { largest } else { 1.0 };
    let noise = |(rms, torque): (&f64, &f64)| {
        if *torque > 0.0 { rms.max(LEAST_RESIDUAL * torque) } else { unmeasured }
    };
    residual_rms.iter().zip(&sizes.torque).map(|pair| 1.0 / noise(pair)).collect()
}
