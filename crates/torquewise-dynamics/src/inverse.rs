//! Arm, q, q̇, q̈ → τ: recursive Newton–Euler, outward for motion and inward for force.
#![expect(non_snake_case, reason = "frames are written quantity_fromTo, as in `spatial`")]

use crate::arm::{Arm, Joint};
use crate::spatial::Pose;
use nalgebra::{Rotation3, Vector3};

impl Joint {
    /// Frame J at position `q`, seen from the joint before.
    pub(crate) fn pose(&self, q: f64) -> Pose {
        let turned = Rotation3::from_axis_angle(&self.axis, q);
        Pose { R_AB: self.X_PJ.R_AB * turned.matrix(), p_AB: self.X_PJ.p_AB }
    }
}

/// How a joint's frame moves, in that frame.
#[derive(Clone, Copy)]
pub(crate) struct Twist {
    /// Angular velocity \[rad/s\].
    pub(crate) w: Vector3<f64>,
    /// Angular acceleration \[rad/s²\].
    pub(crate) dw: Vector3<f64>,
    /// Acceleration of the origin \[m/s²\]; a base that falls upward stands for gravity.
    pub(crate) a: Vector3<f64>,
}

impl Twist {
    /// The base: at rest, but for gravity \[m/s²\].
    pub(crate) fn base(gravity: Vector3<f64>) -> Self {
        Self { w: Vector3::zeros(), dw: Vector3::zeros(), a: -gravity }
    }

    /// One joint outward.
    pub(crate) fn beyond(&self, joint: &Joint, X_PJ: &Pose, dq: f64, ddq: f64) -> Self {
        let into = X_PJ.R_AB.transpose();
        let (axis, p) = (joint.axis.into_inner(), X_PJ.p_AB);
        let w_parent = into * self.w;
        Self {
            w: w_parent + axis * dq,
            dw: into * self.dw + w_parent.cross(&axis) * dq + axis * ddq,
            a: into * (self.a + self.dw.cross(&p) + self.w.cross(&self.w.cross(&p))),
        }
    }
}

/// Force and moment about the joint's origin, in the joint's frame.
#[derive(Clone, Copy)]
struct Wrench {
    force: Vector3<f64>,
    moment: Vector3<f64>,
}

impl Wrench {
    /// What moves the joint's own body as `twist` says (Newton, Euler).
    fn moving(joint: &Joint, twist: &Twist) -> Self {
        let Twist { w, dw, a } = twist;
        let (c, inertia) = (joint.body.com, joint.body.inertia);
        let force = joint.body.mass * (a + dw.cross(&c) + w.cross(&w.cross(&c)));
        let moment = inertia * dw + w.cross(&(inertia * w)) + c.cross(&force);
        Self { force, moment }
    }

    /// Adds what the next joint takes.
    fn add(&mut self, next: &Self, X_PJ: &Pose) {
        let force = X_PJ.R_AB * next.force;
        self.force += force;
        self.moment += X_PJ.R_AB * next.moment + X_PJ.p_AB.cross(&force);
    }
}

impl Arm {
    /// Joint torque that makes the arm move: τ = M(q) q̈ + C(q, q̇) q̇ + G(q).
    ///
    /// - `q` \[rad\], `dq` \[rad/s\], `ddq` \[rad/s²\]: n each
    /// - returns: τ \[N·m\], n
    ///
    /// Source: method.md (1), by the recursion of Luh, Walker and Paul (1980). Checked against:
    /// `tests/oracles.rs`, `tests/identities.rs`.
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
        self.newton_euler(self.gravity_vector(), [q, dq, ddq], tau);
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
        let (unaccelerated, mut tau) = (vec![0.0; self.n_joints()], vec![0.0; self.n_joints()]);
        self.newton_euler(Vector3::zeros(), [q, dq, &unaccelerated], &mut tau);
        tau
    }

    fn newton_euler(&self, gravity: Vector3<f64>, [q, dq, ddq]: [&[f64]; 3], tau: &mut [f64]) {
        self.check_lengths(&[("q", q), ("dq", dq), ("ddq", ddq), ("tau", tau)]);

        let mut twist = Twist::base(gravity);
        let mut links = Vec::with_capacity(self.n_joints());
        for (i, joint) in self.chain().iter().enumerate() {
            let X_PJ = joint.pose(q[i]);
            twist = twist.beyond(joint, &X_PJ, dq[i], ddq[i]);
            links.push((X_PJ, Wrench::moving(joint, &twist)));
        }

        let mut next: Option<(Pose, Wrench)> = None;
        for (i, (X_PJ, mut wrench)) in links.into_iter().enumerate().rev() {
            if let Some((X_JN, taken)) = &next {
                wrench.add(taken, X_JN);
            }
            let joint = &self.chain()[i];
            tau[i] = joint.axis.dot(&wrench.moment) + joint.rotor * ddq[i];
            next = Some((X_PJ, wrench));
        }
    }

    /// Calls are by slice for speed, so a wrong length is a mistake of the caller's code.
    pub(crate) fn check_lengths(&self, signals: &[(&str, &[f64])]) {
        for (signal, values) in signals {
            let (n, found) = (self.n_joints(), values.len());
            assert!(found == n, "{signal} holds {found} numbers, expected {n}: one per joint");
        }
    }
}
