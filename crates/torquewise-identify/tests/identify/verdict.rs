//! The grade of a model and its reasons, each of a fit that is good but for one thing.

use crate::support::{chain, fit, motion, reference_arm, with_torque};
use torquewise_identify::verdict::{Grade, judge, judge_by};
use torquewise_identify::{FrictionKind, Plan, Reconstruction, Warning};
use torquewise_model::GeometryFound;
use torquewise_sim::{Arm, MotionKind};

#[test]
fn what_is_wrong_decides_the_grade_and_stands_among_its_reasons() {
    let log = motion(&Arm::builtin("planar-2").unwrap(), MotionKind::Moves, 20.0, 50.0, 1);
    let good = fit(&log, &Plan::default());
    let judged = |found: Reconstruction| judge(&found);
    let warned =
        |warning: Warning| judged(Reconstruction { warnings: vec![warning], ..good.clone() });
    let mut kept = good.model.clone();
    kept.training.verdict = Some(judge(&good));
    let tested = |errors: &[f64], held: Option<&[f64]>| judge_by(&kept, errors, held);
    let mut unsure = good.clone();
    let (times, starts, unresolved) = (1, 48, Vec::new());
    unsure.model.training.geometry_found = Some(GeometryFound { times, starts, unresolved });
    let mut short = good.clone();
    short.model.training.held_out_rms.clear();
    short.model.training.held_out_by_region_rms.clear();
    let mut elsewhere = good.clone();
    elsewhere.model.training.held_out_by_region_rms = good.model.training.torque_std.clone();
    let (joints, gains) = (good.model.joints.clone(), vec![[2.0, 0.1], [0.5, 0.1]]);
    let gains = Warning::Gains { joints: joints.clone(), gains };
    let cases = vec![
        (judge(&good), Grade::Good, "held-out error 0.00"),
        (tested(&[f64::NAN; 2], None), Grade::Usable, "no torque of the test changes"),
        (tested(&[0.01, 0.02], Some(&[93.0, 96.0])), Grade::Good, "test error 1.00 to 2.00 %"),
        (tested(&[0.01, 0.02], Some(&[70.0, 50.0])), Grade::Usable, "intervals hold 60 %"),
        (tested(&[0.01, 0.4], None), Grade::Usable, "missed by more than 30 %"),
        (tested(&[0.01, 0.95], None), Grade::Unusable, "hardly better than by its mean"),
        (tested(&[0.6, 0.6], None), Grade::Unusable, "60 % of the torque is missed"),
        (tested(&[0.01, f64::NAN], None), Grade::Good, "test error 1.00 to 1.00 %"),
        (judged(unsure), Grade::Usable, "by only 1 of 48 starts"),
        (judged(elsewhere), Grade::Usable, "hardly better than by its mean in regions held out"),
        (judged(short), Grade::Usable, "too few rows to hold any out"),
        (warned(Warning::Repeated), Grade::Usable, "given twice"),
        (warned(Warning::NotPhysical(String::new())), Grade::Usable, "not positive definite"),
        (warned(gains), Grade::Unusable, "not in one unit"),
        (warned(Warning::WrongSign { joints }), Grade::Unusable, "wrong sign"),
    ];
    for (verdict, grade, reason) in cases {
        assert_eq!(verdict.grade, grade, "{reason}: {verdict}");
        let is_said = verdict.because.iter().any(|own| own.contains(reason));
        assert!(is_said, "{reason} is not among {:?}", verdict.because);
    }
}

#[test]
fn what_friction_may_hold_at_rest_does_not_count() {
    let log = motion(&reference_arm(), MotionKind::Moves, 60.0, 50.0, 1);
    let rubbing = with_torque(log, |[q, dq, _], tau| {
        for (joint, tau) in tau.iter_mut().enumerate() {
            let held = (300.0 * q[0] + joint as f64).sin();
            *tau += 20.0 * if dq[joint].abs() > 1e-3 { dq[joint].signum() } else { held };
        }
    });

    let found = fit(&rubbing, &chain(FrictionKind::Auto));

    let errors = found.model.training.held_out_errors().unwrap();
    assert!(errors.iter().any(|error| *error > 0.1), "{errors:?}");
    assert!(found.warnings.iter().any(|own| matches!(own, Warning::Held { .. })));
    assert_eq!(judge(&found).grade, Grade::Good, "{}", judge(&found));
}
