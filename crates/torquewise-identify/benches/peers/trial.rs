//! What all tasks share: motions, blocks of rows, files for the peers, times.

use cpu_time::ProcessTime;
use faer::Mat;
use rayon::prelude::*;
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;
use torquewise_model::JointKind;
use torquewise_motion::{BLOCK_ROWS, Motion};
use torquewise_regression::select::stlsq::Stlsq;
use torquewise_regression::{KeptColumns, NormalEquations, PreparedDesign, RowAdder, Samples};
use torquewise_sim::{Arm, MotionKind, MotionPlan, Noise, add_noise, simulate};
use torquewise_stepwise::Candidates;
use torquewise_stepwise::candidates::Terms;

/// Joints of the arm of all tasks.
pub(crate) const N: usize = 3;
pub(crate) const KINDS: [JointKind; N] = [JointKind::Revolute; N];
/// Samples per second of all logs \[Hz\].
const RATE: f64 = 100.0;

/// Positioning moves of the arm with the noise of case 3.
pub(crate) fn moves(rows: usize) -> Motion {
    let noise = Noise::case(3).expect("cases 1 to 3");
    let clean = simulated(MotionKind::Moves, rows, 1);
    add_noise(&clean, &noise, 1).expect("a motion that moves")
}

/// Sines of the same arm, without noise, to be judged by.
pub(crate) fn test() -> Motion {
    simulated(MotionKind::Sines, 2_000, 99)
}

fn simulated(kind: MotionKind, rows: usize, seed: u64) -> Motion {
    let arm = Arm::builtin("puma560-3").expect("a built-in arm");
    let plan = MotionPlan { kind, seconds: rows as f64 / RATE, rate: RATE, seed };
    simulate(&arm, &plan).expect("a plan within bounds").motion
}

/// Rows in blocks, as they are read from a file.
fn blocks(motion: &Motion) -> Vec<Samples> {
    let n = motion.n_joints();
    let all: Vec<usize> = (0..motion.n_rows()).collect();
    let block = |rows: &[usize]| {
        let motion = motion.select(rows);
        let mut variables = Mat::zeros(motion.n_rows(), 2 * n);
        variables.subcols_mut(0, n).copy_from(motion.dq());
        variables.subcols_mut(n, n).copy_from(motion.ddq());
        let responses = motion.require_tau().expect("a simulated torque").to_owned();
        Samples { angles: motion.q().to_owned(), variables, responses }
    };
    all.chunks(BLOCK_ROWS).map(block).collect()
}

/// The normal equations of a library, one for each of its equations, from the rows of a motion gone
/// through so many times.
pub(crate) fn grams(
    candidates: &Candidates,
    motion: &Motion,
    repeats: usize,
) -> Vec<NormalEquations> {
    let n = motion.n_joints();
    let prepared = PreparedDesign::cheaper(&candidates.design, n, repeats * motion.n_rows());
    let mut adder = RowAdder::new(&prepared);
    for _ in 0..repeats {
        for block in blocks(motion) {
            adder.push(block).expect("a block that fits");
        }
    }
    adder.finish().expect("sums within range").all_grams(&prepared)
}

/// The terms of each response.
pub(crate) fn select_each(stlsq: &Stlsq, problem: &NormalEquations) -> Vec<KeptColumns> {
    let all: Vec<usize> = (0..problem.n_columns()).collect();
    let own = |response| {
        let own = problem.left_by(&[], response, &all);
        stlsq.select(&own).expect("settings within range")
    };
    (0..problem.cross.ncols()).into_par_iter().map(own).collect()
}

/// Work that takes less than so many seconds is done [`AGAIN`] times: the median counts.
const SHORT: f64 = 0.5;
const AGAIN: usize = 5;

/// Some work, with its seconds by the clock and of all processors.
pub(crate) fn timed<T>(name: &str, work: impl Fn() -> T) -> (T, Value) {
    let once = || {
        let (clock, processors) = (Instant::now(), ProcessTime::now());
        let done = work();
        (done, [clock.elapsed().as_secs_f64(), processors.elapsed().as_secs_f64()])
    };
    let (mut done, first) = once();
    let mut runs = vec![first];
    while runs.len() < AGAIN && first[0] < SHORT {
        let (again, seconds) = once();
        done = again;
        runs.push(seconds);
    }
    runs.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let [wall, cpu] = runs[runs.len() / 2];
    eprintln!("  {name}: {wall:.3} s, {cpu:.3} s of processor time");
    (done, json!([wall, cpu]))
}

/// Columns q q̇ q̈ τ, one after the other.
pub(crate) fn write_motion(file: &Path, motion: &Motion) {
    let signals = [motion.q(), motion.dq(), motion.ddq(), motion.tau().expect("a torque")];
    write(file, signals.iter().flat_map(|x| x.col_iter().flat_map(|c| c.iter().copied())));
}

/// Numbers as they stand in memory, little-endian.
pub(crate) fn write(file: &Path, values: impl Iterator<Item = f64>) {
    let bytes: Vec<u8> = values.flat_map(f64::to_le_bytes).collect();
    std::fs::write(file, bytes).expect("a folder that can be written");
}

/// One line for each of some candidates: its factors as the peer is to build them.
pub(crate) fn write_terms(file: &Path, candidates: &Candidates, columns: &[usize]) {
    let Terms::Torque(terms) = &candidates.terms else { return };
    let lines: Vec<String> = columns.iter().map(|&column| format!("{:?}", terms[column])).collect();
    std::fs::write(file, lines.join("\n")).expect("a folder that can be written");
}
