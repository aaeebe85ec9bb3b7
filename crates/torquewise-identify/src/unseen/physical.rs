//! Held-out error of a physical arm: the parameters of each trial are held to what those of the whole
//! fit were held to (E14).

use super::{Errors, HeldOut, Sums, Unseen};
use crate::estimate::{STRENGTH, prior};
use crate::{Linearisation, Sizes};
use faer::Mat;
use rayon::prelude::*;
use torquewise_rigid::UsualArm;
use torquewise_rigid::feasible::{Prior, Quadratic, minimise};

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
    /// The priors of an arm, linearised there.
    ///
    /// - `prior_rows`: rows that the prior counts as
    pub(crate) fn of(at: &Linearisation, sizes: &Sizes, prior_rows: f64) -> Self {
        let (prior, mut start) = prior(at, sizes);
        start.truncate(at.linear.len());
        let strength = STRENGTH * prior_rows;
        let (usual, own) = (UsualArm::near(&at.geometry), at.geometry.parameters());
        let pull = |&k: &usize| (prior_rows * usual.precision[k], usual.parameters[k] - own[k]);
        let pulls: Vec<(f64, f64)> = at.free.iter().map(pull).collect();
        start.resize(start.len() + pulls.len(), 0.0);
        Self { prior, strength, pulls, start }
    }

    /// The best parameters of normal equations of a part of the rows; nothing where there are none.
    fn best(&self, mut gram: Mat<f64>, right: &Mat<f64>, part: f64) -> Option<Mat<f64>> {
        let mut right: Vec<f64> = right.col(0).iter().copied().collect();
        let first = right.len() - self.pulls.len();
        for (k, (stiffness, rest)) in (first..).zip(&self.pulls) {
            gram[(k, k)] += part * stiffness;
            right[k] += part * stiffness * rest;
        }
        let cost = Quadratic { hessian: &gram, right: &right };
        // From the best of all rows, what is held out would be known.
        let x = minimise(cost, &self.prior, self.strength, &self.start).ok()?;
        Some(Mat::from_fn(x.len(), 1, |k, _| x[k]))
    }
}

impl Unseen<'_> {
    /// What all columns, the parameters of a physical arm, leave of the first target; nothing where a
    /// trial cannot be solved.
    pub(crate) fn physical_errors(&self, held_to: &HeldTo) -> Option<Errors> {
        let (gram, right) = &self.all;
        let rows = self.joints.first().map_or(0, |joint| joint.weights.len()) as f64;
        let trial = |((own_gram, own_right), block): (&Sums, &HeldOut)| {
            let part = 1.0 - block.around.len() as f64 / rows;
            held_to.best(gram - own_gram, &(right - own_right), part)
        };
        let solved = self.around.par_iter().zip(self.blocks).map(trial);
        let solved = solved.collect::<Option<Vec<Mat<f64>>>>()?;
        let all: Vec<usize> = (0..gram.ncols()).collect();
        self.measured(&[solved], &all).into_iter().next().flatten()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use torquewise_rigid::inertia::plain_link;

    #[test]
    fn a_trial_is_held_as_strongly_as_its_part_of_the_rows_says() {
        let link = |mass: f64| plain_link(mass, &nalgebra::Vector3::new(0.2, 0.0, 0.0), 0.1);
        let (nominal, told) = (link(2.0), link(3.0));
        let held_to = |strength: f64| HeldTo {
            prior: Prior { bodies: vec![nominal], ..Prior::default() },
            strength,
            pulls: vec![(30.0, -0.5)],
            start: nominal.iter().copied().chain([0.0]).collect(),
        };
        // Rows that tell a heavier link, and a step of the geometry of 1.
        let gram = Mat::from_fn(11, 11, |i, j| if i == j { 10.0 } else { 0.0 });
        let right = Mat::from_fn(11, 1, |k, _| 10.0 * told.get(k).copied().unwrap_or(1.0));
        let best =
            |strength: f64, part: f64| held_to(strength).best(gram.clone(), &right, part).unwrap();

        let (weak, strong) = (best(1e-7, 1.0), best(1e7, 0.5));

        assert!((weak[(0, 0)] - 3.0).abs() < 1e-3, "{}", weak[(0, 0)]);
        assert!((strong[(0, 0)] - 2.0).abs() < 1e-3, "{}", strong[(0, 0)]);
        // (g x + part S r) / (g + part S), whatever the strength of the other prior.
        assert!((weak[(10, 0)] - (10.0 - 15.0) / 40.0).abs() < 1e-9, "{}", weak[(10, 0)]);
        assert!((strong[(10, 0)] - (10.0 - 7.5) / 25.0).abs() < 1e-9, "{}", strong[(10, 0)]);
    }
}
