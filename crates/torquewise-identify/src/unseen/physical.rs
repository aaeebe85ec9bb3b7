//! Held-out error of a physical arm: the parameters of each trial are held to what those of the whole
//! fit were held to (E14).

use super::{Errors, Unseen, all_of};
use crate::estimate::{Sizes, Solved, prior};
use faer::Mat;
use rayon::prelude::*;
use torquewise_rigid::UsualArm;
use torquewise_rigid::feasible::{Prior, Quadratic, minimise, minimise_from_afar};
use torquewise_stepwise::error::IdentifyError;

/// Price of a parameter, relative to the diagonal of the normal equations: rounding makes them
/// indefinite where torque tells nothing.
const ROUNDING: f64 = 1e-11;

/// What the parameters of an arm are held to, whatever the rows.
pub(crate) struct HeldTo {
    prior: Prior,
    strength: f64,
    /// Stiffness and rest of each step of the geometry, the last parameters.
    pulls: Vec<(f64, f64)>,
    /// Parameters that the prior allows.
    start: Vec<f64>,
}

impl HeldTo {
    /// What a fit to all rows was held to, as it counts beside a share of them.
    pub(crate) fn of(solved: &Solved, sizes: &Sizes, share: f64) -> Self {
        let at = solved.at.narrowed();
        let (prior, mut start) = prior(&at, sizes);
        start.truncate(at.linear.len());
        let [strength, stiffness] = solved.strengths.map(|strength| share * strength);
        let (usual, own) = (UsualArm::near(&at.geometry), at.geometry.parameters());
        let pull = |&k: &usize| (stiffness * usual.precision[k], usual.parameters[k] - own[k]);
        let pulls: Vec<(f64, f64)> = at.structure.free.iter().map(pull).collect();
        start.resize(start.len() + pulls.len(), 0.0);
        Self { prior, strength, pulls, start }
    }

    /// The best parameters of normal equations.
    fn best(
        &self,
        (mut gram, right): (Mat<f64>, Mat<f64>),
        near: Option<&[f64]>,
    ) -> Result<Vec<f64>, IdentifyError> {
        let p = gram.ncols();
        let mut right: Vec<f64> = right.col(0).iter().copied().collect();
        (0..p).for_each(|k| gram[(k, k)] *= 1.0 + ROUNDING);
        for (k, (stiffness, rest)) in (p - self.pulls.len()..p).zip(&self.pulls) {
            gram[(k, k)] += stiffness;
            right[k] += stiffness * rest;
        }
        let cost = Quadratic { hessian: &gram, right: &right };
        Ok(match near {
            Some(near) => minimise(cost, &self.prior, self.strength, near)?,
            None => minimise_from_afar(cost, &self.prior, self.strength, &self.start)?,
        })
    }
}

impl Unseen<'_> {
    /// What all columns, the parameters of a physical arm, leave of the first target.
    ///
    /// # Errors
    /// [`IdentifyError::Chain`] if no such arm can be solved for.
    pub(crate) fn physical_errors(
        &self,
        held_to: &HeldTo,
    ) -> Result<Option<Errors>, IdentifyError> {
        let (gram, right) = &self.all;
        let near = held_to.best((gram.clone(), right.clone()), None)?;
        let solved = self.around.par_iter().map(|(own_gram, own_right)| {
            let x = held_to.best((gram - own_gram, right - own_right), Some(&near))?;
            Ok(Mat::from_fn(x.len(), 1, |k, _| x[k]))
        });
        let solved = solved.collect::<Result<Vec<Mat<f64>>, IdentifyError>>()?;
        Ok(self.measured(&[solved], &all_of(near.len())).into_iter().next().flatten())
    }
}
