//! URDF files that must be refused, and what is left of a file with locked joints.

use crate::{Arm, JointLimits, SimError};
use approx::assert_relative_eq;

/// A link with mass 1 kg at (0, 0, 0.1) m.
fn link(name: &str) -> String {
    format!(
        "<link name='{name}'><inertial><origin xyz='0 0 0.1'/><mass value='1'/>\
         <inertia ixx='0.01' ixy='0' ixz='0' iyy='0.01' iyz='0' izz='0.01'/></inertial></link>"
    )
}

/// A joint about y, 0.3 m above its parent, with `more` inside.
fn joint(name: &str, kind: &str, [parent, child]: [&str; 2], more: &str) -> String {
    format!(
        "<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/>\
         <origin xyz='0 0 0.3' rpy='0 0 0'/><axis xyz='0 1 0'/>\
         <limit effort='1' velocity='1' lower='-1' upper='2'/>{more}</joint>"
    )
}

fn robot(parts: &[String]) -> String {
    format!("<?xml version='1.0'?><robot name='test'>{}</robot>", parts.concat())
}

/// base – j1 – l1 – j2 – l2, both joints of the given types.
pub(crate) fn two_joints(first: &str, second: &str) -> String {
    let links = ["base", "l1", "l2"].map(link).concat();
    robot(&[links, joint("j1", first, ["base", "l1"], ""), joint("j2", second, ["l1", "l2"], "")])
}

fn refused(text: &str) -> SimError {
    Arm::from_urdf(text, &[]).unwrap_err()
}

#[test]
fn revolute_and_continuous_joints_move_within_their_limits() {
    let arm = Arm::from_urdf(&two_joints("revolute", "continuous"), &[]).unwrap();

    assert_eq!((arm.name(), arm.joints()), ("test", &["j1".to_string(), "j2".to_string()][..]));
    assert_eq!(arm.ranges(), [[-1.0, 2.0], [-std::f64::consts::PI, std::f64::consts::PI]]);
}

#[test]
fn a_rotor_resists_its_own_joint_and_is_not_below_zero() {
    let text = two_joints("revolute", "revolute");
    let with = |armature: &str| text.replacen("</joint>", &format!("{armature}</joint>"), 1);
    let mass = |text: &str| Arm::from_urdf(text, &[]).unwrap().mass_matrix(&[0.3, -0.4]);

    let (bare, own) = (mass(&text), mass(&with("<dynamics armature='0.7'/>")));

    assert_relative_eq!(own[(0, 0)] - bare[(0, 0)], 0.7, epsilon = 1e-12);
    assert_relative_eq!(own[(1, 1)], bare[(1, 1)]);
    let error = refused(&with("<dynamics armature='-1'/>"));
    assert!(matches!(error, SimError::Setting { what, .. } if what.starts_with("rotor inertia")));
}

#[test]
fn limits_are_those_of_the_file_and_none_where_it_gives_none() {
    let text = two_joints("revolute", "continuous");
    let wide = text.replace("lower='-1' upper='2'", "lower='-7' upper='7'");
    let without = text.replace("velocity='1'", "velocity='0'").replace("lower='-1' upper='2'", "");
    let unlimited = JointLimits::default();

    let limits = |text: &str| Arm::from_urdf(text, &[]).unwrap().limits();

    let first = JointLimits { position: Some([-1.0, 2.0]), velocity: Some(1.0), ..unlimited };
    assert_eq!(limits(&text), [first, JointLimits { position: None, ..first }]);
    assert_eq!(limits(&wide)[0].position, Some([-7.0, 7.0]), "more than a turn");
    assert_eq!(limits(&without), [unlimited; 2]);
}

#[test]
fn a_locked_joint_keeps_its_mass_where_it_is_at_zero() {
    let text = two_joints("revolute", "revolute");
    let free = Arm::from_urdf(&text, &[]).unwrap();

    let locked = Arm::from_urdf(&text, &["j2".into()]).unwrap();

    assert_eq!(locked.joints(), ["j1"]);
    let (still, alone) = (free.mass_matrix(&[0.4, 0.0]), locked.mass_matrix(&[0.4]));
    assert_relative_eq!(alone[(0, 0)], still[(0, 0)], max_relative = 1e-14);
    let (still, alone) = (free.gravity_torque(&[0.4, 0.0]), locked.gravity_torque(&[0.4]));
    assert_relative_eq!(alone[0], still[0], max_relative = 1e-14);
}

#[test]
fn an_arm_may_hang_on_a_base_that_is_turned_by_a_fixed_joint() {
    let turned = "<joint name='mount' type='fixed'><parent link='world'/><child link='base'/>\
                  <origin rpy='3.141592653589793 0 0'/></joint>";
    let parts = [link("base"), link("l1"), joint("j1", "revolute", ["base", "l1"], "")];
    let upright = Arm::from_urdf(&robot(&parts), &[]).unwrap();

    let text = robot(&[parts.concat(), "<link name='world'/>".into(), turned.into()]);
    let hanging = Arm::from_urdf(&text, &[]).unwrap();

    let (upright, hanging) = (upright.gravity_torque(&[0.5])[0], hanging.gravity_torque(&[0.5])[0]);
    assert_relative_eq!(upright, -hanging, max_relative = 1e-14);
    assert_relative_eq!(upright, -0.1 * 9.81 * 0.5_f64.sin(), max_relative = 1e-14);
}

#[test]
fn a_prismatic_joint_slides_within_its_limits_and_needs_them() {
    let text = two_joints("prismatic", "revolute");
    let arm = Arm::from_urdf(&text, &[]).unwrap();

    assert_eq!((arm.kinds().letters(2).as_str(), arm.ranges()[0]), ("pr", [-1.0, 2.0]));
    // Along y, which is level: 2 kg without weight on the slide.
    let force = arm.inverse_dynamics(&[0.4, 0.0], &[0.0, 0.0], &[3.0, 0.0])[0];
    assert_relative_eq!(force, 6.0, max_relative = 1e-14);
    let chain = crate::UrdfChain::of_joints(&text, arm.joints(), &[], None).unwrap();
    assert_eq!(*chain.geometry.kinds(), arm.kinds());
    let unlimited = text.replacen("lower='-1' upper='2'", "", 1);
    assert!(matches!(refused(&unlimited), SimError::Range { joint, .. } if joint == "j1"));
}

#[test]
fn every_joint_that_may_not_move_is_named_and_one_that_follows_another_until_it_is_locked() {
    let mimic = joint("j2", "revolute", ["l1", "l2"], "<mimic joint='j1'/>");
    let first = joint("j1", "revolute", ["base", "l1"], "");
    let follows = robot(&[link("base"), link("l1"), link("l2"), first, mimic]);
    let kinds = ["floating", "planar", "spherical"];
    let others = kinds.map(|kind| (two_joints("revolute", kind), format!("`j2` ({kind})")));
    for (text, named) in others.into_iter().chain([(follows.clone(), "`j2` (mimic)".to_owned())]) {
        let error = refused(&text);

        assert!(matches!(error, SimError::UnsupportedJoints { .. }), "{error:?}");
        assert!(error.to_string().contains(&named), "{error}");
    }
    assert_eq!(Arm::from_urdf(&follows, &["j2".into()]).unwrap().joints(), ["j1"]);
}

#[test]
fn a_branch_is_refused_with_the_joints_to_lock() {
    let joints = [
        ("finger1", ["l1", "f1"]),
        ("finger2", ["f1", "f2"]),
        ("j1", ["base", "l1"]),
        ("j2", ["l1", "l2"]),
        ("j3", ["l2", "l3"]),
        ("j4", ["l3", "l4"]),
    ];
    let links = ["base", "l1", "l2", "f1", "f2", "l3", "l4"].map(link).concat();
    let joints = joints.map(|(name, ends)| joint(name, "revolute", ends, "")).concat();
    let text = robot(&[links, joints]);

    let error = refused(&text);

    assert!(error.told().ends_with("lock finger1, finger2"), "{error}");
    let arm = Arm::from_urdf(&text, &["finger1".into(), "finger2".into()]).unwrap();
    assert_eq!(arm.joints(), ["j1", "j2", "j3", "j4"]);
}

#[test]
fn an_unknown_joint_to_lock_is_answered_with_those_there_are() {
    let text = two_joints("revolute", "revolute");

    let error = Arm::from_urdf(&text, &["elbow".into()]).unwrap_err();

    assert!(matches!(error, SimError::UnknownJoint { .. }));
    assert!(error.told().ends_with("j1, j2"), "{error}");
}

#[test]
fn joints_that_make_no_tree_are_refused() {
    let turn = |name: &str, ends| joint(name, "revolute", ends, "");
    let [base, l1, l2] = ["base", "l1", "l2"].map(link);
    let twice = ["j1", "j2"].map(|name| turn(name, ["base", "l1"])).concat();
    let round = [turn("j1", ["l1", "l2"]), turn("j2", ["l2", "l1"])].concat();
    let cases = [
        (robot(&[]), "Roots"),
        (robot(&[base.clone(), l1.clone()]), "Roots"),
        (robot(std::slice::from_ref(&base)), "NoJoints"),
        (robot(&[base.clone(), turn("j", ["base", "base"])]), "Roots"),
        (robot(&[base.clone(), turn("j", ["base", "gone"])]), "UnknownLink"),
        (robot(&[base.clone(), turn("j", ["gone", "base"])]), "UnknownLink"),
        (robot(&[base.clone(), base.clone()]), "DuplicateName"),
        (robot(&[base.clone(), l1.clone(), twice]), "TwoParents"),
        (robot(&[[base, l1, l2].concat(), round]), "Loop"),
    ];

    for (text, variant) in cases {
        let error = refused(&text);
        assert!(format!("{error:?}").starts_with(variant), "expected {variant}: {error:?}");
    }
}

#[test]
fn numbers_that_no_arm_can_have_are_refused() {
    let good = two_joints("revolute", "revolute");
    let cases = [
        ("value='1'", "value='-1'", "Setting { what: \"mass"),
        ("value='1'", "value='NaN'", "Setting { what: \"mass"),
        ("value='1'", "value='inf'", "Setting { what: \"mass"),
        ("ixx='0.01'", "ixx='-0.01'", "Inertia"),
        ("ixx='0.01'", "ixx='nan'", "Setting { what: \"inertia"),
        ("ixy='0'", "ixy='5'", "Inertia"),
        ("xyz='0 0 0.1'", "xyz='0 0 nan'", "Setting { what: \"origin"),
        ("xyz='0 0 0.3'", "xyz='inf 0 0.3'", "Setting { what: \"origin"),
        ("rpy='0 0 0'", "rpy='0 NaN 0'", "Setting { what: \"origin"),
        ("xyz='0 1 0'", "xyz='0 0 0'", "NoDirection"),
        ("xyz='0 1 0'", "xyz='nan 0 0'", "NoDirection"),
        ("xyz='0 1 0'", "xyz='1e200 0 0'", "NoDirection"),
        ("value='1'", "value='one'", "Urdf"),
        ("xyz='0 1 0'", "xyz='0 1'", "Urdf"),
        ("type='revolute'", "type='hinge'", "Urdf"),
        ("<mass value='1'/>", "", "Urdf"),
    ];

    for (found, replaced, variant) in cases {
        assert!(good.contains(found), "the test replaces nothing: {found}");
        // The last place, because the base's own mass never moves.
        let at = good.rfind(found).unwrap();
        let text = format!("{}{replaced}{}", &good[..at], &good[at + found.len()..]);
        let error = refused(&text);
        assert!(format!("{error:?}").starts_with(variant), "{replaced}: {error:?}");
    }
}

#[test]
fn an_element_at_fault_is_named_with_its_line() {
    let text = two_joints("revolute", "revolute").replace("<joint", "\n<joint");

    let error = refused(&text.replace("<axis xyz='0 1 0'/>", "<axis xyz='0 1'/>"));

    let told = "line 2 of the URDF: <axis> has xyz=\"0 1\", expected 3 numbers: mend the element";
    assert_eq!(error.told(), told);
}

#[test]
fn files_too_deep_with_entities_or_cut_anywhere_are_refused() {
    let whole = two_joints("revolute", "revolute");
    let deep = format!("{}{}", "<a>".repeat(100_000), "</a>".repeat(100_000));
    let text = whole.replace("</robot>", &(deep + "</robot>"));

    let entities = "<!DOCTYPE a [<!ENTITY b 'bbbb'>]><robot name='&b;'/>";
    for wrong in [&"<a>".repeat(100_000), entities] {
        assert!(matches!(refused(wrong), SimError::Urdf { .. }));
    }
    assert!(Arm::from_urdf(&text, &[]).is_ok_and(|arm| arm.n_joints() == 2));
    for end in 0..whole.len() {
        assert!(Arm::from_urdf(&whole[..end], &[]).is_err(), "cut at {end}");
    }
}
