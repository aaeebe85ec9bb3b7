//! Limits → plan → torque of the reference arm → model: it predicts what it has not seen.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use faer::Mat;
use torquewise_identify::{Plan as FitPlan, reconstruct, score};
use torquewise_motion::{Motion, Pattern, Recording};
use torquewise_sim::excite::{Plan, Planned, Wishes, excite, limits};
use torquewise_sim::{Arm, MotionKind, MotionPlan, simulate};

/// The recording with the torque the arm needs for it.
fn executed(arm: &Arm, recording: &Planned) -> Motion {
    let mut rows: Vec<[Vec<f64>; 4]> = Vec::new();
    let mut t = Vec::new();
    let read = recording.read(&mut |_, block| {
        for row in 0..block.n_rows() {
            let of = |x: faer::MatRef<'_, f64>| x.row(row).iter().copied().collect::<Vec<f64>>();
            let (q, dq, ddq) = (of(block.q()), of(block.dq()), of(block.ddq()));
            let tau = arm.inverse_dynamics(&q, &dq, &ddq);
            t.push(block.t()[row]);
            rows.push([q, dq, ddq, tau]);
        }
        Ok(())
    });
    read.unwrap();
    let signal =
        |k: usize| Mat::from_fn(rows.len(), arm.n_joints(), |row, joint| rows[row][k][joint]);
    Motion::new(torquewise_motion::Signals {
        joints: arm.joints().to_vec(),
        t,
        q: signal(0),
        dq: signal(1),
        ddq: signal(2),
        tau: Some(signal(3)),
    })
    .unwrap()
}

#[test]
fn the_model_of_a_planned_log_predicts_sines_it_has_not_seen() {
    let arm = Arm::builtin("puma560-3").unwrap();
    let limits = limits(&arm, &Wishes::default()).unwrap();
    for slow_sweeps in [false, true] {
        let plan = Plan { tries: 6, seed: 1, slow_sweeps, ..Plan::default() };
        let planned = excite(&limits, None, &plan, &mut |_, _| {}).unwrap();
        let log = planned.recordings.each_ref().map(|recording| executed(&arm, recording));

        let found =
            reconstruct(&log[..], &FitPlan::default(), torquewise_identify::UNWATCHED).unwrap();

        assert_eq!(found.patterns.present, Pattern::ALL, "creeping: {slow_sweeps}");
        let unseen = MotionPlan { kind: MotionKind::Sines, seconds: 20.0, rate: 100.0, seed: 77 };
        let unseen = simulate(&arm, &unseen).unwrap().motion;
        for joint in score(&found.model, &unseen).unwrap().joints {
            assert!(joint.nrmse_percent < 1e-4, "{joint:?}");
        }
    }
}
