//! Rows in a folder → our side of the comparison with other programs: times, and what was found.
//!
//! Argument: a folder. Writes there the rows (`rows.f64`, columns q q̇ q̈ τ of three joints one
//! after the other); the peer builds the harmonics and monomials of the libraries. `ours.json`
//! holds the times, `ours_lstsq.f64` and `ours_lasso.f64` the weights. `benches/peers/run.py` runs
//! it.

use cpu_time::ProcessTime;
use faer::Mat;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;
use torquewise_dynamics::{Arm, MotionKind, MotionPlan, Noise, add_noise, simulate};
use torquewise_identify::candidates::{Candidates, Terms};
use torquewise_identify::{LibraryKind, Method};
use torquewise_motion::{BLOCK_ROWS, Motion};
use torquewise_sparse::accumulate::{Prepared, cheaper_route};
use torquewise_sparse::gram::Gram;
use torquewise_sparse::problem::Problem;
use torquewise_sparse::row_sums::RowAdder;
use torquewise_sparse::samples::Samples;
use torquewise_sparse::select::lasso::{Lasso, lasso_path};
use torquewise_sparse::select::stlsq::Stlsq;

const ROWS: usize = 20_000;
const N: usize = 3;
/// The joint that the LASSO explains.
const JOINT: usize = 1;

fn main() {
    let Some(folder) = std::env::args().skip(1).find(|word| !word.starts_with('-')) else {
        println!("name a folder to write to; benches/peers/run.py does");
        return;
    };
    let folder = PathBuf::from(folder);
    let motion = rows();
    let signals = [motion.q(), motion.dq(), motion.ddq(), motion.tau().expect("a torque")];
    let all = signals.iter().flat_map(|x| x.col_iter().flat_map(|c| c.iter().copied()));
    write(&folder.join("rows.f64"), all);

    let mut lines = vec![format!("\"rows\": {ROWS}, \"candidates\": {{")];
    let mut sizes = Vec::new();
    for order in 1..=4 {
        sizes.push(sindy(&motion, order, &folder));
    }
    lines.push(sizes.join(",\n"));
    lines.push("}".into());
    std::fs::write(folder.join("ours.json"), format!("{{{}}}\n", lines.join("\n")))
        .expect("a folder that can be written");
}

/// Times of the whole library at one order; the weights are written at the largest.
fn sindy(motion: &Motion, order: u8, folder: &Path) -> String {
    let library = LibraryKind::Product { gravity_order: 2, trig_order: order };
    let candidates = Candidates::new(N, library, Method::Sindy).expect("a library");
    let p = candidates.len();
    let route = cheaper_route(&candidates.design, N, ROWS);
    let columns: Vec<usize> = (0..p).collect();
    let mut out = format!("\"{p}\": {{\"route\": \"{route:?}\"");

    let (first, cross, energy) = timed(&mut out, "gram", || {
        let prepared = Prepared::new(&candidates.design, route);
        let mut adder = RowAdder::new(&prepared, N);
        for block in blocks(motion) {
            adder.push(block).expect("a block that fits");
        }
        let sums = adder.finish().expect("sums within range");
        problem(sums.grams(&prepared, N, &columns).remove(0), 0)
    });
    let weights = timed(&mut out, "lstsq", || {
        first.refit_each(&columns, cross.as_ref()).expect("columns of the library")
    });
    // With the ridge that PySINDy has by default, and without.
    for (name, plain_ridge) in [("stlsq", 0.05), ("stlsq_without_ridge", 0.0)] {
        let active: usize = timed(&mut out, name, || {
            let stlsq = Stlsq { plain_ridge, ..Stlsq::default() };
            let selected = stlsq.select_each(&first, cross.as_ref());
            let selected = selected.expect("settings within range");
            selected.iter().map(|selection| selection.active.len()).sum()
        });
        write!(out, ", \"{name}_active\": {active}").expect("a text");
    }
    let lasso = Lasso { ratio: 1e-3, gap_tolerance: 1e-5, max_sweeps: 100_000, ..Lasso::default() };
    let other = Gram { gram: first.gram().to_owned(), cross, energy, rows: ROWS };
    let (second, _, energy) = problem(other, JOINT);
    let path =
        timed(&mut out, "lasso", || lasso_path(&second, &lasso).expect("settings within range"));
    let gap = path.iter().map(|point| point.gap).fold(0.0, f64::max);
    let energy = energy[JOINT] / ROWS as f64;
    write!(out, ", \"gap\": {:e}}}", gap / energy).expect("a text");
    if order == 4 {
        let flat = |w: &Mat<f64>| {
            w.col_iter().flat_map(|c| c.iter().copied().collect::<Vec<_>>()).collect::<Vec<f64>>()
        };
        write(&folder.join("ours_lstsq.f64"), flat(&weights).into_iter());
        let lambdas = path.iter().map(|point| point.lambda);
        write(&folder.join("lambdas.f64"), lambdas);
        let points = path.iter().flat_map(|point| point.coefficients.iter().copied());
        write(&folder.join("ours_lasso.f64"), points);
        names(&candidates, folder);
    }
    out
}

/// One line for each candidate: its factors as the peer is to build them.
fn names(candidates: &Candidates, folder: &Path) {
    let Terms::Torque(terms) = &candidates.terms else { return };
    let lines: Vec<String> = terms.iter().map(|term| format!("{term:?}")).collect();
    std::fs::write(folder.join("terms.txt"), lines.join("\n")).expect("a folder");
}

/// The normal equations of a joint, and the cross products and energies of all.
fn problem(gram: Gram, joint: usize) -> (Problem, Mat<f64>, Vec<f64>) {
    let Gram { gram, cross, energy, rows } = gram;
    let own = cross.col_as_slice(joint).to_vec();
    let problem = Problem::new(gram, own, energy[joint], rows as f64).expect("finite sums");
    (problem, cross, energy)
}

/// Adds the seconds of some work to `out`, by the clock and of all processors.
fn timed<T>(out: &mut String, name: &str, work: impl FnOnce() -> T) -> T {
    let (clock, processors) = (Instant::now(), ProcessTime::now());
    let done = work();
    let (wall, cpu) = (clock.elapsed().as_secs_f64(), processors.elapsed().as_secs_f64());
    eprintln!("{name}: {wall:.2} s, {cpu:.2} s of processor time");
    write!(out, ", \"{name}\": [{wall:.4}, {cpu:.4}]").expect("a text");
    done
}

fn write(file: &Path, values: impl Iterator<Item = f64>) {
    let bytes: Vec<u8> = values.flat_map(f64::to_le_bytes).collect();
    std::fs::write(file, bytes).expect("a folder that can be written");
}

/// Positioning moves of the reference arm with the noise of case 3.
fn rows() -> Motion {
    let arm = Arm::builtin("puma560-3").expect("a built-in arm");
    let seconds = ROWS as f64 / 100.0;
    let plan = MotionPlan { kind: MotionKind::Moves, seconds, rate: 100.0, seed: 1 };
    let clean = simulate(&arm, &plan).expect("a plan within bounds").motion;
    add_noise(&clean, &Noise::case(3).expect("cases 1 to 3"), 1).expect("a motion that moves")
}

fn blocks(motion: &Motion) -> Vec<Samples> {
    let all: Vec<usize> = (0..motion.n_rows()).collect();
    let block = |rows: &[usize]| {
        let motion = motion.select(rows);
        let mut variables = Mat::zeros(motion.n_rows(), 2 * N);
        variables.subcols_mut(0, N).copy_from(motion.dq());
        variables.subcols_mut(N, N).copy_from(motion.ddq());
        let responses = motion.require_tau().expect("a simulated torque").to_owned();
        Samples { angles: motion.q().to_owned(), variables, responses }
    };
    all.chunks(BLOCK_ROWS).map(block).collect()
}
