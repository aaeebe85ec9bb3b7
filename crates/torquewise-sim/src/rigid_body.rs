//! Torque, mass matrix, energy and acceleration of rigid bodies and their rotors.

use crate::{Arm, Result, SimError, check_joints};
use faer::linalg::cholesky::llt::factor::LltError;
use faer::linalg::solvers::Solve;
use faer::{ColRef, Mat, Side};
use torquewise_rigid::{MotionState, Moved};

/// Equations of motion, method.md (1). Slices hold n numbers: `q` \[rad\], `dq` \[rad/s\], `ddq`
/// \[rad/s²\], `tau` \[N·m\]; but for [`Arm::forward_dynamics`], one of another length panics.
impl Arm {
    /// Joint torque that makes the arm move \[N·m\], n: τ = M(q) q̈ + C(q, q̇) q̇ + G(q).
    ///
    /// Source: the recursion of Luh, Walker and Paul (1980). Checked against:
    /// `tests/sim/oracles.rs`, `tests/sim/identities.rs`.
    pub fn inverse_dynamics(&self, q: &[f64], dq: &[f64], ddq: &[f64]) -> Vec<f64> {
        let mut tau = vec![0.0; self.n_joints()];
        self.load(MotionState { q, dq, ddq }, &mut Moved::default(), &mut tau);
        tau
    }

    /// [`Arm::inverse_dynamics`] into `tau`, with the bodies left in `moved` as they move.
    pub(crate) fn load(
        &self,
        state: MotionState<'_, f64>,
        moved: &mut Moved<f64>,
        tau: &mut [f64],
    ) {
        let MotionState { q, dq, ddq } = state;
        self.check_lengths(&[("q", q), ("dq", dq), ("ddq", ddq), ("tau", tau)]);
        self.kinematics.move_into(state, moved);
        moved.torque(&self.inertial, tau);
        for ((tau, ddq), joint) in tau.iter_mut().zip(ddq).zip(&self.joints) {
            *tau += joint.rotor * ddq;
        }
    }

    /// Torque that holds the arm still against gravity \[N·m\], n: G(q) = ∂V/∂q.
    pub fn gravity_torque(&self, q: &[f64]) -> Vec<f64> {
        let still = vec![0.0; self.n_joints()];
        self.inverse_dynamics(q, &still, &still)
    }

    /// Joint-space inertia M(q) \[kg·m²\], n×n, symmetric: what τ answers to q̈.
    ///
    /// Source: Walker and Orin (1982). Checked against: `tests/sim/identities.rs`.
    pub fn mass_matrix(&self, q: &[f64]) -> Mat<f64> {
        self.check_lengths(&[("q", q)]);
        let mut moved = Moved::default();
        self.kinematics.place_into(q, &mut moved);
        self.mass_matrix_of(&moved)
    }

    /// [`Arm::mass_matrix`] where the bodies are.
    fn mass_matrix_of(&self, moved: &Moved<f64>) -> Mat<f64> {
        let mut mass = Mat::zeros(self.n_joints(), self.n_joints());
        moved.mass_matrix(&self.inertial, |i, j, value| {
            (mass[(i, j)], mass[(j, i)]) = (value, value);
        });
        for (i, joint) in self.joints.iter().enumerate() {
            mass[(i, i)] += joint.rotor;
        }
        mass
    }

    /// Acceleration \[rad/s²\], n, that a torque causes: M(q) q̈ = τ − C(q, q̇) q̇ − G(q).
    ///
    /// Source: Cholesky. Checked against: `tests/sim/identities.rs`.
    ///
    /// # Errors
    /// [`SimError::JointCount`] for a slice of another length than n;
    /// [`SimError::Massless`] if a joint moves nothing that has mass or inertia.
    pub fn forward_dynamics(&self, q: &[f64], dq: &[f64], tau: &[f64]) -> Result<Vec<f64>> {
        let n = self.n_joints();
        for (what, values) in [("q", q), ("dq", dq), ("tau", tau)] {
            check_joints(what, values.len(), n)?;
        }
        let (ddq, mut bias, mut moved) = (vec![0.0; n], vec![0.0; n], Moved::default());
        self.load(MotionState { q, dq, ddq: &ddq }, &mut moved, &mut bias);
        let rest = Mat::from_fn(n, 1, |i, _| tau[i] - bias[i]);
        let factor = self
            .mass_matrix_of(&moved)
            .llt(Side::Lower)
            .map_err(|LltError::NonPositivePivot { index }| SimError::Massless { joint: index })?;
        Ok(factor.solve(&rest).col_as_slice(0).to_vec())
    }

    /// Kinetic energy T = ½ q̇ᵀ M(q) q̇ \[J\].
    pub fn kinetic_energy(&self, q: &[f64], dq: &[f64]) -> f64 {
        self.check_lengths(&[("q", q), ("dq", dq)]);
        let mass = self.mass_matrix(q);
        let velocity = ColRef::from_slice(dq);
        velocity.transpose() * &mass * velocity / 2.0
    }

    /// Potential energy V(q) = −Σ mass · gravity · height vector \[J\], 0 at the world's origin.
    ///
    /// Checked against: `tests/sim/identities.rs`.
    pub fn potential_energy(&self, q: &[f64]) -> f64 {
        self.check_lengths(&[("q", q)]);
        self.kinematics.potential_energy(q, &self.inertial)
    }

    /// Calls are by slice for speed, so a wrong length is a mistake of the caller's code.
    fn check_lengths(&self, signals: &[(&str, &[f64])]) {
        for (signal, values) in signals {
            let (n, found) = (self.n_joints(), values.len());
            assert!(found == n, "{signal} holds {found} numbers, expected {n}: one per joint");
        }
    }
}

#[cfg(test)]
mod tests;
