//! Levenberg–Marquardt on the geometry, with the inertial parameters projected out (E8).

use crate::inertial_fit::scale_rows;
use crate::recursion::{Lanes, MOST_JOINTS, each_four};
use crate::rows::put;
use crate::search::{SearchStage, SearchWatch, tell};
use crate::{ChainError, ChainRows, Geometry, InertialFit, Moved, PER_BODY, Result, UsualArm};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use simba::simd::SimdValue;

/// How a geometry is fitted.
#[derive(Clone, Debug)]
pub(crate) struct Target<'a> {
    pub(crate) rows: &'a ChainRows,
    /// One over the noise of each joint, n.
    pub(crate) weights: &'a [f64],
    /// Ridge of the masses, relative to the mean square of a column.
    pub(crate) ridge: f64,
    /// What the geometry is held to, and how strongly: the mean square that its precision counts.
    pub(crate) usual: UsualArm,
    pub(crate) strength: f64,
}

/// Longest step of a parameter in one round: rad or m.
const LONGEST: f64 = 0.5;
/// A round that gains less than this part of the cost is the last.
const LEAST_GAIN: f64 = 1e-4;
/// Trials of a round.
const TRIALS: usize = 6;

/// Change of the weighted torque per unit of each free parameter, the masses held, (m·n)×g.
///
/// - `masses`: inertial parameters of the bodies, 10 each, and whatever comes after them
pub(crate) fn changes(
    (rows, weights): (&ChainRows, &[f64]),
    geometry: &Geometry,
    masses: &[f64],
    free: &[usize],
) -> Mat<f64> {
    let (m, n) = (rows.len(), rows.n_joints());
    let inertial = &masses[..PER_BODY * n];
    let kinematics = rows.kinematics(geometry);
    let derivatives = geometry.derivatives();
    let (mut moved, mut torque) = (Moved::default(), [Lanes::splat(0.0); MOST_JOINTS]);
    let mut changes = Mat::zeros(m * n, free.len());
    each_four(n, rows.signals(), |state, first, count| {
        kinematics.move_into(state, &mut moved);
        moved.torque(inertial, &mut torque[..n]);
        for (column, &parameter) in free.iter().enumerate() {
            moved.geometry_derivative(&derivatives[parameter], &mut torque[..n]);
            for (joint, &change) in torque[..n].iter().enumerate() {
                put(changes.col_as_slice_mut(column), (joint * m + first, count), change);
            }
        }
    });
    scale_rows(&mut changes, &rows.counted(weights));
    changes
}

impl Target<'_> {
    pub(crate) fn fit(&self, geometry: &Geometry) -> Result<InertialFit> {
        let mut fitted = InertialFit::fit(geometry, self.rows, self.weights, self.ridge)?;
        fitted.cost += self.strength * self.usual.cost(geometry);
        if fitted.cost.is_finite() { Ok(fitted) } else { Err(ChainError::Singular) }
    }

    /// Improves the free parameters of a geometry in at most `rounds` rounds.
    ///
    /// The masses follow every step (variable projection, the approximation of Kaufman), so that
    /// only the geometry is searched.
    ///
    /// Source: G. Golub, V. Pereyra, SIAM J. Numer. Anal. 10 (1973); L. Kaufman, BIT 15 (1975).
    pub(crate) fn descend(
        &self,
        start: &Geometry,
        free: &[usize],
        rounds: usize,
        watch: SearchWatch<'_>,
    ) -> Result<InertialFit> {
        let mut best = self.fit(start)?;
        let size = self.rows.torque.len() as f64;
        let mut damping = 1e-2;
        for _ in 0..rounds {
            tell(watch, SearchStage::Round)?;
            let changes =
                changes((self.rows, self.weights), &best.geometry, &best.coefficients, free);
            let mut curvature = best.projected(&changes);
            let mut slope = vec![0.0; free.len()];
            for (j, &parameter) in free.iter().enumerate() {
                let stiffness = size * self.strength * self.usual.precision[parameter];
                curvature[(j, j)] += stiffness;
                let usual = self.usual.parameters[parameter];
                let apart = best.geometry.parameters()[parameter] - usual;
                let column = changes.col_as_slice(j).iter();
                let falls: f64 = column.zip(&best.residual).map(|(d, r)| d * r).sum();
                slope[j] = falls - stiffness * apart;
            }
            let before = best.cost;
            let lowered = self.step(&mut best, free, (&curvature, &slope), &mut damping);
            if !lowered || before - best.cost < LEAST_GAIN * before {
                break;
            }
        }
        Ok(best)
    }

    /// Takes the longest step that lowers the cost; false if none does.
    fn step(
        &self,
        best: &mut InertialFit,
        free: &[usize],
        (curvature, slope): (&Mat<f64>, &[f64]),
        damping: &mut f64,
    ) -> bool {
        let largest = (0..free.len()).fold(0.0_f64, |most, j| most.max(curvature[(j, j)]));
        for _ in 0..TRIALS {
            let mut damped = curvature.clone();
            for j in 0..free.len() {
                damped[(j, j)] += *damping * curvature[(j, j)].max(1e-6 * largest);
            }
            if let Ok(factor) = damped.llt(Side::Lower) {
                let step = factor.solve(faer::ColRef::from_slice(slope));
                let longest = step.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
                let share = if longest > LONGEST { LONGEST / longest } else { 1.0 };
                let mut geometry = best.geometry.clone();
                for (&parameter, x) in free.iter().zip(step.iter()) {
                    geometry.parameters[parameter] += share * x;
                }
                if let Ok(found) = self.fit(&geometry)
                    && found.cost < best.cost
                {
                    *best = found;
                    *damping = (*damping / 5.0).max(1e-9);
                    return true;
                }
            }
            *damping *= 5.0;
        }
        false
    }
}
