//! Geometry of a chain: where its joint axes lie, as far as torque determines it (E8).

mod choices;

use crate::{Coupling, JointKinds, Result, expect};
use nalgebra::{Matrix3, Rotation3, Vector3};
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, PI};

/// Acceleration of gravity \[m/s²\], rounded.
pub const GRAVITY: f64 = 9.81;
/// Numbers that place a joint in its parent frame.
pub const PER_JOINT: usize = 4;
/// Parameters of the direction of gravity in the base.
pub const PER_BASE: usize = 2;

/// Where the joint axes of a chain of n joints lie.
///
/// Joint 1 turns about, or slides along, z of the base. The axis of joint i + 1 is fixed in the frame of
/// joint i: its direction is that of z turned by the rotation vector (w₁, w₂, 0), its place the
/// shift (p₁, p₂, 0) seen from the turned frame. Neither a shift along the axis nor a turn about it
/// is a parameter: the masses of the link behind it are free, so torque cannot determine it. The place
/// of a joint that slides, or that no revolute joint precedes, has no effect and stays 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Geometry {
    /// Turns of gravity from −z of the base about x and y \[rad\], then w₁, w₂ \[rad\], p₁, p₂
    /// \[m\] of joints 2…n.
    pub(crate) parameters: Vec<f64>,
    /// How logged coordinates turn the joints.
    coupling: Coupling,
    /// Which of the joints turn and which slide.
    kinds: JointKinds,
}

/// A frame that is fixed in its parent frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Rotation from this frame to its parent: R v has the components there.
    pub rotation: Matrix3<f64>,
    /// Its origin \[m\], in the parent frame.
    pub origin: Vector3<f64>,
}

/// How the frame of a joint moves per unit of one parameter of the geometry.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GeometryDerivative {
    /// The joint whose frame moves, counted from 0; all beyond it moves along.
    pub joint: usize,
    /// Rotation \[rad/rad\], in the parent frame; zero for a place.
    pub rotation: Vector3<f64>,
    /// Shift of its origin \[m/rad\], or \[m/m\] for a place, in the parent frame.
    pub origin: Vector3<f64>,
    /// Change of gravity \[m/s² per rad\], in the base; zero but for the tilt.
    pub gravity: Vector3<f64>,
}

/// Axes along ±x, ±y, ±z of the parent frame, as rotation vectors.
pub const RIGHT_ANGLES: [[f64; 2]; 6] = [
    [0.0, 0.0],
    [FRAC_PI_2, 0.0],
    [-FRAC_PI_2, 0.0],
    [0.0, FRAC_PI_2],
    [0.0, -FRAC_PI_2],
    [PI, 0.0],
];
/// Components of a unit vector below this are none: files give angles to so many digits.
const ROUNDING: f64 = 1e-12;
/// Place of −z among the right angles.
const HALF_TURN: usize = 5;

impl Geometry {
    /// All axes along z, through one point.
    pub fn straight(n_joints: usize) -> Self {
        let parameters = vec![0.0; PER_BASE + PER_JOINT * n_joints.saturating_sub(1)];
        Self { parameters, coupling: Coupling::default(), kinds: JointKinds::default() }
    }

    /// A chain whose axes lie as `parameters` say: two of gravity, then four of each joint from the
    /// second on; rad and m.
    ///
    /// # Errors
    /// [`ChainError::Shape`](crate::ChainError::Shape) if their number is that of no chain.
    pub fn new(parameters: &[f64]) -> Result<Self> {
        let found = parameters.len();
        let joints = found.saturating_sub(PER_BASE) / PER_JOINT;
        expect("geometry", found, PER_BASE + PER_JOINT * joints)?;
        Ok(Self { parameters: parameters.to_vec(), ..Self::straight(0) })
    }

    /// The same joints where their axes lie as other parameters say, as many.
    #[must_use]
    pub fn at(&self, parameters: &[f64]) -> Self {
        Self { parameters: parameters.to_vec(), ..self.clone() }
    }

    /// The geometry of a chain from its joint frames, z of each the joint axis; and, of each joint, the
    /// placement of the frame of the geometry in the given frame.
    ///
    /// The base is the first frame at q = 0; a frame of the geometry has the axis of the given one
    /// and differs from it by a turn about z and a shift along it, or any shift if it slides.
    ///
    /// - `placements`: each in its parent frame at q = 0, the first in the world; n ≥ 1
    /// - `down`: direction of gravity in the world, of any length but zero
    pub fn of_joints(
        placements: &[Placement],
        kinds: &JointKinds,
        down: [f64; 3],
    ) -> (Self, Vec<Placement>) {
        let mut geometry = Self::straight(placements.len()).of_kinds(kinds.clone());
        let zero = Vector3::zeros();
        let mut own = Placement { rotation: Matrix3::identity(), origin: zero };
        let mut frames = vec![own];
        if let Some(first) = placements.first() {
            let up = -first.rotation.tr_mul(&Vector3::from(down)).normalize();
            geometry.set_turn(0, turn_to(&up));
        }
        for (joint, given) in placements.iter().enumerate().skip(1) {
            // The given frame, in the frame of the geometry before.
            let rotation = own.rotation.tr_mul(&given.rotation);
            let origin = own.rotation.tr_mul(&(given.origin - own.origin));
            let direction = turn_to(&rotation.column(2).into_owned());
            let turned = turn(direction);
            let place = turned.tr_mul(&origin);
            geometry.set_turn(joint, direction);
            own.rotation = rotation.tr_mul(&turned);
            if kinds.of(joint).turns() {
                geometry.set_place(joint, [place.x, place.y]);
                own.origin = Vector3::new(0.0, 0.0, -place.z);
            } else {
                own.origin = -(own.rotation * place);
            }
            frames.push(own);
        }
        (geometry, frames)
    }

    /// The same axes, turned by logged coordinates as a coupling says \[E18\].
    #[must_use]
    pub fn coupled(self, coupling: Coupling) -> Self {
        Self { coupling, ..self }
    }

    /// How logged coordinates turn the joints.
    pub fn coupling(&self) -> &Coupling {
        &self.coupling
    }

    /// The same axes, of which some slide.
    #[must_use]
    pub fn of_kinds(self, kinds: JointKinds) -> Self {
        Self { kinds, ..self }
    }

    /// Which of the joints turn and which slide.
    pub fn kinds(&self) -> &JointKinds {
        &self.kinds
    }

    /// Number of joints n.
    pub fn n_joints(&self) -> usize {
        (self.parameters.len() - PER_BASE) / PER_JOINT + 1
    }

    /// The parameters: two of gravity, then four of each joint from the second on.
    pub fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    /// Direction (w₁, w₂) of the axis of a joint, counted from 0, in the frame before; that of the
    /// first is z itself.
    ///
    /// # Panics
    /// If the chain has no such joint.
    pub fn direction(&self, joint: usize) -> [f64; 2] {
        if joint == 0 { [0.0; 2] } else { self.turn_of(joint) }
    }

    /// Place (p₁, p₂) \[m\] of the axis of a joint, counted from 0.
    ///
    /// # Panics
    /// If the chain has no such joint.
    pub fn place(&self, joint: usize) -> [f64; 2] {
        let first = first_of(joint) + 2;
        if joint == 0 { [0.0; 2] } else { [self.parameters[first], self.parameters[first + 1]] }
    }

    /// The turns of a joint: of the first those of gravity, of the others their direction.
    pub(crate) fn turn_of(&self, joint: usize) -> [f64; 2] {
        [self.parameters[first_of(joint)], self.parameters[first_of(joint) + 1]]
    }

    pub(crate) fn set_turn(&mut self, joint: usize, turn: [f64; 2]) {
        self.parameters[first_of(joint)..][..2].copy_from_slice(&turn);
    }

    /// Of a joint from the second on.
    pub(crate) fn set_place(&mut self, joint: usize, place: [f64; 2]) {
        self.parameters[first_of(joint) + 2..][..2].copy_from_slice(&place);
    }

    /// Acceleration of gravity \[m/s²\] in the base.
    pub fn gravity(&self) -> [f64; 3] {
        (-GRAVITY * axis(self.turn_of(0))).into()
    }

    /// The same joints where things fall another way in the base, of any length but zero.
    #[must_use]
    pub fn falling(mut self, down: [f64; 3]) -> Self {
        self.set_turn(0, turn_to(&-Vector3::from(down).normalize()));
        self
    }

    /// How the frames move per unit of each parameter, in the order of [`Self::parameters`].
    pub fn derivatives(&self) -> Vec<GeometryDerivative> {
        let of_tilt = left_jacobian(self.turn_of(0)).map(|rotation| GeometryDerivative {
            gravity: rotation.cross(&Vector3::from(self.gravity())),
            ..GeometryDerivative::default()
        });
        let placements = self.placements();
        let of_joint = |joint: usize| {
            let none = GeometryDerivative { joint, ..GeometryDerivative::default() };
            let Placement { rotation: turned, origin } = placements[joint];
            let turns = left_jacobian(self.direction(joint)).map(|rotation| {
                let origin = rotation.cross(&origin);
                GeometryDerivative { rotation, origin, ..none }
            });
            let shifts = [Vector3::x(), Vector3::y()]
                .map(|shift| GeometryDerivative { origin: turned * shift, ..none });
            turns.into_iter().chain(shifts)
        };
        of_tilt.into_iter().chain((1..self.n_joints()).flat_map(of_joint)).collect()
    }

    /// The frame of each joint in the one before, at q = 0, n.
    pub fn placements(&self) -> Vec<Placement> {
        let of_joint = |joint| {
            let (rotation, [x, y]) = (turn(self.direction(joint)), self.place(joint));
            Placement { rotation, origin: rotation * Vector3::new(x, y, 0.0) }
        };
        (0..self.n_joints()).map(of_joint).collect()
    }

    /// The frame of each joint at q = 0 in one at the base with z up, against gravity, n.
    pub fn upright(&self) -> Vec<Placement> {
        let up = -Vector3::from(self.gravity());
        let mut rotation = between(&up, &Vector3::z()).into_inner();
        let mut origin = Vector3::zeros();
        let frame = |placement: Placement| {
            origin += rotation * placement.origin;
            rotation *= placement.rotation;
            Placement { rotation, origin }
        };
        self.placements().into_iter().map(frame).collect()
    }
}

impl Placement {
    /// Its z, which is the axis of a joint, in the parent frame.
    pub fn axis(&self) -> Vector3<f64> {
        self.rotation.column(2).into_owned()
    }
}

/// The turn that brings a direction to another, one of which is that of z.
pub fn between(from: &Vector3<f64>, to: &Vector3<f64>) -> Rotation3<f64> {
    let half_turn = || Rotation3::from_axis_angle(&Vector3::x_axis(), PI);
    Rotation3::rotation_between(from, to).unwrap_or_else(half_turn)
}

/// Where the parameters of a joint begin.
fn first_of(joint: usize) -> usize {
    joint.checked_sub(1).map_or(0, |before| PER_BASE + PER_JOINT * before)
}

fn turn(w: [f64; 2]) -> Matrix3<f64> {
    *Rotation3::new(Vector3::new(w[0], w[1], 0.0)).matrix()
}

/// The rotation vector (w₁, w₂) that turns z to a unit vector; components that are rounding are 0.
fn turn_to(axis: &Vector3<f64>) -> [f64; 2] {
    let across = axis.x.hypot(axis.y);
    let angle = across.atan2(axis.z);
    if across < ROUNDING {
        return [if axis.z < 0.0 { PI } else { 0.0 }, 0.0];
    }
    [-axis.y, axis.x].map(|x| if x.abs() < ROUNDING { 0.0 } else { angle * x / across })
}

/// Rotation \[rad\] that follows turning by (w₁, w₂, 0), per unit of w₁ and of w₂: two columns of
/// the left Jacobian of the rotation group.
fn left_jacobian(w: [f64; 2]) -> [Vector3<f64>; 2] {
    let w = Vector3::new(w[0], w[1], 0.0);
    let angle = w.norm();
    // (1 − cos φ)/φ² and (φ − sin φ)/φ³; of small angles, where they lose digits, their series.
    let [first, second] = if angle < 1e-4 {
        [0.5 - angle * angle / 24.0, 1.0 / 6.0 - angle * angle / 120.0]
    } else {
        let half = (0.5 * angle).sin();
        [2.0 * half * half / (angle * angle), (angle - angle.sin()) / angle.powi(3)]
    };
    [Vector3::x(), Vector3::y()].map(|unit| {
        let across = w.cross(&unit);
        unit + first * across + second * w.cross(&across)
    })
}

/// The direction of an axis, a unit vector.
fn axis(direction: [f64; 2]) -> Vector3<f64> {
    turn(direction) * Vector3::z()
}

/// The right angle nearest to a direction.
pub(crate) fn nearest_right_angle(direction: [f64; 2]) -> [f64; 2] {
    let apart = |k: &usize| (axis(direction) - axis(RIGHT_ANGLES[*k])).norm_squared();
    let order = |a: &usize, b: &usize| apart(a).total_cmp(&apart(b));
    let nearest = (0..RIGHT_ANGLES.len()).min_by(order).unwrap_or(0);
    // Half a turn about any axis is the same direction: take the one that lies nearest.
    let size = direction[0].hypot(direction[1]);
    if nearest == HALF_TURN && size > 0.0 {
        return direction.map(|w| w * PI / size);
    }
    RIGHT_ANGLES[nearest]
}

#[cfg(test)]
mod tests;
