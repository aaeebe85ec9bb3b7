//! What a robot file holds of a model: links, joints, rotors, friction; what is left out.

use crate::{ExportError, Result};
use minijinja::{Value, context};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;
use torquewise_model::learned::{JointGeometry, joint_geometry};
use torquewise_model::shaft_friction::{Estimated, FrictionParameters, ShaftFriction};
use torquewise_model::{Drive, FrictionLaw, Model, RigidChain, Torque, Training, number};
use torquewise_rigid::Placement;
use torquewise_rigid::geometry::between;
use torquewise_sim::Body;
use torquewise_sim::urdf::edit::Dynamics;

/// A chain and what its file says; of vectors by joint, each with the link that it turns, n.
#[derive(Clone, Debug)]
pub(crate) struct Robot<'a> {
    model: &'a Model,
    pub(crate) chain: &'a RigidChain,
    /// Names of the joints.
    pub(crate) joints: Vec<String>,
    links: Vec<String>,
    /// The frame of each joint, the axis z, at q = 0 in the one before; of the first in the world,
    /// z up.
    frames: Vec<Placement>,
    pub(crate) losses: Vec<Losses>,
    /// Largest torque \[N·m\] that the model asks for within the motion of the log.
    efforts: Vec<f64>,
    /// Rotors and friction on shafts that several joints turn: the speed of the shaft per speed of
    /// each joint, n, and what turns and rubs on it.
    pub(crate) shared: Vec<(Vec<f64>, Losses)>,
    /// Parts of the model that no robot file has room for.
    pub(crate) left_out: Vec<String>,
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

impl<'a> Robot<'a> {
    /// What of a model a robot file can hold.
    pub(crate) fn of(model: &'a Model) -> Result<Self> {
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
        let mut frames = axes.placements();
        if let Some(first) = frames.first_mut() {
            let down = Vector3::from(axes.gravity());
            first.rotation = between(&-down, &Vector3::z()).into_inner();
        }
        let (losses, shared, mut left_out) = losses(model, chain);
        let [efforts, lost] = within_log(model, (&losses, &shared))?;
        left_out.extend(lost_friction(model, &lost));
        let still = Training::constant_joints(&model.training.q_range).into_iter();
        let still: Vec<&str> = still.map(|joint| model.joints[joint].as_str()).collect();
        if !still.is_empty() {
            left_out.push(format!(
                "the true friction and rotor of {}, which never moved: the file holds guesses",
                still.join(", ")
            ));
        }
        let (joints, links) = if let Some(names) = &chain.robot {
            (names.joints.clone(), names.links.clone())
        } else {
            let link = |joint| format!("{joint}_link");
            (model.joints.clone(), model.joints.iter().map(link).collect())
        };
        Ok(Self { model, chain, joints, links, frames, losses, efforts, shared, left_out })
    }

    /// What the templates of robot files are filled with; numbers are text.
    pub(crate) fn values(&self, version: &str) -> Result<Value> {
        let (chain, training) = (self.chain, &self.model.training);
        let [name, base] = match &chain.robot {
            Some(names) => [&names.robot, &names.base].map(String::as_str),
            None => ["arm", "base_link"],
        };
        let geometry = joint_geometry(self.model)?;
        let length: f64 = self.frames.iter().map(|frame| frame.origin.norm()).sum();
        let radius = (RADIUS.0 * length / self.frames.len() as f64).max(RADIUS.1);
        let joints = self.frames.iter().enumerate().map(|(k, frame)| {
            let Body { mass, com, inertia: i } = Body::of_parameters(&chain.links[k]);
            let (moments, axes) = principal(i);
            let end = self.frames.get(k + 1).map_or(com, |next| next.origin);
            let (kind, losses, effort) = (chain.kinds.of(k), self.losses[k], self.efforts[k]);
            let range = training.q_range.get(k).copied().unwrap_or([-PI, PI]);
            context! {
                name => &self.joints[k],
                link => &self.links[k],
                kind => kind.name,
                motion => kind.mjcf,
                parent => k.checked_sub(1).map_or(base, |before| &self.links[before]),
                origin => numbers(frame.origin.into()),
                rpy => numbers(rpy(&frame.rotation)),
                quaternion => numbers(quaternion(frame.rotation)),
                mass => numbers([mass]),
                center => numbers(com.into()),
                inertia => [i.m11, i.m22, i.m33, i.m12, i.m13, i.m23].map(|x| numbers([x])),
                principal => context! {
                    moments => numbers(moments),
                    quaternion => numbers(quaternion(axes)),
                },
                losses => losses.values(),
                bias => (losses.offset != 0.0).then(|| numbers([-losses.offset])),
                range => range.map(|x| numbers([x])),
                speed => numbers([training.dq_peak.get(k).copied().unwrap_or(0.0)]),
                effort => numbers([effort]),
                strong => effort > 0.0,
                unresolved => geometry.get(k).and_then(unresolved),
                bar => (end.norm() > radius).then(|| bar(&end)),
            }
        });
        let shared = self.shared.iter().map(|(shaft, losses)| {
            let turns = self.joints.iter().zip(shaft).filter(|(_, part)| **part != 0.0);
            let turns = turns.map(|(joint, part)| [joint.clone(), numbers([*part])]);
            context! { losses => losses.values(), turns => turns.collect::<Vec<_>>() }
        });
        Ok(context! {
            version, name, base,
            joints => joints.collect::<Vec<_>>(),
            shared => shared.collect::<Vec<_>>(),
            radius => numbers([radius]),
            housing => context! {
                radius => numbers([1.5 * radius]),
                length => numbers([4.0 * radius]),
                reach => numbers([2.0 * radius]),
            },
        })
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
