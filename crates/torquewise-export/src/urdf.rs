//! A model as URDF or MJCF, alone or put into the URDF of the arm, and its joints for PhysX.

use crate::near::near;
use crate::robot::{Losses, Robot};
use crate::{ExportError, Result, filled};
use nalgebra::Vector3;
use serde_json::{Map, Value, json};
use torquewise_model::Model;
use torquewise_rigid::geometry::PER_JOINT;
use torquewise_rigid::{Geometry, PER_BASE};
use torquewise_sim::UrdfChain;
use torquewise_sim::urdf::edit::edited;

/// Two geometries are one if their parameters are within this \[rad, m\].
const SAME: f64 = 1e-6;

/// Less of a tilt is not said \[°\].
const LEAST_TILT: f64 = 0.1;

/// A robot file, and the parts of the model that it has no room for.
#[derive(Clone, Debug)]
pub struct RobotFile {
    /// The text.
    pub text: String,
    /// What is left out, in words.
    pub left_out: Vec<String>,
}

/// The URDF of a model: links with inertia and simple visuals between the axes, joints with the
/// ranges of the log, dry and viscous friction, and the inertia of rotors as `armature` of
/// `<dynamics>`.
///
/// # Errors
/// [`ExportError::NoChain`], [`ExportError::Coupled`], [`ExportError::Infeasible`].
pub fn to_urdf(model: &Model, version: &str) -> Result<RobotFile> {
    let robot = Robot::of(model)?;
    let text = filled("xml", include_str!("templates/robot.urdf.j2"), robot.values(version)?)?;
    Ok(RobotFile { text, left_out: left_out_of_urdf(&robot) })
}

/// The MJCF of a model: bodies with inertia and capsules between the axes, hinges without limits,
/// which the log does not tell, with `armature`, `damping` and `frictionloss`, a motor for each,
/// which holds the offset of its torque by itself; shafts that several joints turn are fixed
/// tendons. A comment says where the log leaves an axis open, as in a URDF.
///
/// # Errors
/// As [`to_urdf`].
pub fn to_mjcf(model: &Model, version: &str) -> Result<RobotFile> {
    let robot = Robot::of(model)?;
    let text = filled("xml", include_str!("templates/robot.mjcf.j2"), robot.values(version)?)?;
    Ok(RobotFile { text, left_out: robot.left_out })
}

/// The joints of a model as Isaac Lab takes them (`ImplicitActuatorCfg`), JSON: armature and the
/// friction of `PhysX` 5, by joint. A joint at rest begins to move above `friction`, its breakaway; one
/// that moves is held by `dynamic_friction`, and by `viscous_friction` times its speed.
///
/// # Errors
/// As [`to_urdf`].
pub fn to_isaac_lab(model: &Model) -> Result<RobotFile> {
    let robot = Robot::of(model)?;
    let of = |number: fn(&Losses) -> f64| -> Map<String, Value> {
        let joints = robot.joints.iter().zip(&robot.losses);
        joints.map(|(joint, losses)| (pattern(joint), number(losses).into())).collect()
    };
    let file = json!({
        "joint_names_expr": robot.joints.iter().map(|own| pattern(own)).collect::<Vec<_>>(),
        "armature": of(|own| own.dynamics.armature),
        "friction": of(|own| own.breakaway),
        "dynamic_friction": of(|own| own.dynamics.friction),
        "viscous_friction": of(|own| own.dynamics.damping),
    });
    Ok(RobotFile { text: format!("{file:#}\n"), left_out: left_out_of_urdf(&robot) })
}

/// The regular expression of a name.
fn pattern(name: &str) -> String {
    let escaped = |c: char| if ".^$*+?{}[]\\|()".contains(c) { Some('\\') } else { None };
    name.chars().flat_map(|c| escaped(c).into_iter().chain([c])).collect()
}

/// A URDF of the arm with the inertia and friction of a model: `<inertial>` of the links that move
/// and `<dynamics>` of the joints of the model; every other byte stays.
///
/// What the log does not tell of a link stays near what the file has, and bodies stay possible. A
/// link that is welded to another keeps its inertia where what is left is a body; else the first
/// link carries all.
///
/// - `text`: the file; the model was fitted with its geometry
/// - `locked`: joints that are held at 0, where names do not tell
///
/// # Errors
/// As [`to_urdf`]; [`ExportError::Urdf`] if it is no URDF of these joints,
/// [`ExportError::OtherGeometry`] if its axes lie elsewhere.
pub fn onto_urdf(model: &Model, text: &str, locked: &[String]) -> Result<RobotFile> {
    let Robot { chain, joints: names, .. } = &Robot::of(model)?;
    let geometry = chain.axes()?;
    let chain = UrdfChain::of_joints(text, names, locked, None)?;
    let kinds = [&chain.geometry, &geometry].map(Geometry::kinds);
    let other_kind = (0..names.len()).find(|&joint| kinds[0].of(joint) != kinds[1].of(joint));
    let [of_file, of_model] = [&chain.geometry, &geometry].map(|own| &own.parameters()[PER_BASE..]);
    let other_place = || of_file.iter().zip(of_model).position(|(a, b)| (a - b).abs() > SAME);
    if let Some(joint) = other_kind.or_else(|| Some(other_place()? / PER_JOINT + 1)) {
        return Err(ExportError::OtherGeometry { joint: names[joint].clone() });
    }
    let nominal: Vec<_> = chain.joints.iter().map(|joint| joint.inertial_of_file).collect();
    let model = near(model, &nominal)?;
    let robot = Robot::of(&model)?;
    let (mut bodies, mut dynamics) = (Vec::new(), Vec::new());
    let mut left_out = left_out_of_urdf(&robot);
    let [said, found] = [&chain.geometry, &geometry].map(|own| Vector3::from(own.gravity()));
    let tilt = said.angle(&found).to_degrees();
    if tilt > LEAST_TILT {
        // As it is printed, without -0.000.
        let along = |row| (1e3 * Vector3::from(row).dot(&found.normalize())).round() / 1e3 + 0.0;
        let [x, y, z] = chain.base_of_geometry.map(along);
        left_out.push(format!(
            "that gravity is {tilt:.1}° from where the base of the file has it, along \
             ({x:.3}, {y:.3}, {z:.3})"
        ));
    }
    let known = robot.chain.links.iter().zip(&robot.losses);
    for (joint, (link, losses)) in chain.joints.iter().zip(known) {
        let (inertials, kept) = joint.distributed(link);
        if !kept {
            let (first, others) = (&joint.links[0], joint.links[1..].join(", "));
            left_out.push(format!("the masses of {others}: {first} carries them"));
        }
        bodies.extend(inertials);
        dynamics.push((joint.name.clone(), losses.dynamics));
    }
    Ok(RobotFile { text: edited(text, &bodies, &dynamics)?, left_out })
}

/// What neither a URDF nor a joint of `PhysX` has room for: offsets, and what belongs to shafts that
/// several joints turn.
fn left_out_of_urdf(robot: &Robot<'_>) -> Vec<String> {
    let words = |(shaft, _): &(Vec<f64>, Losses)| {
        let turning = robot.joints.iter().zip(shaft).filter(|(_, part)| **part != 0.0);
        let names: Vec<&str> = turning.map(|(joint, _)| joint.as_str()).collect();
        format!("rotor and friction of the shaft that {} share", names.join(" and "))
    };
    let offset = robot.joints.iter().zip(&robot.losses).filter(|(_, own)| own.offset != 0.0);
    let offset: Vec<&str> = offset.map(|(joint, _)| joint.as_str()).collect();
    let offset =
        (!offset.is_empty()).then(|| format!("the offset torque of {}", offset.join(", ")));
    robot.left_out.iter().cloned().chain(offset).chain(robot.shared.iter().map(words)).collect()
}
