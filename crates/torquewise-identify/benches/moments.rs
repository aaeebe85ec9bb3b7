//! From rows to moments: how near the sums come to what the machine's own matrix product does.
//!
//! Peak and moments are measured in turn in one run, in floating-point operations per second of
//! processor time, all threads together, and the median of the rounds' shares is taken: the machine
//! may be shared. Argument: rows (default 40 000).

use cpu_time::ProcessTime;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use rayon::prelude::*;
use std::hint::black_box;
use torquewise_identify::LibraryKind;
use torquewise_identify::plan::Regression;
use torquewise_regression::moments::MomentPlan;
use torquewise_regression::row_sums::{Prepared, Route, RowAdder};
use torquewise_regression::samples::Samples;
use torquewise_stepwise::candidates::Candidates;

const BLOCK: usize = 1024;
const ROUNDS: usize = 9;
/// Side of the square matrices that tell the peak.
const SIDE: usize = 1024;

fn main() {
    let rows: usize = std::env::args().find_map(|word| word.parse().ok()).unwrap_or(40_000);
    let energy = LibraryKind::Energy { interaction: None };
    let libraries = [
        ("SINDy, n = 3", 3, LibraryKind::PRODUCT, Regression::OneShot),
        ("product, n = 3", 3, LibraryKind::PRODUCT, Regression::Stepwise),
        ("energy, n = 3", 3, energy, Regression::Stepwise),
        ("energy, n = 4", 4, energy, Regression::Stepwise),
    ];
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        println!("\n{threads} threads");
        println!(
            "{:16} {:>9} {:>11} {:>9} {:>9} {:>9} {:>6}",
            "library", "moments", "flop/row", "rows/s", "GF/s", "peak", "share"
        );
        for (name, n, library, regression) in libraries {
            let line = pool.install(|| share(n, library, regression, rows, threads));
            println!("{name:16} {line}");
        }
    }
}

fn share(
    n: usize,
    library: LibraryKind,
    regression: Regression,
    rows: usize,
    threads: usize,
) -> String {
    let design = Candidates::new(n, library, regression, Vec::new()).expect("a library").design;
    let plan = MomentPlan::new(&design);
    let flops = 2.0 * plan.size(n) as f64;
    let prepared = Prepared::new(&design, n, Route::Moments);
    // More rows of small libraries, lest a round be too short to be measured.
    let rows = rows * (400_000 / (2 * plan.size(n))).clamp(1, 5);
    let blocks: Vec<Samples> = (0..rows / BLOCK).map(|block| samples(n, block)).collect();
    let rows = BLOCK * blocks.len();
    let mut shares: Vec<[f64; 3]> = Vec::new();
    for _ in 0..ROUNDS {
        let before = dgemm(threads);
        let mut adder = RowAdder::new(&prepared);
        let copies = blocks.clone();
        let start = ProcessTime::now();
        for block in copies {
            adder.push(block).expect("a block that fits");
        }
        black_box(adder.finish().expect("sums within range"));
        let rate = rows as f64 / start.elapsed().as_secs_f64();
        let peak = f64::midpoint(before, dgemm(threads));
        shares.push([rate * flops / 1e9 / peak, rate, peak]);
    }
    shares.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let [share, rate, peak] = shares[ROUNDS / 2];
    format!(
        "{:>9} {flops:>11.0} {rate:>9.0} {:>9.1} {peak:>9.1} {:>5.0}%",
        plan.size(n),
        rate * flops / 1e9,
        100.0 * share
    )
}

/// Operations per nanosecond of processor time of a square product on each thread, all at once.
fn dgemm(threads: usize) -> f64 {
    let a = Mat::from_fn(SIDE, SIDE, |i, j| ((i * 7 + j * 3) % 11) as f64);
    let mut out: Vec<Mat<f64>> = vec![Mat::zeros(SIDE, SIDE); threads];
    let start = ProcessTime::now();
    out.par_iter_mut().for_each(|out| {
        matmul(out.as_mut(), Accum::Replace, a.as_ref(), a.as_ref(), 1.0, Par::Seq);
    });
    black_box(&out);
    threads as f64 * 2.0 * (SIDE as f64).powi(3) / start.elapsed().as_secs_f64() / 1e9
}

fn samples(n: usize, block: usize) -> Samples {
    let wave = |row: usize, j: usize| {
        (0.001 * (block * BLOCK + row) as f64 * (1.0 + 0.37 * j as f64) + j as f64).sin()
    };
    Samples {
        angles: Mat::from_fn(BLOCK, n, wave),
        variables: Mat::from_fn(BLOCK, 2 * n, |row, j| wave(row, j + n)),
        responses: Mat::from_fn(BLOCK, n, |row, j| wave(row, j + 3 * n)),
    }
}
