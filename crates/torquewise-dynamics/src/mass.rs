//! Arm, q → M(q): composite rigid bodies, welded from the tip inward.
#![expect(non_snake_case, reason = "frames are written quantity_fromTo, as in `spatial`")]

use crate::arm::Arm;
use crate::spatial::{Body, Pose};
use faer::Mat;

impl Arm {
    /// Joint-space inertia M(q), symmetric: what τ answers to q̈.
    ///
    /// - `q` \[rad\]: n
    /// - returns: M \[kg·m²\], n×n
    ///
    /// Column j is the torque when only joint j accelerates, at rest and without gravity: all
    /// beyond it turns as one body, and the joints before it hold that body's force.
    ///
    /// Source: method.md (1), by Walker and Orin (1982). Checked against:
    /// `tests/identities.rs`.
    ///
    /// # Panics
    /// If `q` does not hold n numbers.
    pub fn mass_matrix(&self, q: &[f64]) -> Mat<f64> {
        self.check_lengths(&[("q", q)]);
        let n = self.n_joints();
        let chain = self.chain();
        let poses: Vec<Pose> = chain.iter().zip(q).map(|(joint, &q)| joint.pose(q)).collect();

        let mut mass = Mat::zeros(n, n);
        let mut beyond = Body::none();
        for j in (0..n).rev() {
            let composite = chain[j].body.welded_to(&beyond);
            let axis = chain[j].axis.into_inner();
            let mut force = composite.mass * axis.cross(&composite.com);
            let mut moment = composite.inertia * axis + composite.com.cross(&force);
            mass[(j, j)] = axis.dot(&moment) + chain[j].rotor;
            for i in (0..j).rev() {
                let X_PJ = &poses[i + 1];
                force = X_PJ.R_AB * force;
                moment = X_PJ.R_AB * moment + X_PJ.p_AB.cross(&force);
                mass[(i, j)] = chain[i].axis.dot(&moment);
                mass[(j, i)] = mass[(i, j)];
            }
            beyond = composite.seen_from(&poses[j]);
        }
        mass
    }
}
