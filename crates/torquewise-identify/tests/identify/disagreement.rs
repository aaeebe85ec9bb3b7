//! Arms with and without payload, against the payload; arms alike, against silence.

use crate::support::{fit, motion, noisy, with_torque};
use torquewise_identify::{Disagreement, Plan, disagreements};
use torquewise_motion::{Motion, Signals};
use torquewise_sim::{Arm, MotionKind};

/// Three links; the hand weighs so much.
fn arm(hand: f64) -> Arm {
    Arm::from_dh_toml(&include_str!("hand.toml").replace("HAND", &format!("{hand:?}"))).unwrap()
}

fn log(hand: f64, seconds: f64, kind: MotionKind, seed: u64) -> Motion {
    noisy(&motion(&arm(hand), kind, seconds, 50.0, seed), 2, seed)
}

fn with_friction(log: Motion, viscous: f64, dry: f64) -> Motion {
    with_torque(log, |[_, dq, _], tau| {
        for (tau, dq) in tau.iter_mut().zip(dq) {
            *tau += viscous * dq + dry * (dq / 0.01).tanh();
        }
    })
}

fn found(logs: &[Motion]) -> Vec<Disagreement> {
    let model = fit(logs, &Plan::default()).model;
    disagreements(&model, logs, &|k| format!("log {k}")).unwrap()
}

fn joints(found: &Disagreement) -> Vec<&str> {
    found.joints.iter().map(|at_odds| at_odds.joint.as_str()).collect()
}

#[test]
fn a_payload_is_told_and_measured() {
    for lengths in [[60.0, 60.0], [120.0, 30.0]] {
        let bare = log(3.0, lengths[0], MotionKind::Moves, 1);
        let laden = log(3.6, lengths[1], MotionKind::Moves, 2);

        let found = found(&[bare, laden]);

        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(found[0].logs, ["log 0", "log 1"]);
        assert_eq!(joints(&found[0]), ["boom", "hand"]);
        // The axis of the hand carries the hand alone: its gravity grows as its mass.
        let hand = &found[0].joints[1];
        let ratio = (1.0 + hand.excess[1]) / (1.0 + hand.excess[0]);
        let error = hand.std_error[0].hypot(hand.std_error[1]);
        assert!((ratio - 1.2).abs() < 6.0 * error + 0.01, "{ratio} {hand:?}");
        assert!(hand.excess[0] < 0.0 && hand.excess[1] > 0.0, "{hand:?}");
        assert!(
            found[0].to_string().contains("log 0 and log 1 disagree about the gravity of boom")
        );
    }
}

#[test]
fn the_log_with_the_payload_is_named_among_others() {
    let moves = |hand, seed| log(hand, 40.0, MotionKind::Moves, seed);

    let found = found(&[moves(3.0, 1), moves(3.0, 2), moves(4.0, 3), moves(3.0, 4)]);

    assert!(!found.is_empty());
    for disagreement in &found {
        assert!(disagreement.logs.contains(&"log 2".to_owned()), "{disagreement}");
    }
}

#[test]
fn logs_of_one_arm_agree_whatever_their_motion_and_friction() {
    let moves = |seed| log(3.0, 30.0, MotionKind::Moves, seed);
    let sines = log(3.0, 30.0, MotionKind::Sines, 5);

    for logs in [
        vec![moves(1), moves(2)],
        vec![moves(1), sines.clone()],
        vec![with_friction(moves(1), 0.5, 0.4), with_friction(moves(2), 0.9, 0.7)],
        vec![with_friction(moves(1), 0.5, 0.4), with_friction(sines, 0.5, 0.4)],
        (1..9).map(|seed| log(3.0, 10.0, MotionKind::Moves, seed)).collect(),
    ] {
        assert_eq!(found(&logs), []);
    }
}

#[test]
fn what_friction_holds_at_rest_is_no_payload() {
    let held = |seed, part: f64| {
        let arm = arm(3.0);
        with_torque(log(3.0, 60.0, MotionKind::Moves, seed), |[q, dq, _], tau| {
            let gravity = arm.gravity_torque(q);
            let joints = tau.iter_mut().zip(dq).zip(gravity);
            joints
                .filter(|((_, dq), _)| dq.abs() < 0.01)
                .for_each(|((tau, _), own)| *tau += part * own);
        })
    };

    assert_eq!(found(&[held(1, 0.1), held(2, -0.1)]), []);
}

#[test]
fn one_log_agrees_with_itself_though_it_has_gaps_and_one_without_torque_is_refused() {
    let moves = |hand, seed| log(hand, 40.0, MotionKind::Moves, seed);
    let logs = [moves(3.0, 1), moves(4.0, 2)];
    let model = fit(&logs[..], &Plan::default()).model;

    assert_eq!(disagreements(&model, &logs[..], &|_| "one".into()).unwrap(), []);
    assert_ne!(disagreements(&model, &logs[..], &|k| k.to_string()).unwrap(), []);
    // Of a torque that the model does not follow, gravity is not told.
    let mut missed = model.clone();
    missed.training.residual_rms.clone_from(&model.training.torque_std);
    assert_eq!(disagreements(&missed, &logs[..], &|k| k.to_string()).unwrap(), []);
    let [bare, _] = logs.map(Motion::into_signals);
    let without = Motion::new(Signals { tau: None, ..bare }).unwrap();
    assert!(disagreements(&model, &without, &|_| String::new()).is_err());
}
