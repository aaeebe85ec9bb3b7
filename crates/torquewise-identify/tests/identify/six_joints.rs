//! Learned chains of six and seven joints predict other motion.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

use torquewise_identify::plan::{ChainOptions, FrictionKind};
use torquewise_identify::{Plan, Reconstruction, reconstruct, score};
use torquewise_motion::Motion;
use torquewise_sim::{Arm, MotionKind, MotionPlan, Noise, add_noise, simulate};

fn motion(arm: &Arm, kind: MotionKind, seconds: f64, seed: u64) -> Motion {
    simulate(arm, &MotionPlan { kind, seconds, rate: 100.0, seed }).unwrap().motion
}

fn fit(arm: &Arm, case: u8) -> Reconstruction {
    let clean = motion(arm, MotionKind::Moves, 200.0, 1);
    let noisy = add_noise(&clean, &Noise::case(case).unwrap(), 1).unwrap();
    let plan = Plan::from(ChainOptions { friction: FrictionKind::None, ..ChainOptions::default() });
    reconstruct(&noisy, &plan, torquewise_identify::UNWATCHED).unwrap()
}

/// NRMSE \[%\] of each joint on another motion without noise, and its RMSE \[N·m\].
fn errors(found: &Reconstruction, arm: &Arm) -> Vec<[f64; 2]> {
    let test = motion(arm, MotionKind::Sines, 20.0, 99);
    let scores = score(&found.model, &test).unwrap();
    scores.joints.into_iter().map(|joint| [joint.nrmse_percent, joint.rmse]).collect()
}

fn six_joints() -> Arm {
    Arm::builtin("generic-6").unwrap()
}

#[test]
fn six_joints_without_noise_are_exact() {
    let arm = six_joints();

    let found = fit(&arm, 1);

    let errors = errors(&found, &arm);
    assert!(errors.iter().all(|[percent, _]| *percent < 0.1), "{errors:?}");
}

#[test]
fn six_joints_with_noise_are_predicted() {
    let arm = six_joints();

    let found = fit(&arm, 2);

    let errors = errors(&found, &arm);
    let limits = [2.0, 1.0, 1.0, 5.0, 5.0];
    let good = errors.iter().zip(limits).all(|([percent, _], limit)| *percent < limit);
    assert!(good && errors[5][1] < 0.03, "{errors:?}");
}
