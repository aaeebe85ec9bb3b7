//! Limits from files, flags and defaults.

use crate::excite::limits::{JointValues, Wishes, limits};
use crate::urdf::tests::two_joints;
use crate::{Arm, SimError};
use approx::assert_relative_eq;
use std::f64::consts::PI;

/// Joint `turn` from −1 to 3 rad at 2 rad/s, joint `roll` without end at 4 rad/s.
fn arm() -> Arm {
    let text = two_joints("revolute", "continuous").replace("upper='2'", "upper='3'");
    let (turn, roll) = text.split_once("<joint name='j2'").unwrap();
    let turn = turn.replace("'j1'", "'turn'").replace("velocity='1'", "velocity='2'");
    let roll = roll.replace("velocity='1'", "velocity='4'");
    Arm::from_urdf(&format!("{turn}<joint name='roll'{roll}"), &[]).unwrap()
}

fn all<T>(value: T) -> JointValues<T> {
    JointValues(vec![(None, value)])
}

fn named<T>(values: Vec<(&str, T)>) -> JointValues<T> {
    JointValues(values.into_iter().map(|(name, value)| (Some(name.to_owned()), value)).collect())
}

#[test]
fn a_plan_keeps_off_the_limits_of_the_file() {
    let limits = limits(&arm(), &Wishes::default()).unwrap();

    let (turn, roll) = (&limits[0], &limits[1]);
    assert_relative_eq!(turn.planned.position[..], [-0.8, 2.8][..], epsilon = 1e-12);
    assert_relative_eq!(roll.planned.position[..], [-PI, PI][..]);
    assert_relative_eq!(turn.planned.velocity, 1.0);
    assert_relative_eq!(roll.planned.acceleration, 4.0, epsilon = 1e-12);
    assert_eq!(turn.assumed, ["acceleration"]);
    assert_eq!(roll.assumed, ["acceleration", "position"]);
}

#[test]
fn wishes_come_before_the_file_but_do_not_widen_a_range() {
    let wishes = Wishes {
        range: named(vec![("turn", [0.0, 9.0]), ("roll", [-9.0, 9.0])]),
        velocity: JointValues(vec![(None, 3.0)]),
        acceleration: JointValues(vec![(None, 5.0), (None, 6.0)]),
        ..Wishes::default()
    };

    let limits = limits(&arm(), &wishes).unwrap();

    assert_relative_eq!(limits[0].planned.position[..], [0.0, 2.8][..], epsilon = 1e-12);
    assert_relative_eq!(limits[1].planned.position[..], [-9.0, 9.0][..]);
    assert_relative_eq!(limits[1].planned.velocity, 1.5);
    assert_relative_eq!(limits[1].planned.acceleration, 6.0);
    assert!(limits.iter().all(|limits| limits.assumed.is_empty()));
}

#[test]
fn an_arm_without_limits_gets_assumed_ones() {
    let limits = limits(&Arm::builtin("planar-2").unwrap(), &Wishes::default()).unwrap();

    assert_eq!(limits[1].assumed, ["velocity", "acceleration", "position"]);
    assert_relative_eq!(limits[1].planned.velocity, 1.0);
    assert_relative_eq!(limits[1].planned.acceleration, 2.0);
}

#[test]
fn wishes_that_make_no_sense_are_refused_with_the_joint() {
    let usual = Wishes::default;
    let cases = [
        (Wishes { range: all([4.0, 5.0]), ..usual() }, "turn"),
        (Wishes { range: all([1.0, 0.0]), ..usual() }, "turn"),
        (Wishes { range: named(vec![("roll", [0.0, f64::NAN])]), ..usual() }, "roll"),
        (Wishes { range: named(vec![("wrist", [0.0, 1.0])]), ..usual() }, "turn, roll"),
        (Wishes { velocity: all(0.0), ..usual() }, "turn"),
        (Wishes { velocity: all(f64::INFINITY), ..usual() }, "velocity"),
        (Wishes { acceleration: all(-1.0), ..usual() }, "acceleration"),
        (Wishes { velocity: JointValues(vec![(None, 1.0); 3]), ..usual() }, "given 3 times"),
        (Wishes { speed_scale: 1.5, ..usual() }, "speed scale"),
        (Wishes { speed_scale: f64::NAN, ..usual() }, "speed scale"),
        (Wishes { margin: 0.5, ..usual() }, "margin"),
        (Wishes { margin: -0.1, ..usual() }, "margin"),
    ];

    for (wishes, word) in cases {
        let error = limits(&arm(), &wishes).unwrap_err();
        assert!(error.told().contains(word), "{word}: {error}");
    }
    let mixed = JointValues(vec![(None, 1.0), (Some("roll".to_owned()), 1.0)]);
    let error = limits(&arm(), &Wishes { velocity: mixed, ..usual() }).unwrap_err();
    assert!(matches!(error, SimError::Mixed { .. }));
}
