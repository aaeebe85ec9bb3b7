//! DH tables that must be refused, and one that must not.
#![expect(clippy::float_cmp, reason = "defaults and quarters are exact")]

use crate::arm::Arm;
use crate::error::SimError;

/// A good one-joint table, with one line replaced.
fn table(replaced: &str, by: &str) -> String {
    let text = r#"
name = "one"
[[joints]]
name = "joint1"
a = 0.5
alpha = 0.0
d = 0.0
mass = 2.0
com = [0.0, 0.0, 0.0]
inertia = [0.1, 0.1, 0.1, 0.0, 0.0, 0.0]
"#;
    assert!(text.contains(replaced), "the test replaces nothing: {replaced}");
    text.replacen(replaced, by, 1)
}

#[test]
fn offset_rotor_and_range_may_be_left_out() {
    let arm = Arm::from_dh_toml(&table("", "")).unwrap();

    assert_eq!(arm.joints(), ["joint1"]);
    assert_eq!(arm.gravity(), [0.0, 0.0, -9.81]);
    assert_eq!(arm.ranges(), [[-std::f64::consts::PI, std::f64::consts::PI]]);
}

#[test]
fn an_offset_shifts_the_joint_position() {
    let tilted = "name = \"one\"\nbase_rpy = [0.3, -0.8, 0.2]";
    let plain = Arm::from_dh_toml(&table("name = \"one\"", tilted)).unwrap();
    let text = table("name = \"one\"", tilted).replacen("d = 0.0", "d = 0.0\noffset = 0.4", 1);
    let shifted = Arm::from_dh_toml(&text).unwrap();

    let (expected, found) = (plain.gravity_torque(&[0.9])[0], shifted.gravity_torque(&[0.5])[0]);

    assert!((expected - found).abs() < 1e-14 && expected.abs() > 0.1);
}

#[test]
fn a_broken_table_is_refused() {
    let broken = [
        table("a = 0.5", "a = 0.5\nlength = 1.0"),
        table("name = \"one\"", "name = \"one\"\ncolour = \"red\""),
        table("mass = 2.0", ""),
        table("com = [0.0, 0.0, 0.0]", "com = [0.0, 0.0]"),
        table("alpha = 0.0", "alpha = \"pi\""),
        table("[[joints]]", "[[joints"),
        String::new(),
    ];

    for text in broken {
        let error = Arm::from_dh_toml(&text).unwrap_err();
        assert!(matches!(error, SimError::DhTable { .. }), "{text}\n{error:?}");
    }
}

#[test]
fn numbers_that_no_arm_can_have_are_refused() {
    let cases = [
        ("mass = 2.0", "mass = -2.0", "Mass"),
        ("mass = 2.0", "mass = nan", "Mass"),
        ("[0.1, 0.1, 0.1, ", "[0.1, 0.1, -0.1, ", "Inertia"),
        ("d = 0.0", "d = 0.0\nrotor = -1.0", "Inertia"),
        ("d = 0.0", "d = inf\noffset = 0.0", "NotFinite"),
        ("d = 0.0", "d = 0.0\noffset = nan", "NotFinite"),
        ("d = 0.0", "d = 0.0\nrange = [1.0, -1.0]", "Range"),
        ("name = \"one\"", "name = \"one\"\ngravity = [0.0, nan, 0.0]", "NotFinite"),
    ];

    for (replaced, by, variant) in cases {
        let error = Arm::from_dh_toml(&table(replaced, by)).unwrap_err();
        assert!(format!("{error:?}").starts_with(variant), "{by}: {error:?}");
    }
}

#[test]
fn an_arm_needs_joints_with_names_of_their_own() {
    let twice = format!("{}{}", table("", ""), table("name = \"one\"", ""));

    let none = Arm::from_dh_toml("name = \"none\"\njoints = []").unwrap_err();
    let twice = Arm::from_dh_toml(&twice).unwrap_err();

    assert!(matches!(none, SimError::NoJoints));
    assert!(matches!(twice, SimError::DuplicateName { kind: "joint", .. }), "{twice}");
}
