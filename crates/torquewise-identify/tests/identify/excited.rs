//! Limits → plan → torque of the reference arm → model: it predicts what it has not seen.
use crate::support::{assert_predicts, executed, fit, outside, reference_arm, states_of};
use torquewise_identify::Plan;
use torquewise_motion::Pattern;
use torquewise_sim::excite::{ExcitationPlan, Wishes, excite, limits};

#[test]
fn the_model_of_a_planned_log_predicts_sines_it_has_not_seen() {
    let arm = reference_arm();
    let limits = limits(&arm, &Wishes::default()).unwrap();
    for slow_sweeps in [false, true] {
        let plan = ExcitationPlan { tries: 6, seed: 1, slow_sweeps, ..ExcitationPlan::default() };
        let planned = excite(&limits, None, &plan, &mut |_, _| {}).unwrap();
        let logs = planned.recordings.each_ref().map(|recording| {
            let motion = recording.motion().unwrap();
            executed(&arm, motion.t().to_vec(), &states_of(&motion))
        });

        let found = fit(&logs[..], &Plan::default());

        assert_eq!(found.patterns.present, Pattern::ALL, "creeping: {slow_sweeps}");
        assert_predicts(&found.model, &outside(&arm), 1e-4);
    }
}
