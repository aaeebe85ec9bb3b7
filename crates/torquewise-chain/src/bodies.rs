//! Geometry, one state → how the bodies of a chain move, and the torques that moving them takes.

use crate::geometry::{Geometry, Placement};
use nalgebra::{Matrix3, Vector3};

/// Inertial parameters of a body: m, m·c (3), and the moments about the origin of its frame in the
/// order xx, yy, zz, xy, xz, yz.
pub(crate) const PER_BODY: usize = 10;

/// A geometry ready to be moved.
#[derive(Clone, Debug)]
pub(crate) struct Bodies {
    placements: Vec<Placement>,
    gravity: Vector3<f64>,
}

/// One body at one instant, all vectors in its own frame.
#[derive(Clone, Copy, Debug, Default)]
struct Body {
    /// Turns components of this frame into those of the one before.
    rotation: Matrix3<f64>,
    /// Its origin in the frame before.
    origin: Vector3<f64>,
    /// ω
    rate: Vector3<f64>,
    /// ω̇
    turning: Vector3<f64>,
    /// Acceleration of the origin less gravity.
    pull: Vector3<f64>,
}

/// Joints of an arm at most.
pub(crate) const MOST_JOINTS: usize = 16;

/// q, q̇ and q̈ of one instant, n each.
#[derive(Clone, Copy, Debug)]
pub(crate) struct State<'a> {
    pub(crate) q: &'a [f64],
    pub(crate) dq: &'a [f64],
    pub(crate) ddq: &'a [f64],
}

impl Bodies {
    pub(crate) fn new(geometry: &Geometry) -> Self {
        Self { placements: geometry.placements(), gravity: geometry.gravity().into() }
    }

    /// The same bodies where nothing weighs.
    pub(crate) fn without_gravity(self) -> Self {
        Self { gravity: Vector3::zeros(), ..self }
    }

    pub(crate) fn placements(&self) -> &[Placement] {
        &self.placements
    }

    pub(crate) fn gravity(&self) -> &Vector3<f64> {
        &self.gravity
    }

    pub(crate) fn len(&self) -> usize {
        self.placements.len()
    }

    /// Outward: the motion of each body.
    fn moved(&self, state: State<'_>) -> [Body; MOST_JOINTS] {
        let mut bodies = [Body::default(); MOST_JOINTS];
        let mut before = Body { pull: -self.gravity, ..Body::default() };
        for (joint, placement) in self.placements.iter().enumerate() {
            let (sin, cos) = state.q[joint].sin_cos();
            let about_z = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
            let rotation = placement.rotation * about_z;
            let origin = placement.origin;
            let spin = Vector3::new(0.0, 0.0, state.dq[joint]);
            let carried = rotation.tr_mul(&before.rate);
            let rate = carried + spin;
            let turning = rotation.tr_mul(&before.turning)
                + carried.cross(&spin)
                + Vector3::new(0.0, 0.0, state.ddq[joint]);
            let pull = before.pull
                + before.turning.cross(&origin)
                + before.rate.cross(&before.rate.cross(&origin));
            before = Body { rotation, origin, rate, turning, pull: rotation.tr_mul(&pull) };
            bodies[joint] = before;
        }
        bodies
    }

    /// Torque of each joint per unit of each inertial parameter: `put(joint, parameter, value)` for
    /// all parameters of the bodies from the joint outward; those before it do not load it.
    pub(crate) fn columns(&self, state: State<'_>, mut put: impl FnMut(usize, usize, f64)) {
        let bodies = self.moved(state);
        for joint in 0..self.len() {
            // The axis of the joint, and the arm from it to the body, in the frame of the body.
            let (mut axis, mut arm) = (Vector3::z(), Vector3::zeros());
            for (place, body) in bodies.iter().enumerate().take(self.len()).skip(joint) {
                if place > joint {
                    axis = body.rotation.tr_mul(&axis);
                    arm = body.rotation.tr_mul(&(arm + body.origin));
                }
                for (parameter, value) in body.loads(&axis, &arm).into_iter().enumerate() {
                    put(joint, PER_BODY * place + parameter, value);
                }
            }
        }
    }

    /// Torques \[N·m\] of all joints for the inertial parameters of all bodies, 10 each: recursive
    /// Newton–Euler.
    pub(crate) fn torque(&self, state: State<'_>, inertial: &[f64], torque: &mut [f64]) {
        let bodies = self.moved(state);
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        for joint in (0..self.len()).rev() {
            let body = &bodies[joint];
            let (own_force, own_moment) = body.wrench(&inertial[PER_BODY * joint..]);
            force += own_force;
            moment += own_moment;
            torque[joint] = moment.z;
            // To the frame before.
            force = body.rotation * force;
            moment = body.rotation * moment + body.origin.cross(&force);
        }
    }
}

impl Body {
    /// Torque about `axis`, which passes `arm` before the origin, per unit of each parameter.
    fn loads(&self, axis: &Vector3<f64>, arm: &Vector3<f64>) -> [f64; PER_BODY] {
        let lever = axis.cross(arm);
        let (w, dw, a) = (&self.rate, &self.turning, &self.pull);
        // lever·(ω̇×e + ω×(ω×e)) for the three unit vectors e at once.
        let swing = lever.cross(dw) + w * w.dot(&lever) - lever * w.norm_squared();
        let first = swing + a.cross(axis);
        let u = axis.cross(w);
        [
            lever.dot(a),
            first.x,
            first.y,
            first.z,
            axis.x * dw.x + u.x * w.x,
            axis.y * dw.y + u.y * w.y,
            axis.z * dw.z + u.z * w.z,
            axis.x * dw.y + axis.y * dw.x + u.x * w.y + u.y * w.x,
            axis.x * dw.z + axis.z * dw.x + u.x * w.z + u.z * w.x,
            axis.y * dw.z + axis.z * dw.y + u.y * w.z + u.z * w.y,
        ]
    }

    /// Force and moment about the origin that its motion takes.
    fn wrench(&self, p: &[f64]) -> (Vector3<f64>, Vector3<f64>) {
        let (mass, first) = (p[0], Vector3::new(p[1], p[2], p[3]));
        let inertia = Matrix3::new(p[4], p[7], p[8], p[7], p[5], p[9], p[8], p[9], p[6]);
        let (w, dw, a) = (&self.rate, &self.turning, &self.pull);
        let force = mass * a + dw.cross(&first) + w.cross(&w.cross(&first));
        let moment = inertia * dw + w.cross(&(inertia * w)) + first.cross(a);
        (force, moment)
    }
}

#[cfg(test)]
mod tests;
