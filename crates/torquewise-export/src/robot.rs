//! What a robot file holds of a model: links, joints, rotors, friction; what is left out.

use crate::error::{ExportError, Result};
use minijinja::{Value, context};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;
use torquewise_model::friction::FrictionLaw;
use torquewise_model::learned::{JointGeometry, joint_geometry};
use torquewise_model::shaft_friction::{Estimated, FrictionParameters, ShaftFriction};
use torquewise_model::{Drive, JointKind, Model, RigidChain, Torque, number};
use torquewise_rigid::geometry::{Placement, between};
use torquewise_sim::Body;
use torquewise_sim::urdf::edit::Dynamics;

#[derive(Clone, Debug)]
pub(crate) struct Robot {
    pub(crate) name: String,
    pub(crate) base: String,
    pub(crate) joints: Vec<RobotJoint>,
    /// Rotors and friction on shafts that several joints turn: the speed of the shaft per speed of
    /// each joint, n, and what turns and rubs on it.
    pub(crate) shared: Vec<(Vec<f64>, Losses)>,
    /// Parts of the model that no robot file has room for.
    pub(crate) left_out: Vec<String>,
}

/// A joint with the link that it turns, the axis z of its frame.
#[derive(Clone, Debug)]
pub(crate) struct RobotJoint {
    pub(crate) name: String,
    pub(crate) link: String,
    pub(crate) kind: JointKind,
    /// Its frame at q = 0 in the one before; of the first in the world, z up.
    pub(crate) frame: Placement,
    /// m, m·c and moments about the origin.
    pub(crate) inertial: [f64; 10],
    pub(crate) losses: Losses,
    /// Positions \[rad\] of the log.
    pub(crate) range: [f64; 2],
    /// Largest speed of the log \[rad/s\].
    pub(crate) speed: f64,
    /// Largest torque \[N·m\] that the model asks for within the motion of the log.
    pub(crate) effort: f64,
    /// What of its geometry the log does not tell, in words.
    pub(crate) unresolved: Option<String>,
}

/// What turns with a shaft and rubs on it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Losses {
    pub(crate) dynamics: Dynamics,
    /// What a motion must overcome to begin \[N·m\]: dry friction, or more.
    pub(crate) breakaway: f64,
    /// Torque that the motor needs though nothing moves \[N·m\]; none of a shared shaft.
    pub(crate) offset: f64,
}

/// Radius of the links that are drawn, as a part of the length of the arm, and at least \[m\].
const RADIUS: (f64, f64) = (0.04, 0.005);
/// States within the range of the log, of which efforts and lost friction are taken.
const STATES: usize = 2_000;
/// Friction \[N·m\] that is rounding.
const LEAST_LOST: f64 = 1e-9;

impl Robot {
    /// What of a model a robot file can hold.
    pub(crate) fn of(model: &Model) -> Result<Self> {
        let chain = model.chain.as_ref().ok_or(ExportError::NoChain)?;
        if !chain.coupling.is_none() {
            return Err(ExportError::Coupled);
        }
        let alone =
            |link: &[f64; 10]| RigidChain { links: vec![*link], drives: vec![], ..chain.clone() };
        if let Some(link) = chain.links.iter().position(|link| !alone(link).is_feasible()) {
            let joint = model.joints.get(link).cloned().unwrap_or_default();
            return Err(ExportError::Infeasible { joint });
        }
        let axes = chain.axes()?;
        let mut placements = axes.placements();
        if let Some(first) = placements.first_mut() {
            let down = Vector3::from(axes.gravity());
            first.rotation = between(&-down, &Vector3::z()).into_inner();
        }
        let (losses, shared, mut left_out) = losses(model, chain);
        let names = chain.robot.as_ref();
        let geometry = joint_geometry(model)?;
        let [efforts, lost] = within_log(model, (&losses, &shared))?;
        left_out.extend(lost_friction(model, &lost));
        let training = &model.training;
        let joints = placements.into_iter().enumerate().map(|(k, frame)| {
            let own = &model.joints[k];
            RobotJoint {
                name: names.map_or_else(|| own.clone(), |names| names.joints[k].clone()),
                link: names.map_or_else(|| format!("{own}_link"), |names| names.links[k].clone()),
                frame,
                kind: chain.kinds.of(k),
                inertial: chain.links[k],
                losses: losses[k],
                range: training.q_range.get(k).copied().unwrap_or([-PI, PI]),
                speed: training.dq_peak.get(k).copied().unwrap_or(0.0),
                effort: efforts[k],
                unresolved: geometry.get(k).and_then(unresolved),
            }
        });
        Ok(Self {
            name: names.map_or_else(|| "arm".to_owned(), |names| names.robot.clone()),
            base: names.map_or_else(|| "base_link".to_owned(), |names| names.base.clone()),
            joints: joints.collect(),
            shared,
            left_out,
        })
    }

    /// What the templates of robot files are filled with; numbers are text.
    pub(crate) fn values(&self, version: &str) -> Value {
        let length: f64 = self.joints.iter().map(|joint| joint.frame.origin.norm()).sum();
        let radius = (RADIUS.0 * length / self.joints.len() as f64).max(RADIUS.1);
        let joints = self.joints.iter().enumerate().map(|(k, joint)| {
            let Body { mass, com, inertia: i } = Body::of_parameters(&joint.inertial);
            let (moments, axes) = principal(i);
            let end = self.joints.get(k + 1).map_or(com, |next| next.frame.origin);
            context! {
                name => &joint.name,
                link => &joint.link,
                kind => joint.kind.name,
                motion => joint.kind.mjcf,
                parent => k.checked_sub(1).map_or(&self.base, |before| &self.joints[before].link),
                origin => numbers(joint.frame.origin.into()),
                rpy => numbers(rpy(&joint.frame.rotation)),
                quaternion => numbers(quaternion(joint.frame.rotation)),
                mass => numbers([mass]),
                center => numbers(com.into()),
                inertia => [i.m11, i.m22, i.m33, i.m12, i.m13, i.m23].map(|x| numbers([x])),
                principal => context! {
                    moments => numbers(moments),
                    quaternion => numbers(quaternion(axes)),
                },
                losses => joint.losses.values(),
                bias => (joint.losses.offset != 0.0).then(|| numbers([-joint.losses.offset])),
                range => joint.range.map(|x| numbers([x])),
                speed => numbers([joint.speed]),
                effort => numbers([joint.effort]),
                strong => joint.effort > 0.0,
                unresolved => &joint.unresolved,
                bar => (end.norm() > radius).then(|| bar(&end)),
            }
        });
        let shared = self.shared.iter().map(|(shaft, losses)| {
            let turns = self.joints.iter().zip(shaft).filter(|(_, part)| **part != 0.0);
            let turns = turns.map(|(joint, part)| [joint.name.clone(), numbers([*part])]);
            context! { losses => losses.values(), turns => turns.collect::<Vec<_>>() }
        });
        context! {
            version,
            name => &self.name,
            base => &self.base,
            joints => joints.collect::<Vec<_>>(),
            shared => shared.collect::<Vec<_>>(),
            radius => numbers([radius]),
            housing => context! {
                radius => numbers([1.5 * radius]),
                length => numbers([4.0 * radius]),
                reach => numbers([2.0 * radius]),
            },
        }
    }
}

/// What the log does not tell of where an axis lies; nothing of one that it tells.
fn unresolved(joint: &JointGeometry) -> Option<String> {
    let lengths = [(joint.distance_to_previous_m, "from"), (joint.along_previous_m, "along")];
    let lengths = lengths.into_iter().filter_map(|(found, how)| Some((found?, how)));
    let least_certain = lengths.max_by(|a, b| a.0.std_error.total_cmp(&b.0.std_error));
    // Of the first axis and of slides there is a direction alone.
    let size = |(Estimated { value, std_error }, how): (Estimated, &str)| {
        format!("{} ± {} m {how} the one before", number(value), number(std_error))
    };
    let size = least_certain.map_or_else(|| "its direction at least".to_owned(), size);
    (!joint.resolved).then(|| {
        format!(
            "not resolved by the log: where this axis lies, {size}: a length may be wrong where the \
             torque is not"
        )
    })
}

/// What is drawn from the origin of a link to that of the next.
fn bar(end: &Vector3<f64>) -> Value {
    let turn = between(&Vector3::z(), end);
    let (length, middle) = (numbers([end.norm()]), numbers((end / 2.0).into()));
    let (end, rpy) = (numbers((*end).into()), numbers(turn.euler_angles().into()));
    context! { end, middle, rpy, length }
}

/// Rotors and friction of each joint, those of shared shafts, and what is left out.
#[expect(clippy::type_complexity, reason = "three fields of a robot")]
fn losses(
    model: &Model,
    chain: &RigidChain,
) -> (Vec<Losses>, Vec<(Vec<f64>, Losses)>, Vec<String>) {
    let n = model.n_joints();
    let mut own = vec![Losses::default(); n];
    let mut shared: Vec<(Vec<f64>, Losses)> = Vec::new();
    let mut left_out = Vec::new();
    let mut at = |shaft: &[f64], change: &dyn Fn(&mut Losses)| {
        let mut turning = (0..n).filter(|&joint| shaft[joint] != 0.0);
        if let (Some(joint), None) = (turning.next(), turning.next())
            && shaft[joint].abs().to_bits() == 1.0_f64.to_bits()
        {
            change(&mut own[joint]);
            return;
        }
        let place = shared.iter().position(|(known, _)| known == shaft).unwrap_or_else(|| {
            shared.push((shaft.to_vec(), Losses::default()));
            shared.len() - 1
        });
        change(&mut shared[place].1);
    };
    for drive in &chain.drives {
        match drive {
            Drive::Rotor { shaft, inertia } => at(shaft, &|own| own.dynamics.armature += inertia),
            Drive::Energy { term, .. } => left_out.push(format!("the energy term {}", term.name())),
        }
    }
    let (mut under_load, mut curved) = (Vec::new(), Vec::new());
    for shaft in ShaftFriction::all(model) {
        let [damping, friction] = shaft.line();
        let FrictionParameters { forward, backward, .. } = shaft.parameters();
        let told: Vec<Estimated> =
            [forward, backward].into_iter().filter_map(|own| own.stiction).collect();
        let breakaway = told.iter().map(|own| own.value).sum::<f64>() / told.len().max(1) as f64;
        let offset = shaft.laws().find(|(_, term)| term.law == FrictionLaw::Offset);
        let held =
            offset.zip(shaft.joint()).map_or(0.0, |((k, _), _)| model.friction[k].coefficient);
        at(shaft.shaft(), &|own| {
            own.dynamics = Dynamics { damping, friction, ..own.dynamics };
            own.breakaway = breakaway.max(friction);
            own.offset = held;
        });
        let laws = || shaft.laws().map(|(_, term)| term);
        let name = shaft.name();
        if laws().any(|term| term.load) {
            under_load.push(name.clone());
        }
        if offset.is_some() && shaft.joint().is_none() {
            left_out.push(format!("the offset torque of {name}"));
        }
        if laws().any(|term| !term.is_straight()) {
            curved.push(name);
        }
    }
    let named = [
        ("friction under load of", under_load, ""),
        ("the curve of the friction of", curved, ": dry and viscous friction are nearest to it"),
    ];
    let named = named.iter().filter(|(_, names, _)| !names.is_empty());
    left_out.extend(named.map(|(what, names, cure)| format!("{what} {}{cure}", names.join(", "))));
    (own, shared, left_out)
}

/// At states within those of the log of a model: the largest torque of each joint, and the RMS of the
/// friction of each that its own and shared losses do not hold \[N·m\], n each.
fn within_log(
    model: &Model,
    (own, shared): (&[Losses], &[(Vec<f64>, Losses)]),
) -> Result<[Vec<f64>; 2]> {
    let (n, training) = (model.n_joints(), &model.training);
    let torque = Torque::new(model);
    let mut random = ChaCha8Rng::seed_from_u64(0);
    let (mut efforts, mut squares) = (vec![0.0_f64; n], vec![0.0; n]);
    let peak = |peaks: &[f64], joint: usize| peaks.get(joint).copied().unwrap_or(1.0);
    for _ in 0..STATES {
        let mut draw = || -> f64 { random.random_range(-1.0..1.0) };
        let position = |joint: usize, unit: f64| {
            let [low, high] = training.q_range.get(joint).copied().unwrap_or([-PI, PI]);
            f64::midpoint(low, high) + 0.5 * (high - low) * unit
        };
        let q: Vec<f64> = (0..n).map(|joint| position(joint, draw())).collect();
        let [dq, ddq] = [&training.dq_peak, &training.ddq_peak]
            .map(|peaks| (0..n).map(|joint| peak(peaks, joint) * draw()).collect::<Vec<f64>>());
        for (largest, tau) in efforts.iter_mut().zip(torque.at(&q, &dq, &ddq)?) {
            *largest = largest.max(tau.abs());
        }
        let mut lost = torque.friction(&q, &dq)?;
        for ((lost, own), speed) in lost.iter_mut().zip(own).zip(&dq) {
            *lost -= own.friction(*speed);
        }
        for (shaft, own) in shared {
            let friction = own.friction(shaft.iter().zip(&dq).map(|(s, v)| s * v).sum());
            lost.iter_mut().zip(shaft).for_each(|(lost, s)| *lost -= s * friction);
        }
        squares.iter_mut().zip(&lost).for_each(|(sum, lost)| *sum += lost * lost);
    }
    let lost = squares.iter().map(|sum| (sum / STATES as f64).sqrt()).collect();
    Ok([efforts, lost])
}

/// How much of the friction of each joint a file does not hold, in words.
fn lost_friction(model: &Model, lost: &[f64]) -> Option<String> {
    let kinds = model.kinds();
    let words = |joint: usize| {
        format!(
            "{} {} of {}",
            number(lost[joint]),
            kinds.of(joint).effort_unit,
            model.joints[joint]
        )
    };
    let joints = (0..lost.len()).filter(|&joint| lost[joint] > LEAST_LOST);
    let lost: Vec<String> = joints.map(words).collect();
    (!lost.is_empty())
        .then(|| format!("friction of {} (RMS within the range of the log)", lost.join(", ")))
}

impl Losses {
    /// Torque \[N·m\] at a speed \[rad/s\].
    fn friction(&self, speed: f64) -> f64 {
        let Dynamics { damping, friction, .. } = self.dynamics;
        damping * speed + if speed == 0.0 { 0.0 } else { friction.copysign(speed) } + self.offset
    }

    fn values(&self) -> Value {
        let Dynamics { armature, damping, friction } = self.dynamics;
        let [armature, damping, friction] = [armature, damping, friction].map(|x| numbers([x]));
        context! { armature, damping, friction }
    }
}

/// Fixed-axis roll, pitch and yaw \[rad\], exact where pitch is a right angle too.
fn rpy(r: &Matrix3<f64>) -> [f64; 3] {
    let pitch = (-r[(2, 0)]).atan2(r[(2, 1)].hypot(r[(2, 2)]));
    let roll = if r[(2, 1)] == 0.0 && r[(2, 2)] == 0.0 { 0.0 } else { r[(2, 1)].atan2(r[(2, 2)]) };
    let (sine, cosine) = roll.sin_cos();
    // What is left once the roll is taken back is a yaw and a pitch.
    let yaw = (sine * r[(0, 2)] - cosine * r[(0, 1)]).atan2(cosine * r[(1, 1)] - sine * r[(1, 2)]);
    [roll, pitch, yaw]
}

/// Principal moments and their axes: a reader need not find them itself, to fewer digits.
fn principal(inertia: Matrix3<f64>) -> ([f64; 3], Matrix3<f64>) {
    let eigen = inertia.symmetric_eigen();
    let mut axes = eigen.eigenvectors;
    if axes.determinant() < 0.0 {
        axes.column_mut(2).neg_mut();
    }
    (eigen.eigenvalues.into(), axes)
}

/// A rotation as a unit quaternion w, x, y, z.
fn quaternion(rotation: Matrix3<f64>) -> [f64; 4] {
    let rotation = Rotation3::from_matrix_unchecked(rotation);
    let q = UnitQuaternion::from_rotation_matrix(&rotation);
    [q.w, q.i, q.j, q.k]
}

fn numbers<const N: usize>(values: [f64; N]) -> String {
    // Rounding of a turn is no number to read.
    let clean = |x: f64| if x.abs() < 1e-16 { 0.0 } else { x };
    values.map(|x| format!("{:?}", clean(x))).join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roll_pitch_and_yaw_give_the_frame_back_near_right_angles_too() {
        let half = std::f64::consts::FRAC_PI_2;
        for pitch in [0.3, half, half - 1e-9, -half, half + 1e-8, -2.0] {
            for (roll, yaw) in [(0.0, 0.0), (0.4, -1.1), (2.8, 3.0)] {
                let rotation = *Rotation3::from_euler_angles(roll, pitch, yaw).matrix();

                let [roll, pitch, yaw] = rpy(&rotation);

                let back = *Rotation3::from_euler_angles(roll, pitch, yaw).matrix();
                assert!((back - rotation).norm() < 1e-14, "{roll} {pitch} {yaw}");
            }
        }
    }
}
