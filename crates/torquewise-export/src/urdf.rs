//! From model to URDF: written from the model alone, or put into a URDF of the arm.

use crate::error::ExportError;
use crate::robot::{Central, Losses, Robot, RobotJoint, numbers};
use crate::xml::Xml;
use nalgebra::{Rotation3, Vector3};
use torquewise_model::Model;
use torquewise_sim::UrdfChain;
use torquewise_sim::urdf::edit::{Change, Dynamics, edited};

/// Radius of the links that are drawn, as a part of the length of the arm, and at least \[m\].
const RADIUS: (f64, f64) = (0.04, 0.005);
/// Colour of links and of joints.
const COLOURS: [(&str, &str); 2] = [("link", "0.75 0.75 0.78 1"), ("joint", "0.2 0.35 0.6 1")];
/// Two geometries are one if their parameters are within this \[rad, m\].
const SAME: f64 = 1e-6;

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
pub fn to_urdf(model: &Model, version: &str) -> Result<RobotFile, ExportError> {
    let robot = Robot::of(model)?;
    let mut xml = Xml::new();
    xml.comment(version);
    let radius = radius(&robot);
    xml.open("robot", &[("name", &robot.name)]);
    for (name, rgba) in COLOURS {
        xml.open("material", &[("name", name)]);
        xml.leaf("color", &[("rgba", rgba)]);
        xml.close("material");
    }
    xml.leaf("link", &[("name", &robot.base)]);
    for (k, joint) in robot.joints.iter().enumerate() {
        xml.open("link", &[("name", &joint.link)]);
        inertial(&mut xml, &joint.central());
        let end =
            robot.joints.get(k + 1).map_or_else(|| joint.central().center, |next| next.origin);
        visuals(&mut xml, &end, radius);
        xml.close("link");
    }
    let mut parent = &robot.base;
    for joint in &robot.joints {
        hinge(&mut xml, joint, parent);
        parent = &joint.link;
    }
    xml.close("robot");
    let mut left_out = robot.left_out.clone();
    left_out.extend(shared_shafts(&robot));
    Ok(RobotFile { text: xml.finish()?, left_out })
}

/// A URDF of the arm with the inertia and friction of a model: `<inertial>` of the links that move
/// and `<dynamics>` of the joints of the model; every other byte stays.
///
/// A link that is welded to another keeps its inertia where what is left is a body; else the first
/// link carries all.
///
/// - `text`: the file; the model was fitted with its geometry
/// - `locked`: joints that are held at 0, where names do not tell
///
/// # Errors
/// As [`to_urdf`]; [`ExportError::Urdf`] if it is no URDF of these joints,
/// [`ExportError::OtherGeometry`] if its axes lie elsewhere.
pub fn onto_urdf(model: &Model, text: &str, locked: &[String]) -> Result<RobotFile, ExportError> {
    let robot = Robot::of(model)?;
    let geometry = model.chain.as_ref().ok_or(ExportError::NoChain)?.axes()?;
    let chain = model.chain.as_ref().and_then(|chain| chain.robot.as_ref());
    let names = chain.map_or(&model.joints, |names| &names.joints);
    let down = None;
    let chain = UrdfChain::of_joints(text, names, locked, down)?;
    let tilt = torquewise_rigid::geometry::PER_BASE;
    let pairs = || chain.geometry().parameters()[tilt..].iter().zip(&geometry.parameters()[tilt..]);
    if let Some(k) = pairs().position(|(a, b)| (a - b).abs() > SAME) {
        let joint = names[k / torquewise_rigid::geometry::PER_JOINT + 1].clone();
        return Err(ExportError::OtherGeometry { joint });
    }
    let mut changes = Vec::new();
    let mut left_out = robot.left_out.clone();
    left_out.extend(shared_shafts(&robot));
    for (joint, own) in chain.joints().iter().zip(&robot.joints) {
        let (inertials, kept) = joint.distributed(&own.inertial);
        if !kept {
            left_out.push(format!(
                "the masses of {}: {} carries them",
                joint.links[1..].join(", "),
                joint.links[0]
            ));
        }
        changes.extend(inertials.into_iter().map(|(link, body)| Change::Inertial { link, body }));
        let Losses { armature, damping, friction } = own.losses;
        let dynamics = Dynamics { armature, damping, friction };
        changes.push(Change::Dynamics { joint: joint.name.clone(), dynamics });
    }
    Ok(RobotFile { text: edited(text, &changes)?, left_out })
}

/// What URDF cannot say of shafts that several joints turn.
fn shared_shafts(robot: &Robot) -> Vec<String> {
    let name = |shaft: &[f64]| -> String {
        let turning = robot.joints.iter().zip(shaft).filter(|(_, part)| **part != 0.0);
        turning.map(|(joint, _)| joint.name.as_str()).collect::<Vec<_>>().join(" and ")
    };
    let words = |own: &crate::robot::SharedShaft| {
        format!("rotor and friction of the shaft that {} share", name(&own.shaft))
    };
    robot.shared.iter().map(words).collect()
}

fn inertial(xml: &mut Xml, body: &Central) {
    let [i, c] = [&body.inertia, &body.inertia];
    xml.open("inertial", &[]);
    xml.leaf("origin", &[("xyz", &numbers(body.center.into())), ("rpy", "0 0 0")]);
    xml.leaf("mass", &[("value", &numbers([body.mass]))]);
    let names = ["ixx", "iyy", "izz", "ixy", "ixz", "iyz"];
    let moments = [i.m11, i.m22, i.m33, c.m12, c.m13, c.m23].map(|moment| numbers([moment]));
    let moments: Vec<(&str, &str)> =
        names.into_iter().zip(moments.iter().map(String::as_str)).collect();
    xml.leaf("inertia", &moments);
    xml.close("inertial");
}

/// Radius \[m\] of what is drawn of an arm.
pub(crate) fn radius(robot: &Robot) -> f64 {
    let length: f64 = robot.joints.iter().map(|joint| joint.origin.norm()).sum();
    (RADIUS.0 * length / robot.joints.len() as f64).max(RADIUS.1)
}

/// A housing along the axis, and a bar to the next.
fn visuals(xml: &mut Xml, end: &Vector3<f64>, radius: f64) {
    cylinder(xml, &Vector3::zeros(), [0.0; 3], (1.5 * radius, 4.0 * radius), "joint");
    let length = end.norm();
    if length > radius {
        let turn = Rotation3::rotation_between(&Vector3::z(), end).unwrap_or_else(|| {
            Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
        });
        let (roll, pitch, yaw) = turn.euler_angles();
        cylinder(xml, &(end / 2.0), [roll, pitch, yaw], (radius, length), "link");
    }
}

fn cylinder(
    xml: &mut Xml,
    middle: &Vector3<f64>,
    rpy: [f64; 3],
    (radius, length): (f64, f64),
    material: &str,
) {
    xml.open("visual", &[]);
    xml.leaf("origin", &[("xyz", &numbers((*middle).into())), ("rpy", &numbers(rpy))]);
    xml.open("geometry", &[]);
    xml.leaf("cylinder", &[("radius", &numbers([radius])), ("length", &numbers([length]))]);
    xml.close("geometry");
    xml.leaf("material", &[("name", material)]);
    xml.close("visual");
}

fn hinge(xml: &mut Xml, joint: &RobotJoint, parent: &str) {
    let Losses { armature, damping, friction } = joint.losses;
    let [low, high] = joint.range;
    xml.open("joint", &[("name", &joint.name), ("type", "revolute")]);
    xml.leaf("parent", &[("link", parent)]);
    xml.leaf("child", &[("link", &joint.link)]);
    let (xyz, rpy) = (numbers(joint.origin.into()), numbers(joint.rpy()));
    xml.leaf("origin", &[("xyz", &xyz), ("rpy", &rpy)]);
    xml.leaf("axis", &[("xyz", "0 0 1")]);
    xml.leaf(
        "limit",
        &[
            ("lower", &numbers([low])),
            ("upper", &numbers([high])),
            ("effort", &numbers([joint.effort])),
            ("velocity", &numbers([joint.speed])),
        ],
    );
    xml.leaf(
        "dynamics",
        &[
            ("damping", &numbers([damping])),
            ("friction", &numbers([friction])),
            ("armature", &numbers([armature])),
        ],
    );
    xml.close("joint");
}
