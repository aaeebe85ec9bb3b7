//! From logs summed apart, merged in any order to the model of all logs together, bit for bit.

use crate::support::{State, assert_predicts, executed, fit, motion, noisy, outside};
use std::f64::consts::TAU;
use torquewise_identify::{
    ChainOptions, IdentifyError, LibraryOptions, Plan, Solution, Summary, UNWATCHED, solve,
    summarise,
};
use torquewise_model::to_json;
use torquewise_motion::Motion;
use torquewise_sim::{Arm, MotionKind};

const LOGS: usize = 8;

/// Moves of an arm, each log of another length, with noise.
fn logs() -> Vec<Motion> {
    let arm = Arm::builtin("planar-2").unwrap();
    let log = |seed: u64| {
        let seconds = 30.0 + 7.0 * seed as f64;
        noisy(&motion(&arm, MotionKind::Moves, seconds, 50.0, seed), 2, seed)
    };
    (0..LOGS as u64).map(log).collect()
}

fn parts(logs: &[Motion], plan: &Plan) -> Vec<Summary> {
    logs.iter().map(|log| summarise(log, plan, "", UNWATCHED).unwrap()).collect()
}

fn merged<'a>(parts: impl IntoIterator<Item = &'a Summary>) -> Summary {
    let mut parts = parts.into_iter();
    let mut all = parts.next().unwrap().clone();
    parts.for_each(|part| all.merge(part).unwrap());
    all
}

fn model(summary: Summary, plan: &Plan) -> String {
    match solve(summary, plan, UNWATCHED).unwrap() {
        Solution::Model(found) => to_json(&found.model).unwrap(),
        Solution::Request(request) => panic!("{} is asked for", request.name()),
    }
}

#[test]
fn any_order_and_any_grouping_solves_to_the_model_of_a_fit() {
    let logs = logs();
    for plan in [
        Plan::default(),
        Plan::from(LibraryOptions::product()),
        Plan::from(LibraryOptions::sindy()),
    ] {
        let parts = parts(&logs, &plan);
        let fitted = to_json(&fit(&logs[..], &plan).model).unwrap();

        let one = merged([3, 1, 7, 0, 6, 2, 5, 4].map(|k| &parts[k]));
        let (left, right) = (merged([6, 0, 5].map(|k| &parts[k])), merged(&parts[1..5]));
        let other = merged([&parts[7], &right, &left]);

        let bytes = one.to_bytes().unwrap();
        assert_eq!(bytes, other.to_bytes().unwrap(), "the same file");
        let read = Summary::from_bytes(&bytes).unwrap();
        assert_eq!((&read, read.logs), (&one, LOGS));
        assert_eq!(model(read, &plan), fitted);
        assert_eq!(model(other, &plan), fitted);
    }
}

#[test]
fn parts_of_other_settings_do_not_add_up() {
    let log = &logs()[..1];
    let refused = |signals: &str, plan: &Plan, word: &str| {
        let mut one = parts(log, &Plan::default()).remove(0);
        let other = summarise(&log[0], plan, signals, UNWATCHED).unwrap();
        let error = one.merge(&other).unwrap_err();
        assert!(matches!(error, IdentifyError::Apart { what, .. } if what == word), "{error}");
    };

    refused("", &Plan::from(LibraryOptions::product()), "library");
    refused("", &Plan::from(LibraryOptions::sindy()), "method");
    refused("low-pass", &Plan::default(), "signals");
    let clusters = torquewise_identify::PatternPlan { clusters: Some(2), ..Default::default() };
    refused("", &Plan { patterns: clusters, ..Plan::default() }, "patterns");
}

#[test]
fn a_damaged_file_is_refused_wherever_it_was_hit() {
    let bytes = parts(&logs()[..1], &Plan::default()).remove(0).to_bytes().unwrap();
    let step = bytes.len() / 200;

    for place in (0..bytes.len()).step_by(step.max(1)) {
        let mut hit = bytes.clone();
        hit[place] ^= 0x10;
        assert!(matches!(Summary::from_bytes(&hit), Err(IdentifyError::Moments(_))), "{place}");
        let cut = Summary::from_bytes(&bytes[..place]);
        assert!(matches!(cut, Err(IdentifyError::Moments(_))), "cut at {place}");
    }
}

#[test]
fn logs_of_one_pattern_each_are_fitted_together() {
    let arm = Arm::builtin("planar-2").unwrap();
    let staged = noisy(&motion(&arm, MotionKind::Staged, 240.0, 50.0, 2), 2, 2);
    let third = 4_000;
    let stage = |k: usize| staged.select(&(k * third..(k + 1) * third).collect::<Vec<_>>());
    let stages = [stage(0), stage(1), stage(2)];

    let found = fit(&stages[..], &Plan::default());

    assert_predicts(&found.model, &outside(&arm), 1.0);
}

/// A stroke of a pen: the arm sets out from rest and comes to rest, but never dwells.
fn stroke(arm: &Arm, seed: u64) -> Motion {
    const SECONDS: f64 = 5.0;
    let rows = 126;
    let turn = TAU / SECONDS;
    let t: Vec<f64> = (0..rows).map(|row| SECONDS * f64::from(row) / 125.0).collect();
    // Time as the pen has it: it stands still at both ends.
    let state = |t: f64, joint: usize| {
        let (sin, cos) = (turn * t).sin_cos();
        let (way, speed, gain) = (t - sin / turn, 1.0 - cos, turn * sin);
        let rate = 0.8 + 0.5 * joint as f64 + 0.07 * seed as f64;
        let (sin, cos) = (rate * way + 1.7 * seed as f64 + joint as f64).sin_cos();
        [
            0.9 * sin,
            0.9 * rate * cos * speed,
            0.9 * rate * (cos * gain - rate * sin * speed * speed),
        ]
    };
    let states: Vec<State> = t
        .iter()
        .map(|&t| {
            let joints = [0, 1].map(|joint| state(t, joint));
            [0, 1, 2].map(|order| joints.iter().map(|state| state[order]).collect())
        })
        .collect();
    executed(arm, t, &states)
}

#[test]
fn the_slowest_motion_of_a_short_log_is_not_standstill() {
    let arm = Arm::builtin("planar-2").unwrap();
    let strokes: Vec<Motion> = (0..20).map(|seed| stroke(&arm, seed)).collect();

    let found = fit(&strokes[..], &Plan::default());

    let training = &found.model.training;
    for (residual, spread) in training.residual_rms.iter().zip(&training.torque_std) {
        assert!(residual < &(1e-9 * spread), "{residual} of {spread}");
    }
}

#[test]
fn moments_for_a_chain_hold_no_sums_of_a_library() {
    let summary = parts(&logs()[..1], &Plan::from(ChainOptions::default())).remove(0);

    let error = solve(summary, &Plan::default(), UNWATCHED).unwrap_err();

    assert!(matches!(error, IdentifyError::NoLibrary), "{error}");
}
