//! Torques of the wrong sign are named, one and all.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use torquewise_identify::excitation::Finding;
use torquewise_identify::{Plan, Warning, reconstruct};
use torquewise_motion::Motion;
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
    let found = reconstruct(&Motion::new(signals).unwrap(), &Plan::default(), &mut |_| {}).unwrap();
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

/// Joints whose torques a fit says to be swapped once those of a pair are.
fn swapped(pair: Option<[usize; 2]>) -> Option<[String; 2]> {
    let plan = MotionPlan { kind: MotionKind::Moves, seconds: 40.0, rate: 100.0, seed: 1 };
    let motion = simulate(&Arm::builtin("generic-4").unwrap(), &plan).unwrap().motion;
    let mut signals = motion.into_signals();
    let dq = signals.dq.clone();
    let tau = signals.tau.as_mut().unwrap();
    for joint in 0..tau.ncols() {
        let spread = (tau.col(joint).squared_norm_l2() / tau.nrows() as f64).sqrt();
        for row in 0..tau.nrows() {
            tau[(row, joint)] += 0.1 * spread * (dq[(row, joint)] / 0.02).tanh();
        }
    }
    if let Some([a, b]) = pair {
        for row in 0..tau.nrows() {
            (tau[(row, a)], tau[(row, b)]) = (tau[(row, b)], tau[(row, a)]);
        }
    }
    let found = reconstruct(&Motion::new(signals).unwrap(), &Plan::default(), &mut |_| {}).unwrap();
    found.warnings.into_iter().find_map(|warning| match warning {
        Warning::Excitation(Finding::Swapped { joints }) => Some(joints),
        _ => None,
    })
}

#[test]
fn torques_that_are_swapped_are_named() {
    let joints = Arm::builtin("generic-4").unwrap().joints().to_vec();
    assert_eq!(swapped(None), None);
    for [a, b] in [[0, 1], [1, 2], [0, 3], [2, 3]] {
        let expected = [joints[a].clone(), joints[b].clone()];
        assert_eq!(swapped(Some([a, b])), Some(expected));
    }
}
