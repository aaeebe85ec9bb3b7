//! Torque, regressor, mass matrix and energy of rigid bodies and their rotors.

use crate::arm::Arm;
use faer::{ColRef, Mat};
use torquewise_rigid::recursion::PER_BODY;
use torquewise_rigid::{Moved, State};

impl Arm {
    /// Joint torque that makes the arm move: τ = M(q) q̈ + C(q, q̇) q̇ + G(q).
    ///
    /// - `q` \[rad\], `dq` \[rad/s\], `ddq` \[rad/s²\]: n each
    /// - returns: τ \[N·m\], n
    ///
    /// Source: method.md (1), by the recursion of Luh, Walker and Paul (1980). Checked against:
    /// `tests/dynamics/oracles.rs`, `tests/dynamics/identities.rs`.
    ///
    /// # Panics
    /// If a slice does not hold n numbers.
    pub fn inverse_dynamics(&self, q: &[f64], dq: &[f64], ddq: &[f64]) -> Vec<f64> {
        let mut tau = vec![0.0; self.n_joints()];
        self.inverse_dynamics_into(q, dq, ddq, &mut tau);
        tau
    }

    /// [`Arm::inverse_dynamics`] into the caller's buffer `tau` \[N·m\], n.
    ///
    /// # Panics
    /// If a slice does not hold n numbers.
    pub fn inverse_dynamics_into(&self, q: &[f64], dq: &[f64], ddq: &[f64], tau: &mut [f64]) {
        self.load(State { q, dq, ddq }, &mut Moved::default(), tau);
    }

    /// [`Arm::inverse_dynamics_into`] with the bodies left in `moved` as they move.
    pub(crate) fn load(&self, state: State<'_, f64>, moved: &mut Moved<f64>, tau: &mut [f64]) {
        let State { q, dq, ddq } = state;
        self.check_lengths(&[("q", q), ("dq", dq), ("ddq", ddq), ("tau", tau)]);
        self.kinematics().inverse_dynamics(state, self.inertial(), moved, tau);
        for ((tau, ddq), joint) in tau.iter_mut().zip(ddq).zip(self.chain()) {
            *tau += joint.rotor * ddq;
        }
    }

    /// Torque that holds the arm still against gravity: G(q) = ∂V/∂q.
    ///
    /// - `q` \[rad\]: n
    /// - returns: G \[N·m\], n
    ///
    /// # Panics
    /// If `q` does not hold n numbers.
    pub fn gravity_torque(&self, q: &[f64]) -> Vec<f64> {
        let still = vec![0.0; self.n_joints()];
        self.inverse_dynamics(q, &still, &still)
    }

    /// Centrifugal and Coriolis torque C(q, q̇) q̇, without gravity.
    ///
    /// - `q` \[rad\], `dq` \[rad/s\]: n each
    /// - returns: C q̇ \[N·m\], n
    ///
    /// # Panics
    /// If a slice does not hold n numbers.
    pub fn coriolis_torque(&self, q: &[f64], dq: &[f64]) -> Vec<f64> {
        self.check_lengths(&[("q", q), ("dq", dq)]);
        let (ddq, mut tau) = (vec![0.0; self.n_joints()], vec![0.0; self.n_joints()]);
        let weightless = self.kinematics().clone().without_gravity();
        let state = State { q, dq, ddq: &ddq };
        weightless.inverse_dynamics(state, self.inertial(), &mut Moved::default(), &mut tau);
        tau
    }

    /// Y of τ = Y(q, q̇, q̈) π: what each inertial parameter of each body adds to each torque.
    ///
    /// - `q` \[rad\], `dq` \[rad/s\], `ddq` \[rad/s²\]: n each
    /// - returns: n×10n, ten columns for each body
    ///
    /// The masses of the arm are not used, its kinematics are. Rotors are not among the parameters.
    ///
    /// Source: C. Atkeson, C. An, J. Hollerbach, Int. J. Robotics Research 5 (1986). Checked
    /// against: [`Arm::inverse_dynamics`].
    ///
    /// # Panics
    /// If a slice does not hold n numbers.
    pub fn regressor(&self, q: &[f64], dq: &[f64], ddq: &[f64]) -> Mat<f64> {
        self.check_lengths(&[("q", q), ("dq", dq), ("ddq", ddq)]);
        let mut regressor = Mat::zeros(self.n_joints(), PER_BODY * self.n_joints());
        let mut moved = Moved::default();
        self.kinematics().move_into(State { q, dq, ddq }, &mut moved);
        moved.regressor(|joint, parameter, value| regressor[(joint, parameter)] = value);
        regressor
    }

    /// The inertial parameters π of all bodies, 10n, in the order of [`Arm::regressor`]: of each
    /// body m, m·c (3), and the moments about the origin of its frame, xx, yy, zz, xy, xz, yz.
    ///
    /// The frame of a body turns with its joint about z.
    pub fn inertial_parameters(&self) -> Vec<f64> {
        self.inertial().to_vec()
    }

    /// Joint-space inertia M(q), symmetric: what τ answers to q̈.
    ///
    /// - `q` \[rad\]: n
    /// - returns: M \[kg·m²\], n×n
    ///
    /// Source: method.md (1), by Walker and Orin (1982). Checked against:
    /// `tests/dynamics/identities.rs`.
    ///
    /// # Panics
    /// If `q` does not hold n numbers.
    pub fn mass_matrix(&self, q: &[f64]) -> Mat<f64> {
        self.check_lengths(&[("q", q)]);
        let mut moved = Moved::default();
        self.kinematics().place_into(q, &mut moved);
        self.mass_matrix_of(&moved)
    }

    /// [`Arm::mass_matrix`] where the bodies are.
    pub(crate) fn mass_matrix_of(&self, moved: &Moved<f64>) -> Mat<f64> {
        let mut mass = Mat::zeros(self.n_joints(), self.n_joints());
        moved.mass_matrix(self.inertial(), |i, j, value| {
            (mass[(i, j)], mass[(j, i)]) = (value, value);
        });
        for (i, joint) in self.chain().iter().enumerate() {
            mass[(i, i)] += joint.rotor;
        }
        mass
    }

    /// Kinetic energy T = ½ q̇ᵀ M(q) q̇.
    ///
    /// - `q` \[rad\], `dq` \[rad/s\]: n each
    /// - returns: T \[J\]
    ///
    /// # Panics
    /// If a slice does not hold n numbers.
    pub fn kinetic_energy(&self, q: &[f64], dq: &[f64]) -> f64 {
        self.check_lengths(&[("q", q), ("dq", dq)]);
        let mass = self.mass_matrix(q);
        let velocity = ColRef::from_slice(dq);
        velocity.transpose() * &mass * velocity / 2.0
    }

    /// Potential energy V(q) = −Σ mass · gravity · height vector, 0 at the world's origin.
    ///
    /// - `q` \[rad\]: n
    /// - returns: V \[J\]
    ///
    /// Checked against: `tests/dynamics/identities.rs`.
    ///
    /// # Panics
    /// If `q` does not hold n numbers.
    pub fn potential_energy(&self, q: &[f64]) -> f64 {
        self.check_lengths(&[("q", q)]);
        self.kinematics().potential_energy(q, self.inertial())
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
