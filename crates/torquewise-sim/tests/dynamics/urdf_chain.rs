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
const ROBOT: &str = r#"<?xml version="1.0"?>
<!-- an arm -->
<robot name="skew">
  <link name="world"/>
  <joint name="stand" type="fixed"><parent link="world"/><child link="base"/>
    <origin xyz="0 0 1" rpy="0.4 0.1 -0.2"/></joint>
  <link name="base"/>
  <joint name="waist" type="revolute">
    <parent link="base"/><child link="upper"/>
    <origin xyz="0.1 0 0.2" rpy="0 0.3 0"/><axis xyz="0 0 -1"/>
    <limit lower="-1" upper="1" effort="10" velocity="2"/>
    <dynamics damping="9"  friction="8"/>
  </joint>
  <link name="upper">
    <inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <visual><geometry><sphere radius="0.1"/></geometry></visual>
  </link>
  <joint name="elbow" type="continuous">
    <parent link="upper"/><child link="fore"/>
    <origin xyz="0.3 0.05 0" rpy="1.2 -0.4 0.9"/><axis xyz="1 2 -0.5"/>
  </joint>
  <link name="fore"/>
  <joint name="flange" type="fixed"><parent link="fore"/><child link="tool"/>
    <origin xyz="0 0.2 0.1" rpy="0 0 0.7"/></joint>
  <link name="tool"><inertial><origin xyz="0 0 0.01"/><mass value="0.1"/>
    <inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial></link>
  <joint name="left" type="prismatic"><parent link="tool"/><child link="finger"/>
    <limit lower="0" upper="0.1" effort="1" velocity="1"/></joint>
  <link name="finger"><inertial><mass value="0.05"/>
    <inertia ixx="1e-5" ixy="0" ixz="0" iyy="1e-5" iyz="0" izz="1e-5"/></inertial></link>
</robot>
"#;

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
        let mut torque = vec![0.0; n];
        kinematics.inverse_dynamics(state, &inertial, &mut Moved::default(), &mut torque);
        let expected = arm.inverse_dynamics(&q, &dq, &ddq);
        for (own, file) in torque.iter().zip(&expected) {
            assert_relative_eq!(own, file, epsilon = 1e-9, max_relative = 1e-10);
        }
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
    let changed = edited(ROBOT, &[], &["waist", "elbow"].map(|joint| (joint.into(), dynamics)));
    let changed = changed.unwrap();

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

    let as_mounted = of(None).unwrap();
    let given = of(Some([0.0, 0.0, -2.0])).unwrap();
    let hanging = of(Some([0.0, 0.0, 1.0])).unwrap();

    let [mounted, given, hanging] =
        [as_mounted, given, hanging].map(|chain| chain.geometry.gravity());
    for axis in 0..3 {
        assert_relative_eq!(mounted[axis], given[axis], epsilon = 1e-12);
        assert_relative_eq!(mounted[axis], -hanging[axis], epsilon = 1e-12);
    }
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
