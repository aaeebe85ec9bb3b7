//! Indicators against planted truths: noise simulated, rows alike, heaps of rows.

use super::first_fit::FirstFit;
use super::refit::refit;
use super::sorting::Indicators;
use super::steps::take_steps;
use super::variance::{effective_variance, inverse_weights};
use super::*;
use crate::study::indicators::clusters::informative;
use faer::Mat;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use torquewise_model::{Torque, model::Training};
use torquewise_motion::motion::Signals;
use torquewise_stepwise::NoiseFloor;

const N: usize = 3;
/// Noisy copies of a state.
const COPIES: usize = 20_000;
/// Four standard deviations of a variance estimated from them, √(2/m) each.
const TOLERANCE: f64 = 0.04;

fn true_model() -> Model {
    let energies = true_energies(&Arm::builtin("puma560-3").unwrap());
    let weigh =
        |(term, coefficient)| Weighted { term, coefficient, std_error: 0.0, inclusion: None };
    Model {
        joints: (1..=N).map(|joint| format!("joint{joint}")).collect(),
        form: Form::Energy(energies.into_iter().map(weigh).collect()),
        chain: None,
        friction: Vec::new(),
        stages: Vec::new(),
        training: Training::default(),
        choices: Vec::new(),
    }
}

fn noise() -> NoiseFloor {
    NoiseFloor { q: vec![1e-3; N], dq: vec![0.02; N], ddq: vec![0.1, 0.2, 0.3] }
}

/// `rows` copies of one state, with noise of the given strength, and the torque of the state.
fn copies(rows: usize, strength: f64, torque_noise: f64) -> Motion {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let noise = noise();
    let mut signal = |values: [f64; N], sigmas: &[f64]| {
        Mat::from_fn(rows, N, |_, joint| {
            let unit: f64 = StandardNormal.sample(&mut random);
            values[joint] + strength * sigmas[joint] * unit
        })
    };
    let signals = Signals {
        joints: true_model().joints,
        t: (0..rows).map(|row| row as f64).collect(),
        q: signal([0.4, -0.7, 1.1], &noise.q),
        dq: signal([0.8, -0.5, 1.3], &noise.dq),
        ddq: signal([1.0, 2.0, -1.5], &noise.ddq),
        tau: None,
    };
    let tau = signal([0.0; N], &[torque_noise / strength.max(1e-300); N]);
    let still = Arm::builtin("puma560-3").unwrap().inverse_dynamics(
        &[0.4, -0.7, 1.1],
        &[0.8, -0.5, 1.3],
        &[1.0, 2.0, -1.5],
    );
    let tau = Mat::from_fn(rows, N, |row, joint| still[joint] + tau[(row, joint)]);
    Motion::new(Signals { tau: Some(tau), ..signals }).unwrap()
}

fn scenario(noise: Decibels) -> Scenario {
    Scenario { arm: "planar-2", seconds: 30.0, noise, seed: 3 }
}

#[test]
fn the_propagated_variance_is_that_of_residuals_under_simulated_noise() {
    let (model, noisy) = (true_model(), copies(COPIES, 1.0, 0.0));

    let expected = noise().in_torque(&Torque::new(&model), &copies(1, 0.0, 0.0)).unwrap();

    let torque = Torque::new(&model).over(&noisy).unwrap();
    for joint in 0..N {
        let tau = noisy.require_tau().unwrap();
        let squares = (0..COPIES).map(|row| (torque[(row, joint)] - tau[(row, joint)]).powi(2));
        let found = squares.sum::<f64>() / COPIES as f64;
        let ratio = found / expected[(0, joint)];
        assert!((ratio - 1.0).abs() < TOLERANCE, "joint {joint}: {ratio}");
    }
}

#[test]
fn what_the_propagated_noise_leaves_of_the_residual_is_noise_of_the_torque() {
    let (model, log) = (true_model(), copies(COPIES, 1.0, 2.0));

    let propagated = noise().in_torque(&Torque::new(&model), &log).unwrap();
    let effective = effective_variance(&model, &log, &noise()).unwrap();

    for joint in 0..N {
        let difference = effective[(0, joint)] - propagated[(0, joint)];
        let uncertain = TOLERANCE * effective[(0, joint)];
        assert!((difference - 4.0).abs() < uncertain, "joint {joint}: {difference}");
    }
}

#[test]
fn without_noise_all_rows_weigh_the_same() {
    let first = FirstFit::new(&scenario(Decibels::NONE), Method::Energy).unwrap();
    let indicators = Indicators::new(&first).unwrap();

    let [plain, weighted] = [Sorting::Activation, Sorting::InverseVariance]
        .map(|sorting| indicators.sort(sorting).unwrap());

    assert!(first.noise.is_none());
    assert!(plain.refit == weighted.refit, "the last fit");
    for (plain, weighted) in plain.steps.iter().zip(&weighted.steps) {
        assert!(plain.weights == weighted.weights, "a step");
    }
}

#[test]
fn weights_are_one_over_the_variance_with_a_mean_of_one() {
    let weights = inverse_weights(&[1.0, 2.0, 4.0, 4.0]);

    assert_eq!(weights, [2.0, 1.0, 0.5, 0.5]);
    assert_eq!(inverse_weights(&[0.0, 0.0]), [1.0, 1.0]);
}

#[test]
fn equal_weights_find_the_terms_of_the_reconstruction() {
    for method in [Method::Energy, Method::Product] {
        let first = FirstFit::new(&scenario(Decibels::case(3)), method).unwrap();
        let sorted = Indicators::new(&first).unwrap().sort(Sorting::Activation).unwrap();

        let selected = take_steps(&first, &sorted.steps).unwrap();
        let [found, _] = refit(&first, &selected, &sorted.refit).unwrap();

        let terms = |model: &Model| -> BTreeSet<String> {
            match &model.form {
                Form::Energy(terms) => terms.iter().map(|w| w.term.name()).collect(),
                Form::Torque(joints) => {
                    let named = |(joint, terms): (usize, &Vec<Weighted<Term>>)| {
                        terms.iter().map(move |w| format!("{joint} {}", w.term.name())).collect()
                    };
                    joints
                        .iter()
                        .enumerate()
                        .flat_map(|joint| -> Vec<String> { named(joint) })
                        .collect()
                }
            }
        };
        assert_eq!(terms(&first.model_with(&found)), terms(&first.model), "{method:?}");
    }
}

#[test]
fn leverages_of_a_regression_sum_to_its_number_of_terms() {
    let first = FirstFit::new(&scenario(Decibels::case(3)), Method::Energy).unwrap();
    let step = &first.steps[0];
    let rows = first.rows_of(step);
    let ones = Mat::full(rows.len(), 2, 1.0);

    let leverage = super::leverage::leverage(&first, step, &rows, &ones).unwrap();

    let sum: f64 = (0..2).flat_map(|joint| leverage.col_as_slice(joint)).sum();
    let mut kept = first.kept_columns(&first.groups[0], step);
    kept.retain(|column| step.offered.contains(column));
    // Some hundred rows, normal equations of a condition below 1e4.
    assert!((sum - kept.len() as f64).abs() < 1e-9, "{sum}");
}

#[test]
fn a_heap_of_noisy_rows_without_leverage_is_left_out() {
    let wave = |row: usize, scale: f64| scale * (1.0 + 0.3 * (row as f64).sin());
    let variance: Vec<f64> =
        (0..300).map(|row| wave(row, if row < 100 { 1.0 } else { 50.0 })).collect();
    let leverage: Vec<f64> =
        (0..300).map(|row| wave(7 * row, if row < 100 { 1.0 } else { 0.02 })).collect();

    let found = informative(&variance, &leverage).unwrap();

    assert_eq!(found.elbow, 2);
    assert!((0..300).all(|row| found.kept[row] == (row < 100)));
}

#[test]
fn the_same_seed_gives_the_same_results() {
    let smallest = |seed| {
        let settings = Settings { seconds: 20.0, seeds: 1, ..Settings::quick(seed) };
        serde_json::to_string(&study_indicators(&settings).unwrap()).unwrap()
    };

    assert_eq!(smallest(1), smallest(1));
    assert_ne!(smallest(1), smallest(2));
}
