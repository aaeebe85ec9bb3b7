//! Recursive Newton–Euler for a chain of rigid bodies: torque, regressor, and how both change with
//! the geometry.
//!
//! Every crate that needs rigid-body dynamics uses this recursion. It is generic over its scalar:
//! `f64` for one state, [`Lanes`] for four states at once.

use crate::geometry::{Geometry, GeometryDerivative, Placement};
use nalgebra::{Matrix3, SimdRealField, Vector3};
use simba::simd::WideF64x4;

/// Inertial parameters of a body: m, m·c (3), and the moments about the origin of its frame in the
/// order xx, yy, zz, xy, xz, yz.
pub const PER_BODY: usize = 10;
/// Joints of an arm at most.
pub const MOST_JOINTS: usize = 16;
/// States that [`Lanes`] holds.
pub const N_LANES: usize = 4;
/// The same number of four states, for work on many rows.
pub type Lanes = WideF64x4;

/// What the recursion computes with.
pub trait Scalar: SimdRealField<Element = f64> + Copy {}
impl<T: SimdRealField<Element = f64> + Copy> Scalar for T {}

/// The joint frames of a chain and the gravity it stands in.
#[derive(Clone, Debug, PartialEq)]
pub struct Kinematics {
    placements: Vec<Placement>,
    /// \[m/s²\], in the base.
    gravity: Vector3<f64>,
}

/// q \[rad\], q̇ \[rad/s\] and q̈ \[rad/s²\] of one instant, n each.
#[derive(Clone, Copy, Debug)]
pub struct State<'a, T> {
    /// Joint positions.
    pub q: &'a [T],
    /// Joint velocities.
    pub dq: &'a [T],
    /// Joint accelerations.
    pub ddq: &'a [T],
}

/// Motion of one body, all vectors in its own frame.
#[derive(Clone, Copy, Debug)]
struct Body<T> {
    /// Turns components of this frame into those of the one before.
    rotation: Matrix3<T>,
    /// Its origin in the frame before \[m\].
    origin: Vector3<T>,
    /// Angular velocity \[rad/s\].
    omega: Vector3<T>,
    /// Angular acceleration \[rad/s²\].
    alpha: Vector3<T>,
    /// Acceleration of the origin less gravity \[m/s²\].
    acceleration: Vector3<T>,
}

/// Force \[N\] and moment \[N·m\] about the origin of a frame.
#[derive(Clone, Copy, Debug)]
struct Wrench<T> {
    force: Vector3<T>,
    moment: Vector3<T>,
}

/// Mass, first moment and rotational inertia of a body, ready for the recursion.
#[derive(Clone, Copy, Debug)]
struct Inertia<T> {
    mass: T,
    first: Vector3<T>,
    about_origin: Matrix3<T>,
}

/// The motion of all bodies at one state: what torque, regressor and derivatives start from.
#[derive(Clone, Debug)]
pub struct Moved<T> {
    bodies: Vec<Body<T>>,
    base: Body<T>,
    wrenches: Vec<Wrench<T>>,
}

fn splat<T: Scalar>(v: &Vector3<f64>) -> Vector3<T> {
    v.map(T::splat)
}

fn splat3<T: Scalar>(m: &Matrix3<f64>) -> Matrix3<T> {
    m.map(T::splat)
}

fn along_z<T: Scalar>(z: T) -> Vector3<T> {
    Vector3::new(T::zero(), T::zero(), z)
}

impl Kinematics {
    /// The frames of a geometry.
    pub fn new(geometry: &Geometry) -> Self {
        Self { placements: geometry.placements(), gravity: geometry.gravity().into() }
    }

    /// Frames given one by one; joint i turns about z of frame i.
    ///
    /// - `gravity`: \[m/s²\], in the base
    pub fn of_frames(placements: Vec<Placement>, gravity: [f64; 3]) -> Self {
        Self { placements, gravity: gravity.into() }
    }

    /// The same chain where nothing weighs.
    pub fn without_gravity(self) -> Self {
        Self { gravity: Vector3::zeros(), ..self }
    }

    /// Number of joints n.
    pub fn n_joints(&self) -> usize {
        self.placements.len()
    }

    /// Moves the bodies: the outward half of the recursion. `moved` is overwritten, so that a loop
    /// over rows allocates once.
    pub fn move_into<T: Scalar>(&self, state: State<'_, T>, moved: &mut Moved<T>) {
        moved.base = Body { acceleration: -splat(&self.gravity), ..Body::at_rest() };
        moved.bodies.clear();
        let mut before = moved.base;
        for (joint, placement) in self.placements.iter().enumerate() {
            before = before.next(placement, state.q[joint], state.dq[joint], state.ddq[joint]);
            moved.bodies.push(before);
        }
    }

    /// Torques \[N·m\] of all joints for the inertial parameters of all bodies, 10 each.
    pub fn inverse_dynamics<T: Scalar>(
        &self,
        state: State<'_, T>,
        inertial: &[f64],
        moved: &mut Moved<T>,
        torque: &mut [T],
    ) {
        self.move_into(state, moved);
        moved.torque(inertial, torque);
    }

    /// M(q) \[kg·m²\], column by column: torque per unit of each acceleration, at rest and without
    /// gravity. `put(i, j, value)` is called for i ≤ j.
    pub fn mass_matrix<T: Scalar>(
        &self,
        q: &[T],
        inertial: &[f64],
        moved: &mut Moved<T>,
        mut put: impl FnMut(usize, usize, T),
    ) {
        let n = self.n_joints();
        let rest = [T::zero(); MOST_JOINTS];
        let mut unit = [T::zero(); MOST_JOINTS];
        let mut torque = [T::zero(); MOST_JOINTS];
        for j in 0..n {
            unit[j] = T::one();
            self.move_into(State { q, dq: &rest[..n], ddq: &unit[..n] }, moved);
            // Gravity is taken back: it would need another chain.
            moved.weightless(&splat(&self.gravity));
            moved.torque(inertial, &mut torque[..n]);
            (0..=j).for_each(|i| put(i, j, torque[i]));
            unit[j] = T::zero();
        }
    }

    /// Potential energy \[J\] at q, up to a constant.
    pub fn potential_energy(&self, q: &[f64], inertial: &[f64]) -> f64 {
        let mut turned = Matrix3::identity();
        let mut origin = Vector3::zeros();
        let mut sum = Vector3::zeros();
        for (joint, placement) in self.placements.iter().enumerate() {
            let (sin, cos) = q[joint].sin_cos();
            origin += turned * placement.origin;
            turned = turned * placement.rotation * about_z(sin, cos);
            let body = &inertial[PER_BODY * joint..];
            sum += origin * body[0] + turned * Vector3::new(body[1], body[2], body[3]);
        }
        -self.gravity.dot(&sum)
    }
}

fn about_z<T: Scalar>(sin: T, cos: T) -> Matrix3<T> {
    let (zero, one) = (T::zero(), T::one());
    Matrix3::new(cos, -sin, zero, sin, cos, zero, zero, zero, one)
}

impl<T: Scalar> Default for Moved<T> {
    fn default() -> Self {
        Self { bodies: Vec::new(), base: Body::at_rest(), wrenches: Vec::new() }
    }
}

impl<T: Scalar> Moved<T> {
    /// Takes gravity \[m/s²\] back from the acceleration of every body.
    fn weightless(&mut self, gravity: &Vector3<T>) {
        let mut seen = *gravity;
        for body in &mut self.bodies {
            seen = body.rotation.tr_mul(&seen);
            body.acceleration += seen;
        }
    }

    /// The inward half of the recursion: torques \[N·m\], n.
    ///
    /// - `inertial`: inertial parameters of all bodies, 10 each
    pub fn torque(&mut self, inertial: &[f64], torque: &mut [T]) {
        self.wrenches.clear();
        let mut wrench = Wrench::none();
        for (joint, body) in self.bodies.iter().enumerate().rev() {
            wrench = wrench.plus(&body.wrench(&Inertia::of(&inertial[PER_BODY * joint..])));
            self.wrenches.push(wrench);
            torque[joint] = wrench.moment.z;
            wrench = wrench.before(body);
        }
        self.wrenches.reverse();
    }

    /// The regressor: torque of each joint per unit of each inertial parameter. Calls `put(joint,
    /// parameter, value)` for all parameters of the bodies from the joint outward; those before it
    /// do not load it.
    pub fn regressor(&self, mut put: impl FnMut(usize, usize, T)) {
        for joint in 0..self.bodies.len() {
            // The axis of the joint, and the arm from it to the body, in the frame of the body.
            let (mut axis, mut arm) = (along_z(T::one()), Vector3::zeros());
            for (k, body) in self.bodies.iter().enumerate().skip(joint) {
                if k > joint {
                    axis = body.rotation.tr_mul(&axis);
                    arm = body.rotation.tr_mul(&(arm + body.origin));
                }
                for (parameter, value) in body.loads(&axis, &arm).into_iter().enumerate() {
                    put(joint, PER_BODY * k + parameter, value);
                }
            }
        }
    }

    /// The change of all torques per unit of one parameter of the geometry, exactly: the recursion
    /// differentiated. [`Self::torque`] must have been called with the same inertial parameters.
    ///
    /// - `change`: \[N·m\] per rad or m, n
    pub fn geometry_derivative(
        &self,
        derivative: &GeometryDerivative,
        inertial: &[f64],
        change: &mut [T],
    ) {
        let moved = derivative.joint;
        let mut tangent = [Tangent::none(); MOST_JOINTS];
        for (joint, body) in self.bodies.iter().enumerate().skip(moved) {
            let before = if joint == 0 { &self.base } else { &self.bodies[joint - 1] };
            let known = if joint == moved { Tangent::none() } else { tangent[joint - 1] };
            let (rotation, origin, gravity) = if joint == moved {
                let GeometryDerivative { rotation, origin, gravity, .. } = derivative;
                (splat(rotation), splat(origin), splat(gravity))
            } else {
                (Vector3::zeros(), Vector3::zeros(), Vector3::zeros())
            };
            let known = Tangent { acceleration: known.acceleration - gravity, ..known };
            tangent[joint] = known.next(before, body, &rotation, &origin);
        }
        let mut wrench = Wrench::none();
        for (joint, body) in self.bodies.iter().enumerate().rev() {
            if joint >= moved {
                let inertia = Inertia::of(&inertial[PER_BODY * joint..]);
                wrench = wrench.plus(&tangent[joint].wrench(body, &inertia));
            }
            change[joint] = wrench.moment.z;
            wrench = wrench.before(body);
            if joint == moved {
                let carried = self.wrenches[joint].before(body);
                let rotation: Vector3<T> = splat(&derivative.rotation);
                let shift: Vector3<T> = splat(&derivative.origin);
                let force = rotation.cross(&carried.force);
                // The moment without the lever of the force turns; the lever moves with the origin.
                let turned = carried.moment - body.origin.cross(&carried.force);
                wrench.force += force;
                wrench.moment += rotation.cross(&turned)
                    + shift.cross(&carried.force)
                    + body.origin.cross(&force);
            }
        }
    }
}

impl<T: Scalar> Body<T> {
    fn at_rest() -> Self {
        let zero = Vector3::zeros();
        let rotation = Matrix3::identity();
        Self { rotation, origin: zero, omega: zero, alpha: zero, acceleration: zero }
    }

    /// The body behind the next joint.
    fn next(&self, placement: &Placement, q: T, dq: T, ddq: T) -> Self {
        let (sin, cos) = q.simd_sin_cos();
        let rotation: Matrix3<T> = splat3::<T>(&placement.rotation) * about_z(sin, cos);
        let origin: Vector3<T> = splat(&placement.origin);
        let carried: Vector3<T> = rotation.tr_mul(&self.omega);
        let omega: Vector3<T> = carried + along_z(dq);
        let alpha: Vector3<T> =
            rotation.tr_mul(&self.alpha) + carried.cross(&along_z(dq)) + along_z(ddq);
        let acceleration = self.acceleration
            + self.alpha.cross(&origin)
            + self.omega.cross(&self.omega.cross(&origin));
        Self { rotation, origin, omega, alpha, acceleration: rotation.tr_mul(&acceleration) }
    }

    /// Torque about `axis`, which passes `arm` before the origin, per unit of each parameter.
    fn loads(&self, axis: &Vector3<T>, arm: &Vector3<T>) -> [T; PER_BODY] {
        let lever = axis.cross(arm);
        let (w, dw, a) = (&self.omega, &self.alpha, &self.acceleration);
        // lever·(ω̇×e + ω×(ω×e)) for the three unit vectors e at once.
        let first = lever.cross(dw) + w * w.dot(&lever) - lever * w.dot(w) + a.cross(axis);
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
    fn wrench(&self, inertia: &Inertia<T>) -> Wrench<T> {
        let Inertia { mass, first, about_origin } = inertia;
        let (w, dw, a) = (&self.omega, &self.alpha, &self.acceleration);
        Wrench {
            force: a * *mass + dw.cross(first) + w.cross(&w.cross(first)),
            moment: about_origin * dw + w.cross(&(about_origin * w)) + first.cross(a),
        }
    }
}

impl<T: Scalar> Inertia<T> {
    fn of(p: &[f64]) -> Self {
        let at = |k: usize| T::splat(p[k]);
        Self {
            mass: at(0),
            first: Vector3::new(at(1), at(2), at(3)),
            about_origin: Matrix3::new(
                at(4),
                at(7),
                at(8),
                at(7),
                at(5),
                at(9),
                at(8),
                at(9),
                at(6),
            ),
        }
    }
}

impl<T: Scalar> Wrench<T> {
    fn none() -> Self {
        Self { force: Vector3::zeros(), moment: Vector3::zeros() }
    }

    fn plus(&self, other: &Self) -> Self {
        Self { force: self.force + other.force, moment: self.moment + other.moment }
    }

    /// The same in the frame before that of a body.
    fn before(&self, body: &Body<T>) -> Self {
        let force = body.rotation * self.force;
        Self { force, moment: body.rotation * self.moment + body.origin.cross(&force) }
    }
}

/// How the motion of a body changes with one parameter of the geometry, in its own frame.
#[derive(Clone, Copy, Debug)]
struct Tangent<T> {
    omega: Vector3<T>,
    alpha: Vector3<T>,
    acceleration: Vector3<T>,
}

impl<T: Scalar> Tangent<T> {
    fn none() -> Self {
        let zero = Vector3::zeros();
        Self { omega: zero, alpha: zero, acceleration: zero }
    }

    /// The change of the next body.
    ///
    /// - `before`, `body`: the motion of the body before and of this one
    /// - `rotation`, `origin`: how its own frame turns and shifts, in the frame before
    fn next(
        &self,
        before: &Body<T>,
        body: &Body<T>,
        rotation: &Vector3<T>,
        origin: &Vector3<T>,
    ) -> Self {
        let back = |v: Vector3<T>| body.rotation.tr_mul(&v);
        let (w, o) = (&before.omega, &body.origin);
        let omega = back(self.omega - rotation.cross(w));
        let spin = along_z(body.omega.z - body.rotation.column(2).dot(w));
        let alpha = back(self.alpha - rotation.cross(&before.alpha)) + omega.cross(&spin);
        let whole = body.rotation * body.acceleration;
        let acceleration = self.acceleration
            + self.alpha.cross(o)
            + self.omega.cross(&w.cross(o))
            + w.cross(&self.omega.cross(o))
            + before.alpha.cross(origin)
            + w.cross(&w.cross(origin))
            - rotation.cross(&whole);
        Self { omega, alpha, acceleration: back(acceleration) }
    }

    /// The change of the wrench that the motion takes.
    fn wrench(&self, body: &Body<T>, inertia: &Inertia<T>) -> Wrench<T> {
        let Inertia { mass, first, about_origin } = inertia;
        let (w, dw) = (&body.omega, &self.omega);
        Wrench {
            force: self.acceleration * *mass
                + self.alpha.cross(first)
                + dw.cross(&w.cross(first))
                + w.cross(&dw.cross(first)),
            moment: about_origin * self.alpha
                + dw.cross(&(about_origin * w))
                + w.cross(&(about_origin * dw))
                + first.cross(&self.acceleration),
        }
    }
}

mod torque;

#[cfg(test)]
mod tests;
