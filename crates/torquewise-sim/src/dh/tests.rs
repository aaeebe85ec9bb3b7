//! DH tables that must be refused, and one that must not.
#![expect(clippy::float_cmp, reason = "defaults and quarters are exact")]

use crate::Arm;

/// A good one-joint table, with one line replaced.
fn table(replaced: &str, by: &str) -> String {
    let text = include_str!("one.toml");
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
fn tables_that_are_broken_or_of_no_arm_that_can_be_are_refused() {
    let cases = [
        ("a = 0.5", "a = 0.5\nlength = 1.0", "DhTable"),
        ("name = \"one\"", "name = \"one\"\ncolour = \"red\"", "DhTable"),
        ("mass = 2.0", "", "DhTable"),
        ("com = [0.0, 0.0, 0.0]", "com = [0.0, 0.0]", "DhTable"),
        ("alpha = 0.0", "alpha = \"pi\"", "DhTable"),
        ("[[joints]]", "[[joints", "DhTable"),
        ("mass = 2.0", "mass = -2.0", "Setting { what: \"mass"),
        ("mass = 2.0", "mass = nan", "Setting { what: \"mass"),
        ("[0.1, 0.1, 0.1, ", "[0.1, 0.1, -0.1, ", "Inertia"),
        ("d = 0.0", "d = 0.0\nrotor = -1.0", "Setting { what: \"rotor inertia"),
        ("d = 0.0", "d = inf\noffset = 0.0", "Setting { what: \"centre of mass"),
        ("d = 0.0", "d = 0.0\noffset = nan", "Setting { what: \"placement"),
        ("d = 0.0", "d = 0.0\nrange = [1.0, -1.0]", "Range"),
        (
            "name = \"one\"",
            "name = \"one\"\ngravity = [0.0, nan, 0.0]",
            "Setting { what: \"gravity",
        ),
    ];

    let cases = cases.map(|(replaced, by, variant)| (table(replaced, by), variant));
    let others = [
        (String::new(), "DhTable"),
        ("name = \"none\"\njoints = []".to_owned(), "NoJoints"),
        (table("", "") + &table("name = \"one\"", ""), "DuplicateName { kind: \"joint\""),
    ];

    for (text, variant) in cases.into_iter().chain(others) {
        let error = Arm::from_dh_toml(&text).unwrap_err();
        assert!(format!("{error:?}").starts_with(variant), "{text}\n{error:?}");
    }
}
