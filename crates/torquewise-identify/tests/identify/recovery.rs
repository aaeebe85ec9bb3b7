//! From simulated log to the terms and coefficients it was simulated with.

use crate::shared::shared;
use crate::support::{
    assert_predicts, fit, motion, noisy, outside, percent, reference_arm, threads_leave_no_trace,
};
use crate::truth;
use std::collections::BTreeMap;
use torquewise_identify::{LibraryOptions, Plan, score};
use torquewise_logs::Logs;
use torquewise_model::{Form, check};
use torquewise_motion::{Motion, Pattern};
use torquewise_sim::{Arm, MotionKind, MotionPlan, simulate};
use torquewise_stepwise::orders::{OrderPlan, orders};

fn moves(arm: &Arm, seconds: f64, case: u8, seed: u64) -> Motion {
    noisy(&motion(arm, MotionKind::Moves, seconds, 100.0, seed), case, seed)
}

#[test]
fn without_noise_the_true_terms_and_coefficients_are_recovered() {
    let arm = reference_arm();
    let log = moves(&arm, 300.0, 1, 1);

    let found = fit(&log, &Plan::default());

    let truth = truth::true_energies(&arm);
    let Form::Energy(terms) = &found.model.form else { panic!("an energy model was asked for") };
    let energies: BTreeMap<_, _> = terms.iter().map(|w| (&w.term, w.coefficient)).collect();
    assert_eq!(truth.len(), 23);
    assert!(energies.keys().copied().eq(truth.keys()), "the same terms");
    for (term, coefficient) in energies {
        // The condition of the rows is about 1e3, that of the projection less.
        assert!((coefficient - truth[term]).abs() < 1e-10, "{}", term.name());
    }
    assert_predicts(&found.model, &outside(&arm), 1e-6);
}

#[test]
fn patterns_are_the_true_ones_under_noise() {
    let arm = reference_arm();
    for case in [2, 3] {
        let plan = MotionPlan { kind: MotionKind::Moves, seconds: 600.0, rate: 100.0, seed: 1 };
        let simulation = simulate(&arm, &plan).unwrap();
        let log = noisy(&simulation.motion, case, 1);

        let found = fit(&log, &Plan::default());

        assert_eq!(found.patterns.n_clusters(), 3);
        let labels = found.patterns.label(&log);
        for pattern in Pattern::ALL {
            let rows = simulation.truth.iter().zip(&labels).filter(|(truth, _)| **truth == pattern);
            let (all, right) = rows.fold((0.0, 0.0), |(all, right), (_, label)| {
                (all + 1.0, right + f64::from(u8::from(*label == pattern)))
            });
            assert!(right >= 0.99 * all, "{}: {right} of {all}", pattern.name());
        }
    }
}

#[test]
fn the_product_library_is_exact_without_noise_close_with_it_and_not_filled_by_a_short_log() {
    let arm = reference_arm();
    let test = outside(&arm);
    for (case, most) in [(1, 0.01), (2, 0.5), (3, 7.0)] {
        let log = moves(&arm, 600.0, case, 1);

        let found = fit(&log, &Plan::from(LibraryOptions::product()));

        assert_eq!(found.steps.iter().map(|s| s.candidates).collect::<Vec<_>>(), [25, 774, 387]);
        assert!(percent(&found.model, &test).iter().all(|&percent| percent < most), "case {case}");
    }
    let log = moves(&arm, 120.0, 3, 1);

    let found = fit(&log, &Plan::from(LibraryOptions::product()));

    // The truth has 74 terms; some fifteen strokes cannot tell 774 candidates apart.
    assert!(found.model.form.n_coefficients() < 120, "{}", found.model.form.n_coefficients());
    assert_predicts(&found.model, &test, 10.0);
}

#[test]
fn an_energy_model_is_physics_by_construction() {
    let arm = Arm::builtin("generic-4").unwrap();
    let log = moves(&arm, 200.0, 2, 3);

    let found = fit(&log, &Plan::default());

    let states: Vec<(Vec<f64>, Vec<f64>)> = (0..20)
        .map(|k| {
            let wave = |joint: usize| (f64::from(k) * 1.7 + joint as f64).sin();
            ((0..4).map(wave).collect(), (4..8).map(wave).collect())
        })
        .collect();
    let checks = check(&found.model, &states).unwrap();
    assert!(checks.asymmetry < 1e-12 && checks.skew_defect < 1e-6, "{checks:?}");
    assert!(checks.smallest_eigenvalue > 0.0, "{checks:?}");
}

#[test]
fn the_noise_is_read_from_standstill() {
    let arm = reference_arm();
    let log = moves(&arm, 300.0, 3, 5);

    let found = fit(&log, &Plan::default());

    for joint in 0..3 {
        let mean_square = log.ddq().col(joint).squared_norm_l2() / log.n_rows() as f64;
        let expected = (mean_square / 1e3).sqrt();
        let ratio = found.noise.ddq[joint] / expected;
        assert!((0.95..1.05).contains(&ratio), "joint {joint}: {ratio}");
    }
}

#[test]
fn each_step_explains_more_of_a_motion_outside_the_training_set() {
    let arm = reference_arm();
    let log = moves(&arm, 300.0, 2, 1);
    let test = outside(&arm);

    let found = fit(&log, &Plan::default());

    let errors: Vec<f64> = (1..=3)
        .map(|step| {
            let model = found.model.after_step(step).unwrap();
            score(&model, &test).unwrap().joints.iter().map(|joint| joint.rmse).sum()
        })
        .collect();
    assert!(errors[1] < errors[0] && errors[2] < 0.05 * errors[1], "{errors:?}");
}

#[test]
fn the_same_seed_gives_the_same_model_at_any_number_of_threads() {
    let arm = Arm::builtin("planar-2").unwrap();
    let log = moves(&arm, 200.0, 3, 2);

    assert!(threads_leave_no_trace(&log, &Plan::from(LibraryOptions::product())));
}

#[test]
fn a_log_without_patterns_is_fitted_in_one_step_with_a_warning() {
    let arm = Arm::builtin("planar-2").unwrap();
    let log = outside(&arm);

    let found = fit(&log, &Plan::default());

    assert!(!found.warnings.is_empty());
    assert_predicts(&found.model, &motion(&arm, MotionKind::Sines, 5.0, 100.0, 4), 1e-6);
}

#[test]
fn orders_are_those_the_arm_needs() {
    let arm = reference_arm();
    let log = moves(&arm, 200.0, 1, 1);

    let plan = OrderPlan { trig_order: 3, whole_order: 1, ..OrderPlan::default() };
    let curves = orders(&log, &plan).unwrap();

    let chosen = |name: &str| {
        let curve = curves.iter().find(|curve| curve.name == name).unwrap();
        &curve.points[curve.chosen]
    };
    // Gravity is of two angles, and so is every function in this arm's M and V.
    assert_eq!([chosen("standstill").order, chosen("energy").order], [2, 2]);
    assert!(chosen("energy").residual.iter().all(|part| *part < 1e-5));
}

/// Their torques were computed by Pinocchio; the energy library spans them exactly (E4).
#[test]
fn random_states_of_the_reference_arm_predict_held_out_states() {
    let Some(file) = shared("oracle/puma560-3.csv") else { return };
    let states = Logs::open(&[file]).unwrap().read_all().unwrap().remove(0);
    let every_second = |first| (first..states.n_rows()).step_by(2).collect::<Vec<usize>>();
    let [train, test] = [0, 1].map(|first| states.select(&every_second(first)));

    let found = fit(&train, &Plan::default());

    assert_eq!(found.model.form.n_coefficients(), 23);
    assert_predicts(&found.model, &test, 1e-7);
}
