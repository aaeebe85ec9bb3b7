//! Arms: names, placements, axes and bodies of joints in a row, checked once.
#![expect(non_snake_case, reason = "frames are written quantity_fromTo, as in `spatial`")]

use crate::spatial::is_positive_semidefinite;
use crate::{Body, Pose, Result, SimError, check_between, check_joints, placement, pose};
use nalgebra::{Unit, Vector3};
use std::f64::consts::PI;
use torquewise_motion::unfit_joint_name;
use torquewise_rigid::geometry::GRAVITY;
use torquewise_rigid::{Geometry, JointKind, JointKinds, Kinematics, PER_BODY};

/// Gravity \[m/s²\] where none is given: along −z of the world.
pub(crate) const STANDARD_GRAVITY: [f64; 3] = [0.0, 0.0, -GRAVITY];

/// A joint and the body it moves, in the frame J that moves with it.
#[derive(Clone, Debug)]
pub(crate) struct Joint {
    /// J at q = 0, seen from the joint before (the world for the first); the joint turns about its z
    /// or slides along it.
    pub(crate) X_PJ: Pose,
    pub(crate) kind: JointKind,
    /// All that moves with this joint and not with the next, in J.
    pub(crate) body: Body,
    /// Inertia of the motor's rotor \[kg·m²\], or \[kg\] of a slide, as felt at the joint: gear² × rotor.
    pub(crate) rotor: f64,
    /// Positions \[rad, m\] that simulated motions keep to.
    pub(crate) range: [f64; 2],
    pub(crate) limits: JointLimits,
}

/// What the file of an arm says a joint may do at most; `None` where it says nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointLimits {
    /// Lower and upper position \[rad\].
    pub position: Option<[f64; 2]>,
    /// Speed \[rad/s\], more than zero.
    pub velocity: Option<f64>,
    /// Acceleration \[rad/s²\], more than zero.
    pub acceleration: Option<f64>,
}

impl JointLimits {
    /// Limits from numbers of which zero, infinity and NaN mean that there is none.
    pub(crate) fn new([lower, upper]: [f64; 2], velocity: f64, acceleration: f64) -> Self {
        let given = |most: f64| (most > 0.0 && most.is_finite()).then_some(most);
        let position = (lower < upper && (upper - lower).is_finite()).then_some([lower, upper]);
        Self { position, velocity: given(velocity), acceleration: given(acceleration) }
    }
}

/// A serial arm of joints that turn or slide, on a fixed base, with all its masses known.
///
/// The truth that simulated logs are made from. Equations are those of a rigid arm,
/// τ = M(q) q̈ + C(q, q̇) q̇ + G(q), method.md (1).
#[derive(Clone, Debug)]
pub struct Arm {
    name: String,
    joint_names: Vec<String>,
    pub(crate) joints: Vec<Joint>,
    gravity: [f64; 3],
    pub(crate) kinematics: Kinematics,
    /// Inertial parameters of all bodies in the frames of their joints, 10n.
    pub(crate) inertial: Vec<f64>,
}

impl Arm {
    pub(crate) fn new(
        name: String,
        gravity: [f64; 3],
        joints: Vec<(String, Joint)>,
    ) -> Result<Self> {
        if joints.is_empty() {
            return Err(SimError::NoJoints);
        }
        check_finite("gravity", &name, &gravity)?;
        let names: Vec<String> = joints.iter().map(|(name, _)| name.clone()).collect();
        if let Some(name) = unfit_joint_name(&names) {
            let start = name.chars().take(20).flat_map(char::escape_debug).collect();
            return Err(if names.iter().filter(|own| *own == name).count() > 1 {
                SimError::DuplicateName { kind: "joint", name: start }
            } else {
                SimError::JointName { name: start }
            });
        }
        joints.iter().try_for_each(|(name, joint)| joint.check(name))?;
        let (joint_names, joints): (_, Vec<Joint>) = joints.into_iter().unzip();
        let placements = joints.iter().map(|joint| placement(&joint.X_PJ)).collect();
        let kinematics = Kinematics::of_frames(placements, kinds(&joints), gravity);
        let inertial = joints.iter().flat_map(|joint| joint.body.inertial_parameters()).collect();
        Ok(Self { name, joint_names, joints, gravity, kinematics, inertial })
    }

    /// What the arm is called.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Joint names, base to tip, n.
    pub fn joints(&self) -> &[String] {
        &self.joint_names
    }

    /// Number of joints n.
    pub fn n_joints(&self) -> usize {
        self.joints.len()
    }

    /// Gravity \[m/s²\] in the world frame, the frame the base is placed in.
    pub fn gravity(&self) -> [f64; 3] {
        self.gravity
    }

    /// Which of its joints turn and which slide.
    pub fn kinds(&self) -> JointKinds {
        kinds(&self.joints)
    }

    /// Lower and upper position \[rad, m\] of each joint that simulated motions keep to, n.
    pub fn ranges(&self) -> Vec<[f64; 2]> {
        self.joints.iter().map(|joint| joint.range).collect()
    }

    /// Limits of each joint as the file of the arm gives them, n.
    ///
    /// Unlike [`Arm::ranges`] these may be more than a turn apart. Nothing in this crate keeps to
    /// the speeds and accelerations.
    pub fn limits(&self) -> Vec<JointLimits> {
        self.joints.iter().map(|joint| joint.limits).collect()
    }

    /// The same arm with other rotors.
    ///
    /// - `rotors` \[kg·m²\], n: inertia of each motor's rotor as felt at its joint, gear² × rotor
    ///
    /// # Errors
    /// [`SimError::JointCount`] for another number of them than n; [`SimError::Setting`] for one
    /// that no rotor has.
    pub fn with_rotors(mut self, rotors: &[f64]) -> Result<Self> {
        check_joints("rotor inertia", rotors.len(), self.n_joints())?;
        for ((joint, name), &rotor) in self.joints.iter_mut().zip(&self.joint_names).zip(rotors) {
            joint.rotor = rotor;
            joint.check(name)?;
        }
        Ok(self)
    }

    /// The arm of a learned chain, called `twin`.
    ///
    /// - `joints`: names, base to tip, n
    /// - `inertial`: inertial parameters of each body in the frame of its joint, 10n
    /// - `limits`: positions \[rad\] and largest speed \[rad/s\] of each joint, n
    ///
    /// # Errors
    /// The variant of [`SimError`] that names the joint or number at fault.
    pub fn of_chain(
        joints: &[String],
        geometry: &Geometry,
        inertial: &[f64],
        limits: impl Iterator<Item = ([f64; 2], f64)>,
    ) -> Result<Self> {
        let frames = joints.iter().zip(geometry.placements()).zip(inertial.chunks_exact(PER_BODY));
        let all = frames.zip(limits).enumerate().map(|(k, frame)| {
            let (((name, placement), body), (range, velocity)) = frame;
            let kind = geometry.kinds().of(k);
            let body = Body::of_parameters(&std::array::from_fn(|k| body[k]));
            let limits = JointLimits::new(range, velocity, 0.0);
            let (X_PJ, range) = (pose(&placement), motion_range(kind, range));
            (name.clone(), Joint { X_PJ, kind, body, rotor: 0.0, range, limits })
        });
        Self::new("twin".to_owned(), geometry.gravity(), all.collect())
    }
}

fn kinds(joints: &[Joint]) -> JointKinds {
    joints.iter().map(|joint| joint.kind).collect::<Vec<_>>().into()
}

impl Joint {
    fn check(&self, name: &str) -> Result<()> {
        check_finite("placement", name, self.X_PJ.to_matrix().as_slice())?;
        check_between(format!("rotor inertia of `{name}`"), self.rotor, SIZE, "0 or more")?;
        let [lower, upper] = self.range;
        if !(lower < upper && (upper - lower).is_finite()) {
            return Err(SimError::Range { joint: name.into(), lower, upper });
        }
        check_body(name, &self.body)
    }
}

/// Between zero and infinity.
const SIZE: [f64; 2] = [0.0, f64::MAX];

pub(crate) fn check_body(place: &str, body: &Body) -> Result<()> {
    check_between(format!("mass of `{place}` [kg]"), body.mass, SIZE, "0 or more")?;
    check_finite("centre of mass", place, body.com.as_slice())?;
    check_finite("inertia", place, body.inertia.as_slice())?;
    let refused = || SimError::Inertia { place: place.into() };
    is_positive_semidefinite(&body.inertia).then_some(()).ok_or_else(refused)
}

pub(crate) fn direction(joint: &str, axis: [f64; 3]) -> Result<Unit<Vector3<f64>>> {
    let axis = Vector3::from(axis);
    Unit::try_new(axis, 1e-9)
        .filter(|_| axis.norm().is_finite())
        .ok_or_else(|| SimError::NoDirection { what: format!("axis of joint `{joint}`") })
}

/// Positions that simulated motions keep to: of a slide its limits, which it must have; else at most
/// one turn about their middle, a full turn where there is no limit.
pub(crate) fn motion_range(kind: JointKind, [lower, upper]: [f64; 2]) -> [f64; 2] {
    let (middle, half) = (f64::midpoint(lower, upper), (upper - lower) / 2.0);
    if !kind.turns() {
        [lower, upper]
    } else if half > 0.0 && half.is_finite() {
        [middle - half.min(PI), middle + half.min(PI)]
    } else {
        [-PI, PI]
    }
}

pub(crate) fn check_finite(what: &str, place: &str, values: &[f64]) -> Result<()> {
    let is_finite = |value: &f64| {
        check_between(format!("{what} of `{place}`"), *value, [f64::MIN, f64::MAX], "a number")
    };
    values.iter().try_for_each(is_finite)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::float_cmp, reason = "limits are passed on, not computed")]

    use super::*;

    #[test]
    fn a_joint_without_limits_may_make_one_turn_and_a_narrow_range_is_kept() {
        for limits in [[0.0; 2], [f64::NEG_INFINITY, f64::INFINITY], [-2.0 * PI, 2.0 * PI]] {
            assert_eq!(motion_range(JointKind::Revolute, limits), [-PI, PI], "{limits:?}");
        }
        assert_eq!(motion_range(JointKind::Revolute, [-3.0, -1.0]), [-3.0, -1.0]);
    }
}
