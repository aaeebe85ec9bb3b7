//! Recursive Newton–Euler: torque, regressor, mass matrix, energy.
//!
//! Every crate that needs rigid-body dynamics uses this recursion, the simulator and the learner.
//! It is generic over its scalar: `f64` for one state, [`Lanes`] for four states at once.

mod derivative;
mod mass;
mod slide;
mod torque;

use crate::{Coupling, Geometry, JointKind, JointKinds, Placement};
use derivative::MotionDerivative;
use nalgebra::{Matrix3, SimdRealField, Vector3};
use simba::simd::WideF64x4;

pub(crate) use torque::each_four;

/// Inertial parameters of a body: m \[kg\], m·c \[kg·m\] (3), and the entries xx, yy, zz, xy, xz, yz of
/// the inertia tensor about the origin of its frame \[kg·m²\], so that Ixy = −∫xy dm.
pub const PER_BODY: usize = 10;
/// Largest number of joints.
pub const MOST_JOINTS: usize = 16;
/// States that [`Lanes`] holds.
pub const N_LANES: usize = 4;
/// One scalar for each of four states, for work on many rows.
pub type Lanes = WideF64x4;

/// Scalar type of the recursion: `f64` or [`Lanes`].
pub trait Scalar: SimdRealField<Element = f64> + Copy + Default {}
impl<T: SimdRealField<Element = f64> + Copy + Default> Scalar for T {}

/// The joint frames of a chain and the gravity it stands in.
#[derive(Clone, Debug, PartialEq)]
pub struct Kinematics {
    placements: Vec<Placement>,
    /// \[m/s²\], in the base.
    gravity: Vector3<f64>,
    /// How the coordinates turn the joints.
    coupling: Coupling,
    /// Which of the joints turn and which slide.
    kinds: JointKinds,
}

/// q \[rad\], q̇ \[rad/s\] and q̈ \[rad/s²\] of one instant, n each; \[m\], \[m/s\], \[m/s²\] where a
/// joint slides.
#[derive(Clone, Copy, Debug)]
pub struct MotionState<'a, T> {
    /// Joint positions.
    pub q: &'a [T],
    /// Joint velocities.
    pub dq: &'a [T],
    /// Joint accelerations.
    pub ddq: &'a [T],
}

/// Motion of one body, all vectors in its own frame.
#[derive(Clone, Copy, Debug, Default)]
struct Body<T: Scalar> {
    /// Rotation from this frame to its parent.
    rotation: Matrix3<T>,
    /// Its origin in the parent frame \[m\].
    origin: Vector3<T>,
    /// Angular velocity \[rad/s\].
    omega: Vector3<T>,
    /// Angular acceleration \[rad/s²\].
    alpha: Vector3<T>,
    /// Acceleration of the origin less gravity \[m/s²\].
    acceleration: Vector3<T>,
}

/// Force \[N\] and moment \[N·m\] about the origin of a frame.
#[derive(Clone, Copy, Debug, Default)]
struct Wrench<T: Scalar> {
    force: Vector3<T>,
    moment: Vector3<T>,
}

/// Mass, first moment and rotational inertia of a body, ready for the recursion.
#[derive(Clone, Copy, Debug, Default)]
pub struct Inertia<T: Scalar> {
    /// \[kg\]
    pub mass: T,
    /// m·c \[kg·m\]
    pub first: Vector3<T>,
    /// Moments about the origin of its frame \[kg·m²\].
    pub about_origin: Matrix3<T>,
}

/// The motion of all bodies at one state: what torque, regressor and derivatives start from.
#[derive(Clone, Debug, Default)]
pub struct Moved<T: Scalar> {
    bodies: Vec<Body<T>>,
    base: Body<T>,
    /// What [`Self::torque`] came by, for the derivatives.
    inertias: Vec<Inertia<T>>,
    wrenches: Vec<Wrench<T>>,
    /// Room for [`Self::geometry_derivative`].
    tangents: Vec<MotionDerivative<T>>,
    coupling: Coupling,
    kinds: JointKinds,
    /// How far, fast and hard each joint slides \[m, m/s, m/s²\]; empty where all turn.
    slides: Vec<[T; 3]>,
}

fn splat<T: Scalar>(v: &Vector3<f64>) -> Vector3<T> {
    v.map(T::splat)
}

fn along_z<T: Scalar>(z: T) -> Vector3<T> {
    Vector3::new(T::zero(), T::zero(), z)
}

/// M v, column by column: on four states at once the general product is several times slower.
#[inline]
fn times<T: Scalar>(m: &Matrix3<T>, v: &Vector3<T>) -> Vector3<T> {
    m.column(0) * v.x + m.column(1) * v.y + m.column(2) * v.z
}

/// Mᵀ v, for the same reason.
#[inline]
fn back<T: Scalar>(m: &Matrix3<T>, v: &Vector3<T>) -> Vector3<T> {
    let of = |k: usize| m[(0, k)] * v.x + m[(1, k)] * v.y + m[(2, k)] * v.z;
    Vector3::new(of(0), of(1), of(2))
}

/// A B, column by column as [`times`].
fn product<T: Scalar>(a: &Matrix3<T>, b: &Matrix3<T>) -> Matrix3<T> {
    Matrix3::from_columns(&[0, 1, 2].map(|k| times(a, &b.column(k).into_owned())))
}

impl Kinematics {
    /// The frames of a geometry.
    pub fn new(geometry: &Geometry) -> Self {
        let (coupling, kinds) = (geometry.coupling().clone(), geometry.kinds().clone());
        let gravity = geometry.gravity().into();
        Self { placements: geometry.placements(), gravity, coupling, kinds }
    }

    /// Frames given one by one; joint i turns about z of frame i, or slides along it.
    ///
    /// - `gravity`: \[m/s²\], in the base
    pub fn of_frames(placements: Vec<Placement>, kinds: JointKinds, gravity: [f64; 3]) -> Self {
        Self { placements, gravity: gravity.into(), coupling: Coupling::default(), kinds }
    }

    /// The same chain without gravity.
    pub fn without_gravity(self) -> Self {
        Self { gravity: Vector3::zeros(), ..self }
    }

    /// Number of joints n.
    pub fn n_joints(&self) -> usize {
        self.placements.len()
    }

    /// Moves the bodies: the outward half of the recursion. `moved` is overwritten, so that a loop
    /// over rows allocates once.
    pub fn move_into<T: Scalar>(&self, state: MotionState<'_, T>, moved: &mut Moved<T>) {
        self.move_bodies(|joint| [state.q[joint], state.dq[joint], state.ddq[joint]], moved);
    }

    /// [`Self::move_into`] at rest: the bodies stand at q \[rad\].
    pub fn place_into<T: Scalar>(&self, q: &[T], moved: &mut Moved<T>) {
        self.move_bodies(|joint| [q[joint], T::zero(), T::zero()], moved);
    }

    /// - `state`: q, q̇ and q̈ of a joint
    fn move_bodies<T: Scalar>(&self, state: impl Fn(usize) -> [T; 3], moved: &mut Moved<T>) {
        moved.base = self.base();
        moved.coupling.clone_from(&self.coupling);
        moved.kinds.clone_from(&self.kinds);
        moved.slides.clear();
        moved.bodies.clear();
        moved.bodies.reserve(self.n_joints());
        for joint in 0..self.n_joints() {
            let before = moved.bodies.last().unwrap_or(&moved.base);
            let (body, state) = self.body(joint, before, &state);
            moved.bodies.push(body);
            if !self.kinds.all_turn() {
                let slide = T::splat(self.kinds.of(joint).twist[1]);
                moved.slides.push(state.map(|signal| signal * slide));
            }
        }
    }

    /// The base, at rest under gravity.
    fn base<T: Scalar>(&self) -> Body<T> {
        Body { acceleration: -splat(&self.gravity), ..Body::default() }
    }

    /// The body behind a joint, and q, q̇ and q̈ of that joint in the chain.
    ///
    /// - `state`: q, q̇ and q̈ of a logged coordinate
    fn body<T: Scalar>(
        &self,
        joint: usize,
        before: &Body<T>,
        state: impl Fn(usize) -> [T; 3],
    ) -> (Body<T>, [T; 3]) {
        let placement = &self.placements[joint];
        let state =
            [0, 1, 2].map(|signal| self.coupling.drive(joint, |joint| state(joint)[signal]));
        let body = if self.kinds.all_turn() {
            before.next(placement, state)
        } else {
            before.moved(placement, self.kinds.of(joint), state)
        };
        (body, state)
    }

    /// Potential energy \[J\] at q, up to a constant.
    pub fn potential_energy(&self, q: &[f64], inertial: &[f64]) -> f64 {
        let mut turned = Matrix3::identity();
        let mut origin = Vector3::zeros();
        let mut sum = Vector3::zeros();
        for (joint, placement) in self.placements.iter().enumerate() {
            let [angle, slide] = self.kinds.of(joint).twist;
            let q = self.coupling.drive(joint, |joint| q[joint]);
            let (sin, cos) = (angle * q).sin_cos();
            origin += turned * placement.origin;
            turned *= turned_about_z(&placement.rotation, sin, cos);
            origin += turned.column(2) * (slide * q);
            let body = &inertial[PER_BODY * joint..];
            sum += origin * body[0] + turned * Vector3::new(body[1], body[2], body[3]);
        }
        -self.gravity.dot(&sum)
    }
}

/// R · Rz for the sine and cosine of an angle.
fn turned_about_z<T: Scalar>(rotation: &Matrix3<T>, sin: T, cos: T) -> Matrix3<T> {
    let [x, y, z] = [0, 1, 2].map(|column| rotation.column(column));
    Matrix3::from_columns(&[x * cos + y * sin, y * cos - x * sin, z.into_owned()])
}

impl<T: Scalar> Moved<T> {
    /// The inward half of the recursion: torques \[N·m\], n.
    ///
    /// - `inertial`: inertial parameters of all bodies, 10 each
    pub fn torque(&mut self, inertial: &[f64], torque: &mut [T]) {
        self.inertias.clear();
        self.inertias.extend(inertial.chunks_exact(PER_BODY).map(Inertia::of));
        self.wrenches.clear();
        self.wrenches.reserve(self.bodies.len());
        let mut wrench = Wrench::default();
        for (joint, body) in self.bodies.iter().enumerate().rev() {
            wrench = wrench.plus(&body.wrench(&self.inertias[joint]));
            self.wrenches.push(wrench);
            torque[joint] = wrench.effort(self.kinds.of(joint));
            wrench = wrench.before(body);
        }
        self.wrenches.reverse();
        self.coupling.load(torque);
    }

    /// The regressor: torque of each joint per unit of each inertial parameter. Calls `put(joint,
    /// parameter, value)` for all parameters of the bodies from the joint outward; those before it
    /// do not load it.
    pub fn regressor(&self, mut put: impl FnMut(usize, usize, T)) {
        if self.coupling.is_none() {
            return self.regressor_of_chain(put);
        }
        let n = self.bodies.len();
        let mut columns = vec![vec![T::zero(); n]; PER_BODY * n];
        self.regressor_of_chain(|joint, parameter, value| columns[parameter][joint] = value);
        for (parameter, column) in columns.iter_mut().enumerate() {
            self.coupling.load(column);
            (0..=parameter / PER_BODY).for_each(|joint| put(joint, parameter, column[joint]));
        }
    }

    /// The regressor of the torques of the joints of the chain.
    fn regressor_of_chain(&self, mut put: impl FnMut(usize, usize, T)) {
        for joint in 0..self.bodies.len() {
            let kind = self.kinds.of(joint);
            // The axis of the joint, and the arm from it to the body, in the frame of the body.
            let (mut axis, mut arm) = (along_z(T::one()), Vector3::zeros());
            for (k, body) in self.bodies.iter().enumerate().skip(joint) {
                if k > joint {
                    axis = back(&body.rotation, &axis);
                    arm = back(&body.rotation, &(arm + body.origin));
                }
                let loads = body.efforts(kind, &axis, &arm);
                for (parameter, value) in loads.iter().enumerate() {
                    put(joint, PER_BODY * k + parameter, *value);
                }
            }
        }
    }
}

impl<T: Scalar> Body<T> {
    /// The body behind the next joint.
    ///
    /// - `state`: its q, q̇ and q̈
    fn moved(&self, placement: &Placement, kind: JointKind, state: [T; 3]) -> Self {
        let [turn, slide] = kind.twist.map(|part| state.map(|signal| signal * T::splat(part)));
        let turned = self.next(placement, turn);
        if kind.slides() { turned.slid(self, slide) } else { turned }
    }

    /// The body behind the next joint, which turns.
    fn next(&self, placement: &Placement, [q, dq, ddq]: [T; 3]) -> Self {
        let (sin, cos) = q.simd_sin_cos();
        let rotation: Matrix3<T> = turned_about_z(&placement.rotation.map(T::splat), sin, cos);
        let origin: Vector3<T> = splat(&placement.origin);
        let carried: Vector3<T> = back(&rotation, &self.omega);
        let omega: Vector3<T> = carried + along_z(dq);
        let alpha: Vector3<T> =
            back(&rotation, &self.alpha) + carried.cross(&along_z(dq)) + along_z(ddq);
        let acceleration = self.acceleration
            + self.alpha.cross(&origin)
            + self.omega.cross(&self.omega.cross(&origin));
        Self { rotation, origin, omega, alpha, acceleration: back(&rotation, &acceleration) }
    }

    /// Torque, or force, of a joint per unit of each parameter: [`Self::loads`], [`Self::pushes`].
    fn efforts(&self, kind: JointKind, axis: &Vector3<T>, arm: &Vector3<T>) -> [T; PER_BODY] {
        if !kind.slides() {
            return self.loads(axis, arm);
        }
        let [turn, slide] = kind.twist.map(T::splat);
        let (loads, pushes) = (self.loads(axis, arm), self.pushes(axis));
        std::array::from_fn(|k| loads[k] * turn + pushes[k] * slide)
    }

    /// Torque about `axis` per unit of each parameter; `arm` leads from the joint to the origin \[m\].
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
            moment: times(about_origin, dw) + w.cross(&times(about_origin, w)) + first.cross(a),
        }
    }
}

impl<T: Scalar> Inertia<T> {
    /// Of inertial parameters, 10.
    pub fn of(p: &[f64]) -> Self {
        let [mass, hx, hy, hz, xx, yy, zz, xy, xz, yz] = std::array::from_fn(|k| T::splat(p[k]));
        let about_origin = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        Self { mass, first: Vector3::new(hx, hy, hz), about_origin }
    }
}

impl<T: Scalar> Wrench<T> {
    fn plus(&self, other: &Self) -> Self {
        Self { force: self.force + other.force, moment: self.moment + other.moment }
    }

    /// What the motor of a joint holds of it: its moment about z, its force along it.
    #[inline]
    fn effort(&self, kind: JointKind) -> T {
        if !kind.slides() {
            return self.moment.z;
        }
        let [turn, slide] = kind.twist.map(T::splat);
        self.moment.z * turn + self.force.z * slide
    }

    /// The same in the frame before that of a body.
    fn before(&self, body: &Body<T>) -> Self {
        let force = times(&body.rotation, &self.force);
        Self { force, moment: times(&body.rotation, &self.moment) + body.origin.cross(&force) }
    }
}
