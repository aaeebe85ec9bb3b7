//! From log in memory to model: the default fit, beside the libraries of the paper.

use divan::Bencher;
use torquewise_identify::{Plan, reconstruct};
use torquewise_motion::Motion;
use torquewise_sim::{Arm, MotionKind, MotionPlan, Noise, add_noise, simulate};

const ROWS: usize = 60_000;
const RATE: f64 = 250.0;

fn main() {
    divan::main();
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn energy_stepwise(bencher: Bencher<'_, '_>) {
    fit(bencher, &Plan::default());
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn product_stepwise(bencher: Bencher<'_, '_>) {
    fit(bencher, &Plan::product());
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn product_one_shot(bencher: Bencher<'_, '_>) {
    fit(bencher, &Plan::sindy());
}

fn fit(bencher: Bencher<'_, '_>, plan: &Plan) {
    let log = log();
    bencher.bench(|| {
        reconstruct(&log, plan, torquewise_identify::UNWATCHED).expect("a log that can be fitted")
    });
}

/// Positioning moves of the reference arm with the noise of case 3.
fn log() -> Motion {
    let arm = Arm::builtin("puma560-3").expect("a built-in arm");
    let seconds = ROWS as f64 / RATE;
    let plan = MotionPlan { kind: MotionKind::Moves, seconds, rate: RATE, seed: 1 };
    let clean = simulate(&arm, &plan).expect("a plan within bounds").motion;
    let noise = Noise::case(3).expect("cases 1 to 3");
    add_noise(&clean, &noise, 1).expect("a motion that moves")
}
