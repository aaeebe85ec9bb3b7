//! From rows to normal equations of the whole library: from moments (E3), beside
//! evaluate-then-SYRK.

use divan::Bencher;
use torquewise_identify::LibraryKind;
use torquewise_identify::plan::Regression;
use torquewise_motion::Motion;
use torquewise_regression::normal_equations::NormalEquations;
use torquewise_regression::row_sums::{Prepared, Route, RowAdder};
use torquewise_regression::samples::Samples;
use torquewise_sim::{Arm, MotionKind, MotionPlan, Noise, add_noise, simulate};
use torquewise_stepwise::candidates::Candidates;

const ROWS: usize = 60_000;
const RATE: f64 = 250.0;
const N_RESPONSES: usize = 3;

fn main() {
    divan::main();
}

/// The normal equations of 3 612 candidates from moments: one pass, then gathering.
#[divan::bench(sample_count = 10, sample_size = 1, args = [1024])]
fn by_moments(bencher: Bencher<'_, '_>, block_rows: usize) {
    let (prepared, blocks) = (library(Route::Moments), log_blocks(block_rows));
    bencher.bench(|| sum(&prepared, &blocks));
}

/// The same normal equations from the evaluated library: one sum and one block at a time per core,
/// each symmetric product sequential, which is how faer is fastest on tall matrices.
#[divan::bench(sample_count = 2, sample_size = 1, args = [1024, 2048])]
fn by_rows(bencher: Bencher<'_, '_>, block_rows: usize) {
    let (prepared, blocks) = (library(Route::Direct), log_blocks(block_rows));
    bencher.bench(|| sum(&prepared, &blocks));
}

fn sum(prepared: &Prepared, blocks: &[Samples]) -> Vec<NormalEquations> {
    let mut adder = RowAdder::new(prepared);
    for block in blocks {
        adder.push(block.clone()).expect("blocks of the library's shape");
    }
    let columns: Vec<usize> = (0..3_612).collect();
    adder.finish().expect("sums within range").grams(prepared, &columns)
}

/// The one-shot SINDy library of three joints, N₁ = 4, N₂ ≤ 2.
fn library(route: Route) -> Prepared {
    let candidates = Candidates::new(3, LibraryKind::PRODUCT, Regression::OneShot, Vec::new())
        .expect("a library that fits into memory");
    assert_eq!(candidates.len(), 3_612);
    Prepared::new(&candidates.design, N_RESPONSES, route)
}

/// Positioning moves of the reference arm with the noise of case 3.
fn log_blocks(block_rows: usize) -> Vec<Samples> {
    let arm = Arm::builtin("puma560-3").expect("a built-in arm");
    let seconds = ROWS as f64 / RATE;
    let plan = MotionPlan { kind: MotionKind::Moves, seconds, rate: RATE, seed: 1 };
    let clean = simulate(&arm, &plan).expect("a plan within bounds").motion;
    let noise = Noise::case(3).expect("cases 1 to 3");
    let noisy = add_noise(&clean, &noise, 1).expect("a motion that moves");
    assert_eq!(noisy.n_rows(), ROWS);
    let rows: Vec<usize> = (0..ROWS).collect();
    rows.chunks(block_rows).map(|block| samples(&noisy.select(block))).collect()
}

fn samples(motion: &Motion) -> Samples {
    let n = motion.n_joints();
    let mut variables = faer::Mat::zeros(motion.n_rows(), 2 * n);
    variables.subcols_mut(0, n).copy_from(motion.dq());
    variables.subcols_mut(n, n).copy_from(motion.ddq());
    Samples {
        angles: motion.q().to_owned(),
        variables,
        responses: motion.require_tau().expect("a simulated torque").to_owned(),
    }
}
