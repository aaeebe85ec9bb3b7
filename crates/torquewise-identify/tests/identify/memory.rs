//! A log ten times as long is reconstructed in the same memory.
#![cfg(target_os = "linux")]

use crate::support::{fit, reference_arm};
use std::process::Command;
use torquewise_identify::Plan;
use torquewise_sim::{MotionKind, MotionPlan, SimulatedLog};

/// Set for the process that reconstructs; the number of rows.
const ROWS: &str = "TORQUEWISE_MEMORY_ROWS";
const PEAK: &str = "peak resident kilobytes: ";

#[test]
fn ten_times_the_rows_take_the_same_memory() {
    if let Ok(rows) = std::env::var(ROWS) {
        reconstruct_simulated(rows.parse().unwrap());
        return println!("\n{PEAK}{}", peak_kilobytes());
    }

    // What the allocator keeps differs by megabytes from run to run: the least is what it takes.
    let least = |rows| peak_of(rows).min(peak_of(rows));
    let (short, long) = (least(60_000), least(600_000));

    // Holding all rows would take 60 megabytes more, several times what the short log takes.
    println!("{short} kB for 60 000 rows, {long} kB for 600 000");
    assert!(long < 1.3 * short, "{short} kB grew to {long} kB");
}

/// Runs this test in a process of its own, which only reconstructs.
fn peak_of(rows: usize) -> f64 {
    let output = Command::new(std::env::current_exe().expect("this test is a file"))
        .args(["--exact", "memory::ten_times_the_rows_take_the_same_memory", "--nocapture"])
        .env(ROWS, rows.to_string())
        .output()
        .expect("this test starts again");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    let peak = text.lines().find_map(|line| line.strip_prefix(PEAK));
    peak.and_then(|peak| peak.parse().ok()).unwrap_or_else(|| panic!("no peak in: {text}"))
}

/// A log that is made anew each time it is read, so that all memory is that of the method.
fn reconstruct_simulated(rows: usize) {
    let seconds = rows as f64 / 100.0;
    let plan = MotionPlan { kind: MotionKind::Moves, seconds, rate: 100.0, seed: 1 };
    let log = SimulatedLog::new(&reference_arm(), &plan).expect("a plan within bounds");
    assert_eq!(log.n_rows(), rows);

    let found = fit(&log, &Plan::default());

    assert_eq!(found.survey.rows, rows);
}

fn peak_kilobytes() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux tells");
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let number = line.and_then(|line| line.split_whitespace().next());
    number.and_then(|number| number.parse().ok()).expect("VmHWM in kilobytes")
}
