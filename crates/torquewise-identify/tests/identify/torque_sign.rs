//! Torques of the wrong sign are named, one and all.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use torquewise_identify::excitation::Finding;
use torquewise_identify::plan::ChainOptions;
use torquewise_identify::{Plan, Warning, reconstruct};
use torquewise_motion::{Motion, Signals};
use torquewise_sim::{Arm, MotionKind, MotionPlan, simulate};

/// Joints that a fit says to have the wrong sign once the torque of some is turned round.
fn named(arm: &str, turned: &[usize], friction: f64) -> Vec<String> {
    let plan = MotionPlan { kind: MotionKind::Sines, seconds: 40.0, rate: 50.0, seed: 1 };
    let motion = simulate(&Arm::builtin(arm).unwrap(), &plan).unwrap().motion;
    let mut signals = motion.into_signals();
    let tau = signals.tau.as_mut().unwrap();
    for joint in 0..tau.ncols() {
        let sign = if turned.contains(&joint) { -1.0 } else { 1.0 };
        for row in 0..tau.nrows() {
            let own = tau[(row, joint)] + friction * signals.dq[(row, joint)];
            tau[(row, joint)] = sign * own;
        }
    }
    let found = reconstruct(
        &Motion::new(signals).unwrap(),
        &Plan::default(),
        torquewise_identify::UNWATCHED,
    )
    .unwrap();
    let wrong = |warning: &Warning| match warning {
        Warning::Excitation(Finding::WrongSign { joint }) => Some(joint.clone()),
        _ => None,
    };
    found.warnings.iter().filter_map(wrong).collect()
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

/// What a fit says of torques with dry friction once they are spoilt.
fn said(arm: &str, plan: &Plan, spoil: impl Fn(&Arm, &mut Signals)) -> Vec<Finding> {
    let motion = MotionPlan { kind: MotionKind::Moves, seconds: 40.0, rate: 100.0, seed: 1 };
    let arm = Arm::builtin(arm).unwrap();
    let mut signals = simulate(&arm, &motion).unwrap().motion.into_signals();
    let dq = signals.dq.clone();
    let tau = signals.tau.as_mut().unwrap();
    for joint in 0..tau.ncols() {
        let spread = (tau.col(joint).squared_norm_l2() / tau.nrows() as f64).sqrt();
        for row in 0..tau.nrows() {
            tau[(row, joint)] += 0.1 * spread * (dq[(row, joint)] / 0.02).tanh();
        }
    }
    spoil(&arm, &mut signals);
    let found =
        reconstruct(&Motion::new(signals).unwrap(), plan, torquewise_identify::UNWATCHED).unwrap();
    let findings = found.warnings.into_iter().filter_map(|warning| match warning {
        Warning::Excitation(finding) => Some(finding),
        _ => None,
    });
    let is_of_torque = |finding: &Finding| {
        matches!(finding, Finding::Swapped { .. } | Finding::Weightless | Finding::Gains { .. })
    };
    findings.filter(is_of_torque).collect()
}

#[test]
fn torques_that_are_swapped_are_named() {
    let joints = Arm::builtin("generic-4").unwrap().joints().to_vec();
    assert_eq!(said("generic-4", &Plan::default(), |_, _| ()), []);
    for [a, b] in [[0, 1], [1, 2], [0, 3], [2, 3]] {
        let swap = |_: &Arm, signals: &mut Signals| {
            let tau = signals.tau.as_mut().unwrap();
            for row in 0..tau.nrows() {
                (tau[(row, a)], tau[(row, b)]) = (tau[(row, b)], tau[(row, a)]);
            }
        };
        let expected = Finding::Swapped { joints: [joints[a].clone(), joints[b].clone()] };
        assert_eq!(said("generic-4", &Plan::default(), swap), [expected]);
    }
}

#[test]
fn torques_without_gravity_are_named() {
    let take_out = |arm: &Arm, signals: &mut Signals| {
        let tau = signals.tau.as_mut().unwrap();
        for row in 0..tau.nrows() {
            let q: Vec<f64> = signals.q.row(row).iter().copied().collect();
            for (joint, gravity) in arm.gravity_torque(&q).into_iter().enumerate() {
                tau[(row, joint)] -= gravity;
            }
        }
    };

    let plan = ChainOptions::default().into();
    assert_eq!(said("generic-6", &plan, take_out), [Finding::Weightless]);
}

#[test]
fn currents_of_different_motors_are_named_with_what_each_is_worth() {
    let gains = [9.0, 14.0, 8.0, 5.0, 6.0, 7.0];
    let currents = |_: &Arm, signals: &mut Signals| {
        let tau = signals.tau.as_mut().unwrap();
        for (joint, gain) in gains.into_iter().enumerate() {
            tau.col_mut(joint).iter_mut().for_each(|x| *x /= gain);
        }
    };

    let found = said("generic-6", &ChainOptions::default().into(), currents);

    let [Finding::Gains { gains: found, .. }] = &found[..] else { panic!("{found:?}") };
    let mean = gains.iter().map(|gain| f64::ln(*gain)).sum::<f64>() / 6.0;
    for (found, gain) in found.iter().zip(gains) {
        let truth = gain / mean.exp();
        assert!((found / truth - 1.0).abs() < 0.1, "{found} {truth}");
    }
}
