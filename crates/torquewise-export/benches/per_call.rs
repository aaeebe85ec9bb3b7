//! Nanoseconds per call: exported C, the model interpreted, Pinocchio's RNEA, in one run.
//!
//! ```sh
//! cargo bench -p torquewise-export --bench per_call -- puma.json ur5.json=ur5.urdf
//! ```
//!
//! A model is timed beside the URDF behind its `=`, else beside as many revolute joints. For
//! Pinocchio, `PINOCCHIO_FLAGS` holds what the C++ compiler needs to find it, with `P` the folder
//! `site-packages/cmeel.prefix` of `pip install pin cmeel-eigen cmeel-urdfdom-headers`:
//! `-I$P/include -I$P/include/urdfdom -I$P/include/eigen3 -I$P/include/urdfdom_headers -L$P/lib
//! -lpinocchio_parsers -lpinocchio_default -Wl,-rpath,$P/lib`. Processor time, medians of 201 rounds, the least in brackets.

#![expect(clippy::unwrap_used, reason = "a bench may panic")]

use cpu_time::ProcessTime;
use std::fs;
use std::hint::black_box;
use std::path::Path;
use std::process::Command;
use torquewise_export::{Precision, Program, Quantity, to_c};
use torquewise_model::{Model, Torque, from_json};

const ROUNDS: usize = 201;

fn main() {
    let arguments: Vec<String> =
        std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    if arguments.is_empty() {
        println!("usage: cargo bench -p torquewise-export --bench per_call -- MODEL[=URDF]...");
    }
    let folder = tempfile::tempdir().unwrap();
    let pinocchio = pinocchio(folder.path());
    for argument in &arguments {
        let (file, arm) = argument.split_once('=').unwrap_or((argument, ""));
        let model = from_json(&fs::read_to_string(file).unwrap()).unwrap();
        let program = Program::of(&model).unwrap();
        let (n, count) = (model.n_joints(), model.n_coefficients());
        let cost = program.cost(Quantity::Torque);
        println!("\n{file}: {n} joints, {count} coefficients, torque {cost}");
        let (functions, states) = exported(&program, folder.path());
        println!("  differs from the model by {:.0e} of the torque", difference(&model, &states));
        for (name, median, least) in functions {
            println!("  {name:12}{median:8.0} ns  ({least:.0})");
        }
        let (median, least) = interpreted(&model);
        println!("  {:12}{median:8.0} ns  ({least:.0})", "interpreted");
        if pinocchio {
            let arm = if arm.is_empty() { n.to_string() } else { arm.to_owned() };
            let text = run(Command::new(folder.path().join("pinocchio")).arg(arm));
            let numbers: Vec<f64> =
                text.split_whitespace().map(|number| number.parse().unwrap()).collect();
            println!("  {:12}{:8.0} ns  ({:.0})", "RNEA", numbers[1], numbers[2]);
        }
    }
}

/// Name, median and least time of a function.
type Timed = (String, f64, f64);

/// Times of each function of the exported C, and its torque at some states: q, q̇, q̈, τ of each
/// joint.
fn exported(program: &Program, folder: &Path) -> (Vec<Timed>, Vec<Vec<[f64; 4]>>) {
    let code = to_c(program, "arm", Precision::Double).unwrap();
    fs::write(folder.join("arm.c"), code).unwrap();
    fs::write(folder.join("timing.c"), include_str!("timing.c")).unwrap();
    let mut compiler = Command::new("cc");
    compiler.args(["-std=c99", "-O2", "timing.c", "arm.c", "-o", "timing", "-lm"]);
    run(compiler.current_dir(folder));
    let text = run(&mut Command::new(folder.join("timing")));
    let (states, times): (Vec<&str>, Vec<&str>) =
        text.lines().partition(|line| line.starts_with("state"));
    let numbers = |line: &str| -> Vec<f64> {
        line.split_whitespace().skip(1).map(|word| word.parse().unwrap()).collect()
    };
    let time = |line: &&str| {
        let (name, times) = (line.split_whitespace().next().unwrap(), numbers(line));
        (name.to_owned(), times[0], times[1])
    };
    let state = |line: &&str| numbers(line).as_chunks::<4>().0.to_vec();
    (times.iter().map(time).collect(), states.iter().map(state).collect())
}

/// Largest difference of a torque from the model's, beside its root mean square at least.
fn difference(model: &Model, states: &[Vec<[f64; 4]>]) -> f64 {
    let torque = Torque::new(model);
    let signal = |state: &[[f64; 4]], place: usize| -> Vec<f64> {
        state.iter().map(|joint| joint[place]).collect()
    };
    let expected: Vec<Vec<f64>> = states
        .iter()
        .map(|state| {
            let [q, dq, ddq] = [0, 1, 2].map(|place| signal(state, place));
            torque.at(&q, &dq, &ddq).unwrap()
        })
        .collect();
    let mut worst: f64 = 0.0;
    for joint in 0..model.n_joints() {
        let squares: f64 = expected.iter().map(|tau| tau[joint].powi(2)).sum();
        let usual = (squares / states.len() as f64).sqrt();
        for (state, tau) in states.iter().zip(&expected) {
            let error = (state[joint][3] - tau[joint]).abs();
            worst = worst.max(error / tau[joint].abs().max(usual));
        }
    }
    worst
}

/// Median and least time of the torque by walking through the terms.
fn interpreted(model: &Model) -> (f64, f64) {
    let (n, torque) = (model.n_joints(), Torque::new(model));
    let signal =
        |seed: f64| -> Vec<f64> { (0..n).map(|j| (seed + 0.7 * j as f64).sin()).collect() };
    let states: Vec<[Vec<f64>; 3]> =
        (0..64).map(|k| [0.1, 0.2, 0.3].map(|shift| signal(f64::from(k) + shift))).collect();
    let mut times: Vec<f64> = (0..ROUNDS)
        .map(|_| {
            let start = ProcessTime::now();
            for [q, dq, ddq] in &states {
                black_box(torque.at(q, dq, ddq).unwrap());
            }
            start.elapsed().as_secs_f64() * 1e9 / states.len() as f64
        })
        .collect();
    times.sort_by(f64::total_cmp);
    (times[ROUNDS / 2], times[0])
}

/// Whether Pinocchio was asked for; then its program is in the folder.
fn pinocchio(folder: &Path) -> bool {
    let Ok(flags) = std::env::var("PINOCCHIO_FLAGS") else { return false };
    fs::write(folder.join("pinocchio.cpp"), include_str!("pinocchio.cpp")).unwrap();
    let mut compiler = Command::new("c++");
    compiler.current_dir(folder).args(["-std=c++17", "-O3", "-DNDEBUG", "-w", "pinocchio.cpp"]);
    run(compiler.args(flags.split_whitespace()).args(["-o", "pinocchio"]));
    true
}

fn run(command: &mut Command) -> String {
    let output = command.output().unwrap();
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {complaint}");
    String::from_utf8(output.stdout).unwrap()
}
