//! URDF to the geometry of a fit and back: bodies put into the file move as they did.

use crate::shared::shared;
use approx::assert_relative_eq;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use torquewise_rigid::inertia::plain_link;
use torquewise_rigid::{Kinematics, MotionState, Moved};
use torquewise_sim::urdf::edit::{Dynamics, edited};
use torquewise_sim::{Arm, Body, SimError, UrdfChain};

/// An arm with a tool, a gripper whose finger mimics the other, skew axes and comments.
const ROBOT: &str = include_str!("skew.urdf");

fn names(joints: &[&str]) -> Vec<String> {
    joints.iter().map(ToString::to_string).collect()
}

/// Bodies of links, as they are put into the file.
type Inertials = Vec<(String, Option<Body>)>;

/// Bodies of some size in the frames of the geometry, and what is put into the file for them.
fn bodies(chain: &UrdfChain, mass: f64) -> (Vec<f64>, Inertials) {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let (mut all, mut changes) = (Vec::new(), Vec::new());
    for joint in &chain.joints {
        let end = [0.0; 3].map(|_: f64| random.random_range(-0.3..0.3));
        let body = plain_link(mass, &end.into(), 0.1);
        changes.extend(joint.distributed(&body).0);
        all.extend(body);
    }
    (all, changes)
}

/// Torque in the geometry, and by the file that the bodies were put into.
fn check(text: &str, joints: &[String], locked: &[String], mass: f64) -> String {
    let chain = UrdfChain::of_joints(text, joints, locked, None).unwrap();
    let (inertial, changes) = bodies(&chain, mass);
    let changed = edited(text, &changes, &[]).unwrap();
    let arm = Arm::from_urdf(&changed, locked).unwrap();
    let kinematics = Kinematics::new(&chain.geometry);
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let n = chain.joints.len();
    for _ in 0..100 {
        let [q, dq, ddq] = [(); 3]
            .map(|()| -> Vec<f64> { (0..n).map(|_| random.random_range(-3.0..3.0)).collect() });
        let state = MotionState { q: &q, dq: &dq, ddq: &ddq };
        let (mut moved, mut torque) = (Moved::default(), vec![0.0; n]);
        kinematics.move_into(state, &mut moved);
        moved.torque(&inertial, &mut torque);
        let expected = arm.inverse_dynamics(&q, &dq, &ddq);
        assert_relative_eq!(torque[..], expected[..], epsilon = 1e-9, max_relative = 1e-10);
    }
    changed
}

#[test]
fn bodies_put_into_the_file_move_as_in_the_geometry() {
    let changed = check(ROBOT, &names(&["waist", "elbow"]), &names(&["left"]), 3.0);

    // The tool and the finger keep what they have: the forearm carries the rest.
    let [finger, tool] = ["0.05", "0.1"].map(|mass| format!("<mass value=\"{mass}\"/>"));
    assert!(changed.contains(&finger) && changed.contains(&tool));
    let light = check(ROBOT, &names(&["waist", "elbow"]), &names(&["left"]), 0.02);
    assert!(!light.contains(&finger), "heavier than what it is part of");
}

#[test]
fn numbered_joints_are_taken_in_the_order_of_the_file_and_what_names_leave_open_is_told() {
    let of = |joints: &[&str]| UrdfChain::of_joints(ROBOT, &names(joints), &names(&["left"]), None);

    let numbered = of(&["joint1", "joint2"]).unwrap();
    assert_eq!([0, 1].map(|k| numbered.joints[k].name.as_str()), ["waist", "elbow"]);
    assert_eq!(numbered.joints.len(), 2);
    assert_eq!(numbered.joints[1].links, ["fore", "tool", "finger"]);
    assert_eq!(numbered.base, ["world", "base"]);
    let turned = of(&["elbow", "waist"]).unwrap_err();
    assert!(matches!(&turned, SimError::JointOrder { expected, .. } if expected == "waist, elbow"));
    let unknown = of(&["waist", "knee"]).unwrap_err();
    assert!(matches!(&unknown, SimError::UnknownJoints { unknown, .. } if unknown == "knee"));
    assert!(matches!(of(&["a", "b", "c"]), Err(SimError::UnknownJoints { .. })));
    assert!(of(&["waist"]).is_ok_and(|chain| chain.joints.len() == 1));
}

#[test]
fn nothing_but_the_bodies_and_dynamics_changes() {
    let dynamics = Dynamics { armature: 0.5, damping: 0.25, friction: 2.0 };
    let both = ["waist", "elbow"].map(|joint| (joint.into(), dynamics));
    let changed = edited(ROBOT, &[], &both).unwrap();

    let new = r#"<dynamics damping="0.25" friction="2.0" armature="0.5"/>"#;
    let expected = ROBOT.replace(r#"<dynamics damping="9"  friction="8"/>"#, new);
    let expected = expected
        .replace("<axis xyz=\"1 2 -0.5\"/>\n", &format!("<axis xyz=\"1 2 -0.5\"/>\n    {new}\n"));
    assert_eq!(changed, expected);
    assert_eq!(edited(ROBOT, &[], &[]).unwrap(), ROBOT);
}

#[test]
fn the_mounting_is_that_of_the_file_unless_gravity_is_given() {
    let of = |gravity| UrdfChain::of_joints(ROBOT, &names(&["waist", "elbow"]), &[], gravity);

    let [mounted, given, hanging] = [None, Some([0.0, 0.0, -2.0]), Some([0.0, 0.0, 1.0])]
        .map(|gravity| of(gravity).unwrap().geometry.gravity());

    assert_relative_eq!(mounted[..], given[..], epsilon = 1e-12);
    assert_relative_eq!(mounted[..], hanging.map(|g| -g)[..], epsilon = 1e-12);
    assert!(matches!(of(Some([0.0; 3])), Err(SimError::NoDirection { .. })));
}

/// Public robots, where they are at hand.
#[test]
fn public_robots_take_bodies_up() {
    let robots =
        [("ur5", 6, &[][..]), ("panda", 7, &["panda_finger_joint1", "panda_finger_joint2"])];
    for (name, n, locked) in robots {
        let Some(file) = shared(&format!("robots/{name}.urdf")) else { continue };
        let text = std::fs::read_to_string(file).unwrap();
        let numbered: Vec<String> = (1..=n).map(|k| format!("joint{k}")).collect();
        check(&text, &numbered, &names(locked), 2.0);
    }
}
