//! Normal equations of a pass, in the units of the parameters (E11).

use super::linearisation::Linearisation;
use faer::{ColRef, Mat};
use torquewise_regression::noise_correction::corrected;
use torquewise_rigid::UsualArm;
use torquewise_rigid::feasible::Quadratic;

/// Price of a step, relative to the diagonal of the normal equations.
const ROUNDING: f64 = 1e-11;

pub(super) struct Equations {
    pub(super) hessian: Mat<f64>,
    pub(super) right: Vec<f64>,
    /// Sum of squares where they were linearised.
    squares: f64,
}

impl Equations {
    pub(super) fn new(gram: &Mat<f64>, bias: &Mat<f64>, at: &Linearisation) -> Self {
        let p = at.n_parameters();
        // Sums that a correction cannot be told from rounding in are taken as they are.
        let corrected = corrected(gram, bias).unwrap_or_else(|_| gram.clone());
        // Where torque tells nothing, the difference of two rounded matrices may be negative, and
        // nothing would hold the parameters: a step has this small price of its own.
        let own = |i: usize, j: usize| if i == j { ROUNDING * gram[(j, j)] } else { 0.0 };
        let hessian = Mat::from_fn(p, p, |i, j| {
            (corrected[(i, j)] + own(i, j)) / (at.scales[i] * at.scales[j])
        });
        let known = &hessian * ColRef::from_slice(&at.parameters());
        let right = (0..p).map(|j| corrected[(p, j)] / at.scales[j] + known[j]).collect();
        Self { hessian, right, squares: corrected[(p, p)] }
    }

    /// Half the sum of squares at parameters of the linearisation, its noise taken out.
    pub(super) fn cost(&self, at: &Linearisation, parameters: &[f64]) -> f64 {
        let before = at.parameters();
        let step: Vec<f64> = parameters.iter().zip(&before).map(|(x, b)| x - b).collect();
        let known = &self.hessian * ColRef::from_slice(&before);
        let bent = &self.hessian * ColRef::from_slice(&step);
        let change = |k: usize| step[k] * (0.5 * bent[k] - (self.right[k] - known[k]));
        0.5 * self.squares + (0..step.len()).map(change).sum::<f64>()
    }

    /// The equations of some parameters, the others as they were.
    ///
    /// - `prior`: rows that the prior of right angles counts as
    /// - `damping`: what a step of the geometry costs, in parts of its curvature
    pub(super) fn of(
        &self,
        active: &[usize],
        at: &Linearisation,
        (prior, damping): (f64, f64),
    ) -> Self {
        let mut held = at.parameters();
        for &k in active {
            held[k] = 0.0;
        }
        let known = &self.hessian * ColRef::from_slice(&held);
        let count = active.len();
        let mut own = Self {
            hessian: Mat::from_fn(count, count, |i, j| self.hessian[(active[i], active[j])]),
            right: active.iter().map(|&k| self.right[k] - known[k]).collect(),
            squares: self.squares,
        };
        let linear = at.linear.len();
        let (usual, geometry) = (UsualArm::near(&at.geometry), at.geometry.parameters());
        for (place, &k) in active.iter().enumerate().filter(|(_, k)| **k >= linear) {
            let stiffness = prior * usual.precision[k - linear];
            let price = damping * self.hessian[(k, k)];
            own.hessian[(place, place)] += stiffness + price;
            own.right[place] +=
                stiffness * usual.parameters[k - linear] + price * geometry[k - linear];
        }
        own
    }

    pub(super) fn quadratic(&self) -> Quadratic<'_> {
        Quadratic { hessian: &self.hessian, right: &self.right }
    }
}

/// What the prior of the geometry costs at parameters.
pub(super) fn cost_of_pull(at: &Linearisation, parameters: &[f64], prior: f64) -> f64 {
    let (linear, usual) = (at.linear.len(), UsualArm::near(&at.geometry));
    let cost = |&k: &usize| {
        let apart = parameters[linear + k] - usual.parameters[k];
        0.5 * prior * usual.precision[k] * apart * apart
    };
    at.free.iter().map(cost).sum()
}
