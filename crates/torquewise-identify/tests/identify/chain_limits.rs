//! Logs that are short, still, without friction, of one joint or of six, fitted along a chain.

use crate::chain::{NOISE, WRIST, chosen, linear, rubbing, sines};
use crate::support::{
    assert_predicts, chain, fit, motion, noisy, reference_arm, threads_leave_no_trace,
};
use faer::Mat;
use torquewise_identify::{FrictionKind, score};
use torquewise_model::{GeometryFound, Torque};
use torquewise_motion::{Motion, Signals};
use torquewise_sim::{Arm, MotionKind};

#[test]
fn a_search_stops_when_three_starts_lead_to_the_same_arm() {
    let arm = Arm::builtin("planar-2").unwrap();

    let found =
        fit(&sines(&arm, 30.0, 1), &chain(FrictionKind::None)).model.training.geometry_found;

    let GeometryFound { times, starts, .. } = found.unwrap();
    assert!((3..=6).contains(&times) && starts == 6, "{times} of {starts}");
}

#[test]
fn without_friction_none_is_listed() {
    let arm = reference_arm();

    let found = fit(&rubbing(&sines(&arm, 30.0, 1), &vec![], NOISE), &chain(FrictionKind::None));

    assert!(found.model.friction.is_empty());
    assert_predicts(&found.model, &sines(&arm, 10.0, 2), 1.0);
}

#[test]
fn a_pendulum_is_a_chain_of_one() {
    let pendulum = WRIST.split("[[joints]]").take(2).collect::<Vec<_>>().join("[[joints]]");
    let arm = Arm::from_dh_toml(&pendulum).unwrap();
    let motion = sines(&arm, 20.0, 1);
    let friction = linear(&motion, &[[0.1, 0.5, 0.8]]);

    let found = fit(&rubbing(&motion, &friction, NOISE), &chain(FrictionKind::Auto));

    assert_predicts(&found.model, &rubbing(&sines(&arm, 10.0, 2), &friction, 0.0), 1.0);
}

#[test]
fn an_arm_whose_axes_stand_at_no_right_angle_is_found() {
    let arm = Arm::from_dh_toml(include_str!("oblique.toml")).unwrap();
    let moves = |seed| motion(&arm, MotionKind::Moves, 20.0, 50.0, seed);

    let found = fit(&noisy(&moves(0), 2, 0), &chain(FrictionKind::None));

    assert_predicts(&found.model, &moves(1), 5.0);
    assert_eq!(chosen(&found, "axes at right angles"), Some("free"));
}

#[test]
fn the_same_seed_gives_the_same_chain_model_at_any_number_of_threads() {
    let motion = sines(&Arm::builtin("planar-2").unwrap(), 20.0, 1);
    let log = rubbing(&motion, &linear(&motion, &[[0.1, 1.0, 1.0]; 2]), NOISE);

    assert!(threads_leave_no_trace(&log, &chain(FrictionKind::Auto)));
}

#[test]
fn joints_that_never_move_do_not_panic() {
    let log = sines(&reference_arm(), 3.0, 1);
    for moving in [0, 1, 2] {
        let signals = log.clone().into_signals();
        let held = |x: &Mat<f64>| {
            let of = |row, joint| if joint < moving { x[(row, joint)] } else { 0.0 };
            Mat::from_fn(x.nrows(), 3, of)
        };
        let (q, dq, ddq) = (held(&signals.q), held(&signals.dq), held(&signals.ddq));
        let log = Motion::new(Signals { q, dq, ddq, ..signals }).unwrap();

        let found = fit(&log, &chain(FrictionKind::Auto));

        let tau = Torque::new(&found.model).over(&log).unwrap();
        assert!(tau.is_all_finite(), "{moving} joints move");
    }
}

#[test]
fn six_joints_are_exact_without_noise_and_predicted_with_it() {
    let arm = Arm::builtin("generic-6").unwrap();
    let test = motion(&arm, MotionKind::Sines, 20.0, 100.0, 99);

    let [clean, noisy] = [1, 2].map(|case| {
        let log = noisy(&motion(&arm, MotionKind::Moves, 200.0, 100.0, 1), case, 1);
        score(&fit(&log, &chain(FrictionKind::None)).model, &test).unwrap().joints
    });

    assert!(clean.iter().all(|joint| joint.nrmse_percent < 0.1), "{clean:?}");
    let limits = [2.0, 1.0, 1.0, 5.0, 5.0];
    let good = noisy.iter().zip(limits).all(|(joint, limit)| joint.nrmse_percent < limit);
    assert!(good && noisy[5].rmse < 0.03, "{noisy:?}");
}
