//! From model to MJCF, the format of MuJoCo.

use crate::error::ExportError;
use crate::robot::{Losses, Robot, RobotJoint, numbers, quaternion};
use crate::urdf::{RobotFile, radius};
use crate::xml::Xml;
use torquewise_model::Model;

/// The MJCF of a model: bodies with inertia and capsules between the axes, hinges with `armature`,
/// `damping` and `frictionloss`, a motor for each; shafts that several joints turn are fixed
/// tendons.
///
/// # Errors
/// [`ExportError::NoChain`], [`ExportError::Coupled`], [`ExportError::Infeasible`].
pub fn to_mjcf(model: &Model, version: &str) -> Result<RobotFile, ExportError> {
    let robot = Robot::of(model)?;
    let mut xml = Xml::new();
    xml.comment(version);
    let radius = radius(&robot);
    xml.open("mujoco", &[("model", &robot.name)]);
    xml.leaf("compiler", &[("angle", "radian"), ("autolimits", "true")]);
    xml.leaf("option", &[("gravity", "0 0 -9.81"), ("integrator", "implicitfast")]);
    xml.open("worldbody", &[]);
    for (k, joint) in robot.joints.iter().enumerate() {
        let end =
            robot.joints.get(k + 1).map_or_else(|| joint.central().center, |next| next.origin);
        body(&mut xml, joint, end.into(), radius);
    }
    robot.joints.iter().for_each(|_| xml.close("body"));
    xml.close("worldbody");
    if !robot.shared.is_empty() {
        xml.open("tendon", &[]);
        for (k, own) in robot.shared.iter().enumerate() {
            let [armature, damping, friction] = losses(&own.losses);
            let name = format!("shaft{}", k + 1);
            xml.open(
                "fixed",
                &[
                    ("name", &name),
                    ("armature", &armature),
                    ("damping", &damping),
                    ("frictionloss", &friction),
                ],
            );
            for (joint, part) in robot.joints.iter().zip(&own.shaft).filter(|(_, s)| **s != 0.0) {
                xml.leaf("joint", &[("joint", &joint.name), ("coef", &numbers([*part]))]);
            }
            xml.close("fixed");
        }
        xml.close("tendon");
    }
    xml.open("actuator", &[]);
    for joint in &robot.joints {
        let range = numbers([-joint.effort, joint.effort]);
        let attributes = [("name", joint.name.as_str()), ("joint", &joint.name)];
        if joint.effort > 0.0 {
            xml.leaf("motor", &[&attributes[..], &[("ctrlrange", &range)]].concat());
        } else {
            xml.leaf("motor", &attributes);
        }
    }
    xml.close("actuator");
    xml.close("mujoco");
    Ok(RobotFile { text: xml.finish()?, left_out: robot.left_out })
}

/// Begins a body, which the next is in.
fn body(xml: &mut Xml, joint: &RobotJoint, end: [f64; 3], radius: f64) {
    let (pos, quat) = (numbers(joint.origin.into()), numbers(quaternion(joint.rotation)));
    xml.open("body", &[("name", &joint.link), ("pos", &pos), ("quat", &quat)]);
    let central = joint.central();
    let (moments, axes) = central.principal();
    xml.leaf(
        "inertial",
        &[
            ("pos", &numbers(central.center.into())),
            ("quat", &numbers(quaternion(axes))),
            ("mass", &numbers([central.mass])),
            ("diaginertia", &numbers(moments)),
        ],
    );
    let [armature, damping, friction] = losses(&joint.losses);
    xml.leaf(
        "joint",
        &[
            ("name", &joint.name),
            ("type", "hinge"),
            ("axis", "0 0 1"),
            ("range", &numbers(joint.range)),
            ("armature", &armature),
            ("damping", &damping),
            ("frictionloss", &friction),
        ],
    );
    let drawn = [("contype", "0"), ("conaffinity", "0"), ("group", "1"), ("mass", "0")];
    let (length, [x, y, z]) = (2.0 * radius, end);
    let housing = [
        ("type", "cylinder"),
        ("fromto", &*numbers([0.0, 0.0, -length, 0.0, 0.0, length])),
        ("size", &*numbers([1.5 * radius])),
        ("rgba", "0.2 0.35 0.6 1"),
    ];
    xml.leaf("geom", &[&housing[..], &drawn].concat());
    if x.hypot(y).hypot(z) > radius {
        let bar = [
            ("type", "capsule"),
            ("fromto", &*numbers([0.0, 0.0, 0.0, x, y, z])),
            ("size", &*numbers([radius])),
            ("rgba", "0.75 0.75 0.78 1"),
        ];
        xml.leaf("geom", &[&bar[..], &drawn].concat());
    }
}

fn losses(Losses { armature, damping, friction }: &Losses) -> [String; 3] {
    [armature, damping, friction].map(|x| numbers([*x]))
}
