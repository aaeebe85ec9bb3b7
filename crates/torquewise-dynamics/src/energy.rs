//! Arm, q, q̇ → T and V: the energy that torques put in and take out.
#![expect(non_snake_case, reason = "frames are written quantity_fromTo, as in `spatial`")]

use crate::arm::Arm;
use crate::spatial::Pose;
use nalgebra::Vector3;

impl Arm {
    /// Kinetic energy T = ½ q̇ᵀ M(q) q̇, summed body by body from their velocities.
    ///
    /// - `q` \[rad\], `dq` \[rad/s\]: n each
    /// - returns: T \[J\]
    ///
    /// Checked against: `tests/identities.rs`.
    ///
    /// # Panics
    /// If a slice does not hold n numbers.
    pub fn kinetic_energy(&self, q: &[f64], dq: &[f64]) -> f64 {
        self.check_lengths(&[("q", q), ("dq", dq)]);
        let (mut w, mut v) = (Vector3::zeros(), Vector3::zeros());
        let mut energy = 0.0;
        for ((joint, &q), &dq) in self.chain().iter().zip(q).zip(dq) {
            let X_PJ = joint.pose(q);
            v = X_PJ.R_AB.tr_mul(&(v + w.cross(&X_PJ.p_AB)));
            w = X_PJ.R_AB.tr_mul(&w) + joint.axis.into_inner() * dq;
            let body = &joint.body;
            let v_com = v + w.cross(&body.com);
            energy += body.mass * v_com.norm_squared() + w.dot(&(body.inertia * w));
            energy += joint.rotor * dq * dq;
        }
        energy / 2.0
    }

    /// Potential energy V(q) = −Σ mass · gravity · height vector, 0 at the world's origin.
    ///
    /// - `q` \[rad\]: n
    /// - returns: V \[J\]
    ///
    /// Checked against: `tests/identities.rs`.
    ///
    /// # Panics
    /// If `q` does not hold n numbers.
    pub fn potential_energy(&self, q: &[f64]) -> f64 {
        self.check_lengths(&[("q", q)]);
        let gravity = self.gravity_vector();
        let mut X_WJ = Pose::identity();
        let mut energy = 0.0;
        for (joint, &q) in self.chain().iter().zip(q) {
            X_WJ = X_WJ * joint.pose(q);
            energy -= joint.body.mass * gravity.dot(&joint.body.seen_from(&X_WJ).com);
        }
        energy
    }
}
