//! Sums of a pass → normal equations in the units of the parameters (E11).

use super::linearisation::Linearisation;
use crate::error::IdentifyError;
use faer::{ColRef, Mat};
use torquewise_rigid::Geometry;
use torquewise_rigid::feasible::{Prior, Quadratic, curvature};
use torquewise_rigid::search::{pull_stiffness, right_angles_near};
use torquewise_sparse::normal_sums::corrected;

/// Price of a step, relative to the diagonal of the normal equations.
const ROUNDING: f64 = 1e-11;
/// Ridge of the unconstrained optimum, relative to the curvature.
const RIDGE: f64 = 1e-9;

/// The normal equations in the units of the parameters.
pub(super) struct Equations {
    pub(super) hessian: Mat<f64>,
    pub(super) right: Vec<f64>,
}

impl Equations {
    pub(super) fn new(
        gram: &Mat<f64>,
        bias: &Mat<f64>,
        at: &Linearisation,
    ) -> Result<Self, IdentifyError> {
        let p = at.n_parameters();
        let part = |x: &Mat<f64>| x.submatrix(0, 0, p, p).to_owned();
        let corrected = corrected(&part(gram), &part(bias))?;
        // Where torque tells nothing, the difference of two rounded matrices may be negative, and
        // nothing would hold the parameters: a step has this small price of its own.
        let own = |i: usize, j: usize| if i == j { ROUNDING * gram[(j, j)] } else { 0.0 };
        let hessian = Mat::from_fn(p, p, |i, j| {
            (corrected[(i, j)] + own(i, j)) / (at.scales[i] * at.scales[j])
        });
        let known = &hessian * ColRef::from_slice(&at.parameters());
        let right =
            (0..p).map(|j| (gram[(p, j)] - bias[(p, j)]) / at.scales[j] + known[j]).collect();
        Ok(Self { hessian, right })
    }

    /// The equations of some parameters, the others as they were.
    ///
    /// - `pull`: equations that a pull of the geometry to right angles counts as
    pub(super) fn of(&self, active: &[usize], at: &Linearisation, pull: f64) -> Self {
        let mut held = at.parameters();
        for &k in active {
            held[k] = 0.0;
        }
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

    pub(super) fn quadratic(&self) -> Quadratic<'_> {
        Quadratic { hessian: &self.hessian, right: &self.right }
    }

    /// The optimum without physics; what the log does not tell is held by a small ridge.
    pub(super) fn unconstrained(&self) -> Result<Vec<f64>, IdentifyError> {
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
