//! Robot files, read back by others than their writer: they move as the model does.

use crate::models::{chain, coupled, energies, sliding, states};
use approx::assert_relative_eq;
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use roxmltree::{Document, Node};
use serde_json::Value;
use std::f64::consts::PI;
use torquewise_export::{ExportError, onto_urdf, to_isaac_lab, to_mjcf, to_urdf};
use torquewise_model::{Drive, FrictionLaw, FrictionTerm, JointKind, Model, Torque, Weighted};
use torquewise_rigid::{Kinematics, MotionState, Moved, Placement};
use torquewise_sim::Arm;

/// The arm without what no robot file holds.
fn bare(mut model: Model) -> Model {
    model.friction.clear();
    if let Some(chain) = &mut model.chain {
        chain.drives.retain(|drive| matches!(drive, Drive::Rotor { .. }));
        let sigma = 0.3;
        for link in &mut chain.links {
            link.iter_mut().skip(4).take(3).for_each(|moment| *moment += sigma);
        }
    }
    model
}

fn number(node: Node<'_, '_>, name: &str) -> f64 {
    node.attribute(name).unwrap().parse().unwrap()
}

fn vector(node: Node<'_, '_>, name: &str) -> Vec<f64> {
    node.attribute(name).unwrap().split(' ').map(|x| x.parse().unwrap()).collect()
}

fn elements<'a, 'i>(node: Node<'a, 'i>, name: &'static str) -> Vec<Node<'a, 'i>> {
    node.descendants().filter(|node| node.has_tag_name(name)).collect()
}

/// Torque of the model less its rotors on shared shafts, which URDF leaves out.
fn without_shared(model: &Model) -> Model {
    let mut model = model.clone();
    let alone = |drive: &Drive| match drive {
        Drive::Rotor { shaft, .. } => shaft.iter().filter(|part| **part != 0.0).count() == 1,
        Drive::Energy { .. } => true,
    };
    model.chain.as_mut().unwrap().drives.retain(alone);
    model
}

#[test]
fn a_urdf_moves_as_the_model() {
    let turning = [(3, false), (6, true), (7, false)].map(|(n, skew)| chain(n, skew, 11));
    for model in turning.into_iter().chain([sliding(4, true, 11), sliding(6, false, 11)]) {
        let (n, mut model) = (model.n_joints(), bare(model));
        model.training.q_range = vec![[-3.0, 3.0]; n];
        let file = to_urdf(&model, "a test").unwrap();
        let document = Document::parse(&file.text).unwrap();
        let dynamics = elements(document.root_element(), "dynamics").into_iter();
        let rotors: Vec<f64> = dynamics.map(|node| number(node, "armature")).collect();
        let arm = Arm::from_urdf(&file.text, &[]).unwrap().with_rotors(&rotors).unwrap();

        assert_eq!(arm.joints(), model.joints);
        assert_eq!(file.left_out.len(), 1, "{:?}", file.left_out);
        model.training.q_range[1] = [0.4; 2];
        let left_out = to_urdf(&model, "a test").unwrap().left_out.join("; ");
        assert!(left_out.contains(&format!("rotor of {}, which never moved", model.joints[1])));
        let torque = Torque::new(&without_shared(&model));
        for [q, dq, ddq] in states(n, 200, 1) {
            let expected = torque.at(&q, &dq, &ddq).unwrap();
            let found = arm.inverse_dynamics(&q, &dq, &ddq);
            assert_relative_eq!(found[..], expected[..], epsilon = 1e-9, max_relative = 1e-11);
        }
    }
}

/// Reads the bodies of an MJCF, one within the other, as MuJoCo does.
fn kinematics(text: &str) -> (Kinematics, Vec<f64>) {
    let document = Document::parse(text).unwrap();
    let rotation = |w: Vec<f64>| -> Matrix3<f64> {
        let unit = UnitQuaternion::from_quaternion(Quaternion::new(w[0], w[1], w[2], w[3]));
        *unit.to_rotation_matrix().matrix()
    };
    let (mut placements, mut inertial, mut kinds) = (Vec::new(), Vec::new(), Vec::new());
    for body in elements(document.root_element(), "body") {
        let origin = Vector3::from_column_slice(&vector(body, "pos"));
        placements.push(Placement { rotation: rotation(vector(body, "quat")), origin });
        let own = body.children().find(|node| node.has_tag_name("inertial")).unwrap();
        let joint = body.children().find(|node| node.has_tag_name("joint")).unwrap();
        kinds.push(match joint.attribute("type").unwrap() {
            "hinge" => JointKind::Revolute,
            "slide" => JointKind::Prismatic,
            other => unreachable!("{other}"),
        });
        let center = Vector3::from_column_slice(&vector(own, "pos"));
        let turned = rotation(vector(own, "quat"));
        let moments =
            Matrix3::from_diagonal(&Vector3::from_column_slice(&vector(own, "diaginertia")));
        let mass = number(own, "mass");
        let shift = Matrix3::identity() * center.norm_squared() - center * center.transpose();
        let i = turned * moments * turned.transpose() + mass * shift;
        let first = mass * center;
        inertial.extend([mass, first.x, first.y, first.z, i.m11, i.m22, i.m33]);
        inertial.extend([i.m12, i.m13, i.m23]);
    }
    (Kinematics::of_frames(placements, kinds.into(), [0.0, 0.0, -9.81]), inertial)
}

#[test]
fn an_mjcf_moves_as_the_model() {
    let turning = [(3, true), (6, false), (7, true)].map(|(n, skew)| chain(n, skew, 12));
    for model in turning.into_iter().chain([sliding(4, true, 12), sliding(6, false, 12)]) {
        let (n, model) = (model.n_joints(), bare(model));
        let file = to_mjcf(&model, "a test").unwrap();
        let (kinematics, inertial) = kinematics(&file.text);
        let document = Document::parse(&file.text).unwrap();
        let mut hinges = elements(document.root_element(), "joint");
        hinges.retain(|joint| joint.has_attribute("axis"));
        let tendon = elements(document.root_element(), "fixed")[0];

        assert!(file.left_out.is_empty());
        let torque = Torque::new(&model);
        for [q, dq, ddq] in states(n, 200, 1) {
            let mut found = vec![0.0; n];
            let state = MotionState { q: &q, dq: &dq, ddq: &ddq };
            let mut moved = Moved::default();
            kinematics.move_into(state, &mut moved);
            moved.torque(&inertial, &mut found);
            for joint in 0..n {
                found[joint] += number(hinges[joint], "armature") * ddq[joint];
            }
            let turned = |node: Node<'_, '_>| {
                let joint = node.attribute("joint").unwrap();
                let place = model.joints.iter().position(|name| name == joint).unwrap();
                (place, number(node, "coef"))
            };
            let turned: Vec<_> = elements(tendon, "joint").into_iter().map(turned).collect();
            let turning: f64 = turned.iter().map(|(joint, coef)| coef * ddq[*joint]).sum();
            for (joint, coef) in turned {
                found[joint] += number(tendon, "armature") * coef * turning;
            }
            let expected = torque.at(&q, &dq, &ddq).unwrap();
            assert_relative_eq!(found[..], expected[..], epsilon = 1e-9, max_relative = 1e-11);
        }
    }
}

#[test]
fn what_no_robot_file_holds_is_named() {
    let model = chain(3, false, 5);
    let file = to_urdf(&bare_links(model.clone()), "a test").unwrap();

    let all = file.left_out.join("; ");
    for part in ["the energy term V: cos(q2)", "the offset torque of", "the curve of the friction"]
    {
        assert!(all.contains(part), "{part} in {all}");
    }
    let holds = to_mjcf(&bare_links(chain(3, false, 5)), "a test").unwrap();
    assert!(!holds.left_out.join("; ").contains("offset"));
    let document = Document::parse(&holds.text).unwrap();
    for offset in model.friction.iter().filter(|own| own.term.law == FrictionLaw::Offset) {
        let joint = offset.term.shaft.iter().position(|part| *part != 0.0).unwrap();
        let motors = elements(document.root_element(), "general");
        let own = motors.iter().find(|own| own.attribute("joint") == Some(&model.joints[joint]));
        assert_eq!(vector(*own.unwrap(), "biasprm"), [-offset.coefficient, 0.0, 0.0]);
    }
    assert!(matches!(to_urdf(&energies(3, 25, 1), ""), Err(ExportError::NoChain)));
    let parallel = to_mjcf(&bare_links(coupled(3, true, 8)), "");
    assert!(matches!(parallel, Err(ExportError::Coupled)));
    let mut weightless = bare(chain(3, false, 1));
    weightless.chain.as_mut().unwrap().links[1][0] = -1.0;
    let refused = to_urdf(&weightless, "").unwrap_err().to_string();
    assert!(refused.contains(&weightless.joints[1]), "{refused}");
}

#[test]
fn what_friction_a_file_does_not_hold_is_counted() {
    let whole = chain(3, false, 5);
    let mut model = bare(whole.clone());
    // So slow that the line of dry and viscous friction sees nothing of it.
    model.training.dq_peak = vec![1.0; 3];
    let (speed, coefficient) = (0.02, 7.0);
    let law = FrictionLaw::Stribeck { speed, width: 0.0 };
    let term = FrictionTerm::of_joint(3, 1, law);
    model.friction = vec![Weighted { term, coefficient, ..whole.friction[0].clone() }];

    let left_out = to_urdf(&model, "").unwrap().left_out.join("; ");

    // RMS of c·exp(-(v/s)²) over speeds up to 1: c·(s/2·√(π/2))^(1/2), of 2000 states.
    let expected = coefficient * (0.5 * speed * (PI / 2.0).sqrt()).sqrt();
    let (found, _) = left_out.rsplit_once(&format!(" N·m of {} (RMS", model.joints[1])).unwrap();
    let found: f64 = found.rsplit_once("friction of ").unwrap().1.parse().unwrap();
    assert_relative_eq!(found, expected, max_relative = 0.3);
}

/// The same with links that can be.
fn bare_links(mut model: Model) -> Model {
    let links = bare(chain(model.n_joints(), false, 5)).chain.unwrap().links;
    model.chain.as_mut().unwrap().links = links;
    model
}

#[test]
fn friction_that_a_file_does_not_hold_is_told_in_the_units_of_its_joint() {
    let model = sliding(3, false, 11);
    let told = to_urdf(&model, "").unwrap().left_out.join("; ");

    let [turn, slide, _] = &model.joints[..] else { unreachable!("three joints") };
    assert!(told.contains(&format!(" N·m of {turn}, ")), "{told}");
    assert!(told.contains(&format!(" N of {slide}, ")), "{told}");
}

#[test]
fn a_urdf_whose_axes_lie_elsewhere_is_refused() {
    let model = bare(chain(3, false, 11));
    let text = to_urdf(&model, "").unwrap().text;
    let other = to_urdf(&bare(chain(3, true, 12)), "").unwrap().text;
    let slid = to_urdf(&bare(sliding(3, false, 11)), "").unwrap().text;
    let refused = onto_urdf(&model, &slid, &[]).unwrap_err();
    assert!(matches!(refused, ExportError::OtherGeometry { joint } if joint == model.joints[1]));

    let onto = onto_urdf(&without_shared(&model), &text, &[]).unwrap();

    // Its own file takes up the same numbers: a turn about an axis and back is rounding.
    let [old, new] = [&text, &onto.text].map(|text| Arm::from_urdf(text, &[]).unwrap());
    for [q, dq, ddq] in states(3, 20, 1) {
        let [new, old] = [&new, &old].map(|arm| arm.inverse_dynamics(&q, &dq, &ddq));
        assert_relative_eq!(new[..], old[..], epsilon = 1e-9, max_relative = 1e-11);
    }
    let refused = onto_urdf(&model, &other, &[]).unwrap_err();
    assert!(matches!(refused, ExportError::OtherGeometry { .. }), "{refused}");
    let parts = ["gravity is 5.7°", "0.100", "-0.995"];
    let is_tilted = |left_out: &String| parts.iter().all(|part| left_out.contains(part));
    assert!(!onto.left_out.iter().any(is_tilted), "{:?}", onto.left_out);
    let mut tilted = without_shared(&model);
    tilted.chain.as_mut().unwrap().geometry[0] += 0.1;
    let onto = onto_urdf(&tilted, &text, &[]).unwrap();
    assert!(onto.left_out.iter().any(is_tilted), "{:?}", onto.left_out);
}

#[test]
fn a_joint_of_isaac_lab_breaks_away_and_slides_as_the_model() {
    let mut model = bare(chain(3, false, 5));
    model.joints[0] = "base.yaw".into();
    model.training.dq_peak = vec![1.0; 3];
    let (coulomb, stribeck) =
        (FrictionLaw::Coulomb { width: 0.0 }, FrictionLaw::Stribeck { speed: 0.02, width: 0.0 });
    let laws = [
        (0, coulomb, 2.0),
        (0, stribeck, 1.0),
        (0, FrictionLaw::Viscous, 0.5),
        (1, coulomb, 4.0),
        (1, stribeck, -3.0),
        (1, FrictionLaw::Offset, 0.1),
    ];
    model.friction = laws
        .map(|(joint, law, value)| Weighted::new(FrictionTerm::of_joint(3, joint, law), value))
        .into();

    let file = to_isaac_lab(&model).unwrap();

    let joints: Value = serde_json::from_str(&file.text).unwrap();
    let of = |what: &str| -> [f64; 3] {
        let names = joints["joint_names_expr"].as_array().unwrap();
        std::array::from_fn(|k| joints[what][names[k].as_str().unwrap()].as_f64().unwrap())
    };
    assert_eq!(joints["joint_names_expr"][0], "base\\.yaw");
    // Friction that rises from rest breaks away no sooner than it slides.
    assert_relative_eq!(of("friction")[..], [3.0, 4.0, 0.0], max_relative = 1e-6);
    assert_relative_eq!(of("dynamic_friction")[..], [2.0, 4.0, 0.0], max_relative = 1e-6);
    assert_relative_eq!(of("viscous_friction")[..], [0.5, 0.0, 0.0], epsilon = 1e-6);
    let urdf = to_urdf(&model, "").unwrap().text;
    let urdf = Document::parse(&urdf).unwrap();
    let rotors = elements(urdf.root_element(), "dynamics").into_iter();
    assert!(rotors.map(|own| number(own, "armature")).eq(of("armature")));
    assert!(file.left_out.join("; ").contains(&format!("offset torque of {}", model.joints[1])));
}
