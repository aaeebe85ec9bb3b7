//! Torques of the wrong sign are named, one and all.
use crate::support::{
    chain, deviation, executed, fit, motion, normals, percent, states_of, with_torque,
};
use faer::Mat;
use torquewise_identify::verdict::{Grade, judge};
use torquewise_identify::{
    ChainOptions, FrictionKind, Plan, UNWATCHED, Warning, survey, weightless,
};
use torquewise_motion::Motion;
use torquewise_sim::{Arm, MotionKind};

/// Whether a warning is of the signals of a log.
fn is_finding(own: &Warning) -> bool {
    matches!(
        own,
        Warning::Range { .. }
            | Warning::Speed { .. }
            | Warning::Acceleration { .. }
            | Warning::OneWay { .. }
            | Warning::Together { .. }
            | Warning::Clipped { .. }
            | Warning::WrongSign { .. }
            | Warning::Weightless
            | Warning::Swapped { .. }
            | Warning::Gains { .. }
            | Warning::Commanded { .. }
            | Warning::Unrelated { .. }
    )
}

/// What a fit finds in the signals of a log.
fn findings(log: &Motion, plan: &Plan) -> Vec<Warning> {
    fit(log, plan).warnings.into_iter().filter(is_finding).collect()
}

/// Joints that a fit says to have the wrong sign once the torque of some is turned round.
fn named(arm: &str, turned: &[usize], friction: f64) -> Vec<String> {
    let arm = Arm::builtin(arm).unwrap();
    let log = with_torque(motion(&arm, MotionKind::Sines, 40.0, 50.0, 1), |[_, dq, _], tau| {
        tau.iter_mut().zip(dq).for_each(|(tau, dq)| *tau += friction * dq);
        for &joint in turned {
            tau[joint] = -tau[joint];
        }
    });
    let wrong = |finding| match finding {
        Warning::WrongSign { joints } => Some(joints),
        _ => None,
    };
    findings(&log, &Plan::default()).into_iter().find_map(wrong).unwrap_or_default()
}

#[test]
fn one_two_and_all_torques_of_the_wrong_sign_are_named() {
    for (arm, friction) in [("planar-2", 0.0), ("planar-2", 2.0), ("puma560-3", 0.0)] {
        let joints = Arm::builtin(arm).unwrap().joints().to_vec();
        let all: Vec<usize> = (0..joints.len()).collect();
        for turned in [&[][..], &[1], &all] {
            let expected: Vec<String> = turned.iter().map(|&joint| joints[joint].clone()).collect();
            assert_eq!(named(arm, turned, friction), expected, "{arm}, friction {friction}");
        }
    }
}

#[test]
fn of_a_wrist_the_torque_that_is_turned_is_named_and_no_other() {
    for joint in [3, 5] {
        let expected = [Arm::builtin("generic-6").unwrap().joints()[joint].clone()];
        assert_eq!(named("generic-6", &[joint], 2.0), expected);
    }
}

#[test]
fn of_torques_that_are_noise_no_sign_is_told() {
    let arm = Arm::builtin("planar-2").unwrap();
    for seed in 1..=6 {
        let mut normal = normals(seed);
        let log = motion(&arm, MotionKind::Sines, 40.0, 10.0, 1);
        let log = with_torque(log, |_, tau| tau.iter_mut().for_each(|tau| *tau = normal()));

        let found = findings(&log, &chain(FrictionKind::Auto));

        assert!(!found.iter().any(|own| matches!(own, Warning::WrongSign { .. })), "{found:?}");
    }
}

#[test]
fn of_a_joint_that_hardly_moves_no_sign_is_told() {
    let arm = Arm::builtin("puma560-3").unwrap();
    let log = motion(&arm, MotionKind::Sines, 40.0, 50.0, 1);
    let mut states = states_of(&log);
    for signal in states.iter_mut().flatten() {
        signal[2] *= 0.02;
    }
    let turned = with_torque(executed(&arm, log.t().to_vec(), &states), |_, tau| tau[2] = -tau[2]);

    let found = findings(&turned, &Plan::default());

    assert!(!found.iter().any(|own| matches!(own, Warning::WrongSign { .. })), "{found:?}");
    // But with those of all others it is.
    let log = executed(&arm, log.t().to_vec(), &states);
    let turned = with_torque(log, |_, tau| tau.iter_mut().for_each(|tau| *tau = -*tau));
    let all = Warning::WrongSign { joints: arm.joints().to_vec() };
    assert!(findings(&turned, &Plan::default()).contains(&all));
}

/// As of a wrist whose torque is little but friction, which then drives it.
#[test]
fn of_torques_that_are_little_but_friction_those_that_are_turned_or_swapped_are_named() {
    let arm = Arm::builtin("generic-6").unwrap();
    let clean = motion(&arm, MotionKind::Sines, 40.0, 50.0, 1);
    let viscous = |joint: usize| {
        let part = if joint < 4 { 0.3 } else { 20.0 };
        part * deviation(clean.tau().unwrap(), joint)
    };
    let viscous: Vec<f64> = (0..6).map(viscous).collect();
    let said = |spoil: &dyn Fn(&mut [f64])| {
        let mut normal = normals(1);
        let log = with_torque(clean.clone(), |[_, dq, _], tau| {
            for (joint, tau) in tau.iter_mut().enumerate() {
                *tau += viscous[joint] * (dq[joint] + 0.03 * normal());
            }
            spoil(tau);
        });
        findings(&log, &Plan::default())
    };
    let joints = [4, 5].map(|joint: usize| arm.joints()[joint].clone());

    assert_eq!(said(&|_| ()), []);
    for (joint, name) in [4, 5].into_iter().zip(&joints) {
        let wrong = Warning::WrongSign { joints: vec![name.clone()] };
        assert_eq!(said(&|tau| tau[joint] = -tau[joint]), [wrong]);
    }
    assert_eq!(said(&|tau| tau.swap(4, 5)), [Warning::Swapped { joints }]);
}

#[test]
fn a_torque_that_never_changes_leaves_the_others_as_they_are() {
    let arm = Arm::builtin("puma560-3").unwrap();
    let log = |seed| motion(&arm, MotionKind::Sines, 40.0, 50.0, seed);
    let said = |unmeasured: &[usize], value: f64| {
        let spoilt = with_torque(log(1), |_, tau| unmeasured.iter().for_each(|k| tau[*k] = value));
        fit(&spoilt, &chain(FrictionKind::Linear))
    };
    let weighs = with_torque(log(1), |_, tau| tau[2] = 0.0);
    assert_eq!(weightless(&survey(&weighs).unwrap(), 1, UNWATCHED), None);
    for (unmeasured, value) in [(&[2][..], 0.0), (&[2], 0.3), (&[0, 2], 0.0)] {
        let found = said(unmeasured, value);

        let roots = found.model.chain.as_ref().unwrap().covariance_root.iter().flatten();
        assert!(roots.into_iter().all(|root| root.is_finite()));
        let constant = Warning::ConstantTorque { joint: arm.joints()[2].clone() };
        assert!(found.warnings.contains(&constant), "{:?}", found.warnings);
        let others = |own: &Warning| is_finding(own) || matches!(own, Warning::Refit { .. });
        assert!(!found.warnings.iter().any(others), "{:?}", found.warnings);
        let errors = percent(&found.model, &log(2));
        assert!(errors[unmeasured.len() - 1..2].iter().all(|error| *error < 1.0), "{errors:?}");
        assert_ne!(judge(&found).grade, Grade::Good);
    }
    let constant = said(&[0, 1, 2], 0.0);
    assert_eq!(judge(&constant).grade, Grade::Unusable);
    let constant = constant.warnings.into_iter();
    assert_eq!(constant.filter(|own| matches!(own, Warning::ConstantTorque { .. })).count(), 3);
}

#[test]
fn poses_without_velocities_are_no_path_for_friction() {
    let arm = Arm::builtin("puma560-3").unwrap();
    let poses = |seed| {
        let moving = motion(&arm, MotionKind::Sines, 400.0, 1.0, seed);
        let (m, mut signals) = (moving.n_rows(), moving.into_signals());
        (signals.dq, signals.ddq) = (Mat::zeros(m, 3), Mat::zeros(m, 3));
        let mut normal = normals(seed);
        with_torque(Motion::new(signals).unwrap(), |[q, ..], tau| {
            let gravity = arm.gravity_torque(q);
            tau.iter_mut().zip(gravity).for_each(|(tau, own)| *tau = own + 0.05 * normal());
        })
    };

    let found = fit(&poses(1), &chain(FrictionKind::Auto)).model;

    assert!(found.travels().is_empty());
    let errors = percent(&found, &poses(2));
    assert!(errors[1..].iter().all(|error| *error < 5.0), "{errors:?}");
}

/// A log of torques with dry friction that are spoilt.
fn spoilt(arm: &Arm, spoil: impl Fn(&[f64], &mut [f64])) -> Motion {
    let clean = motion(arm, MotionKind::Moves, 40.0, 100.0, 1);
    let tau = clean.tau().unwrap().to_owned();
    let dry: Vec<f64> =
        (0..tau.ncols()).map(|joint| 0.1 * deviation(tau.as_ref(), joint)).collect();
    with_torque(clean, |[q, dq, _], tau| {
        for ((tau, dry), dq) in tau.iter_mut().zip(&dry).zip(dq) {
            *tau += dry * (dq / 0.02).tanh();
        }
        spoil(q, tau);
    })
}

/// What a fit says of torques with dry friction once they are spoilt.
fn said(arm: &Arm, plan: &Plan, spoil: impl Fn(&[f64], &mut [f64])) -> Vec<Warning> {
    let is_of_torque = |finding: &Warning| {
        matches!(finding, Warning::Swapped { .. } | Warning::Weightless | Warning::Gains { .. })
    };
    findings(&spoilt(arm, spoil), plan).into_iter().filter(is_of_torque).collect()
}

#[test]
fn a_torque_that_is_but_noise_is_in_no_other_place() {
    let log = motion(&Arm::builtin("generic-6").unwrap(), MotionKind::Sines, 20.0, 20.0, 1);
    let spread: Vec<f64> = (0..6).map(|joint| deviation(log.tau().unwrap(), joint)).collect();
    let mut normal = normals(1);
    let noise = with_torque(log, |_, tau| {
        tau.iter_mut().zip(&spread).for_each(|(tau, own)| *tau += 0.3 * own * normal());
        tau[0] = 0.085 + 0.003 * normal();
    });

    assert_eq!(findings(&noise, &Plan::default()), []);
}

/// Whether torques are said to lack gravity before anything is fitted to them.
fn is_weightless(arm: &Arm, spoil: impl Fn(&[f64], &mut [f64])) -> bool {
    weightless(&survey(&spoilt(arm, spoil)).unwrap(), 0, UNWATCHED).is_some()
}

#[test]
fn torques_that_are_swapped_or_without_gravity_are_named() {
    let arm = Arm::builtin("generic-4").unwrap();
    assert_eq!(said(&arm, &Plan::default(), |_, _| ()), []);
    for [a, b] in [[0, 1], [1, 2], [0, 3], [2, 3]] {
        let expected = Warning::Swapped { joints: [a, b].map(|joint| arm.joints()[joint].clone()) };
        assert_eq!(said(&arm, &Plan::default(), |_, tau| tau.swap(a, b)), [expected]);
    }
    // Axes of the last are parallel, as those of an arm that gravity does not pull may be.
    let arms = [
        ("generic-6", Plan::from(ChainOptions::default()), true),
        ("puma560-3", Plan::default(), true),
        ("generic-4", Plan::default(), true),
        ("planar-2", Plan::default(), false),
    ];
    for (name, plan, is_told) in arms {
        let arm = Arm::builtin(name).unwrap();
        let take_out = |q: &[f64], tau: &mut [f64]| {
            tau.iter_mut().zip(arm.gravity_torque(q)).for_each(|(tau, gravity)| *tau -= gravity);
        };
        let expected = if is_told { vec![Warning::Weightless] } else { Vec::new() };

        assert_eq!(said(&arm, &plan, take_out), expected, "{name}");
        assert_eq!(said(&arm, &plan, |_, _| ()), [], "{name}");
        assert_eq!(is_weightless(&arm, take_out), is_told, "{name}");
        assert!(!is_weightless(&arm, |_, _| ()), "{name}");
    }
    for upright in ["scara-4", "gantry-3"] {
        assert!(!is_weightless(&Arm::builtin(upright).unwrap(), |_, _| ()), "{upright}");
    }
}

#[test]
fn currents_of_different_motors_are_named_with_what_each_is_worth() {
    let arms =
        [("generic-6", &[9.0, 14.0, 8.0, 5.0, 6.0, 7.0][..]), ("puma560-3", &[1.0, 2.9, 0.4])];
    for (name, gains) in arms {
        let currents = |_: &[f64], tau: &mut [f64]| {
            tau.iter_mut().zip(gains).for_each(|(tau, gain)| *tau /= gain);
        };
        let found =
            said(&Arm::builtin(name).unwrap(), &Plan::from(ChainOptions::default()), currents);

        let [Warning::Gains { gains: found, .. }] = &found[..] else { panic!("{found:?}") };
        let mean = gains.iter().map(|gain| gain.ln()).sum::<f64>() / gains.len() as f64;
        for ([found, error], gain) in found.iter().zip(gains) {
            let truth = gain / mean.exp();
            assert!((found / truth - 1.0).abs() < 0.01, "{name}: {found} {truth}");
            assert!((found - truth).abs() < 3.0 * error, "{name}: {found} ± {error}, {truth}");
            assert!(*error < 0.1 * truth, "{name}: {found} {error}");
        }
    }
    // Of a torque that is mostly noise none is told.
    let log = motion(&Arm::builtin("generic-6").unwrap(), MotionKind::Sines, 40.0, 50.0, 1);
    let (spread, mut normal) = (deviation(log.tau().unwrap(), 5), normals(1));
    let log = with_torque(log, |_, tau| {
        tau.iter_mut().zip(arms[0].1).for_each(|(tau, gain)| *tau /= gain);
        tau[5] += 0.1 * spread * normal();
    });
    let found = findings(&log, &Plan::from(ChainOptions::default()));
    let [Warning::Gains { gains: found, .. }] = &found[..] else { panic!("{found:?}") };
    assert!(found[5][1].is_infinite(), "{found:?}");
    assert!(found[..5].iter().all(|[gain, error]| *error < 0.1 * gain), "{found:?}");
}
