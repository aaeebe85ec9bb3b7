//! Learned chains of six and seven joints predict other motion.

use crate::support::{chain, motion, noisy};
use torquewise_identify::plan::FrictionKind;
use torquewise_identify::{Reconstruction, score};
use torquewise_sim::{Arm, MotionKind};

fn fit(arm: &Arm, case: u8) -> Reconstruction {
    let log = noisy(&motion(arm, MotionKind::Moves, 200.0, 100.0, 1), case, 1);
    crate::support::fit(&log, &chain(FrictionKind::None))
}

/// NRMSE \[%\] of each joint on another motion without noise, and its RMSE \[N·m\].
fn errors(found: &Reconstruction, arm: &Arm) -> Vec<[f64; 2]> {
    let test = motion(arm, MotionKind::Sines, 20.0, 100.0, 99);
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
