//! A chain refined by rollouts moves more like the arm, and says its torque as well.

use crate::support;
use crate::support::{normals, reference_arm};
use faer::Mat;
use torquewise_identify::{
    ChainOptions, FrictionKind, IdentifyError, Plan, Refine, UNWATCHED, reconstruct,
};
use torquewise_model::rollout::drifts;
use torquewise_model::{Model, Torque};
use torquewise_motion::{Motion, Signals};
use torquewise_sim::MotionKind;

fn motion(seconds: f64, seed: u64) -> Motion {
    support::motion(&reference_arm(), MotionKind::Moves, seconds, 100.0, seed)
}

/// The same seen by a differentiator that adds as much noise to accelerations as there is signal:
/// inertias that are fitted to them are too small (E7).
fn blurred(motion: &Motion) -> Motion {
    let mut normal = normals(2);
    let rms = motion.ddq().norm_l2() / ((motion.n_rows() * motion.n_joints()) as f64).sqrt();
    let ddq = Mat::from_fn(motion.n_rows(), motion.n_joints(), |i, j| {
        motion.ddq()[(i, j)] + rms * normal()
    });
    Motion::new(Signals { ddq, ..motion.clone().into_signals() }).unwrap()
}

fn learned(log: &Motion, refine: Option<Refine>) -> Result<Model, IdentifyError> {
    let (friction, noise_correction) = (FrictionKind::Linear, false);
    let options = ChainOptions { friction, noise_correction, refine, ..ChainOptions::default() };
    Ok(reconstruct(log, &Plan::from(options), UNWATCHED)?.model)
}

#[test]
fn inertia_that_accelerations_say_too_small_is_mended_by_rollouts() {
    let (log, other) = (blurred(&motion(30.0, 1)), motion(20.0, 2));
    let [plain, refined] = [None, Some(Refine::Rollout)].map(|way| learned(&log, way).unwrap());

    let drift = |model: &Model| -> f64 {
        let found = drifts(model, None, &other, &[0.5]).unwrap();
        found[0].rms_drift_rad.iter().map(|rms| rms * rms).sum::<f64>().sqrt()
    };
    let missed =
        |model: &Model| (Torque::new(model).over(&log).unwrap() - log.tau().unwrap()).norm_l2();
    assert!(drift(&refined) < 0.85 * drift(&plain), "{} {}", drift(&refined), drift(&plain));
    assert!(missed(&refined) < 1.03 * missed(&plain), "{} {}", missed(&refined), missed(&plain));
    let what = |model: &Model| model.choices.iter().any(|own| own.what.contains("windows"));
    assert!(what(&refined) && !what(&plain));
    assert!(refined.chain.as_ref().unwrap().is_feasible());
}

#[test]
fn a_log_without_windows_is_refused() {
    let error = learned(&motion(1.0, 1), Some(Refine::Rollout)).unwrap_err();

    assert!(matches!(error, IdentifyError::TooFewWindows { needed: 8, .. }), "{error}");
}
