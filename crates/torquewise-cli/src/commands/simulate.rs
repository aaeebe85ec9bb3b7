//! `simulate`: a log with known truth, of an arm, a motion and noise.

use crate::arguments::{Word, choice, noise_levels};
use crate::files::{check_rows, read_arm, read_friction};
use crate::pattern_table::PatternTable;
use crate::{Outcome, Result, TABLES, Table, check_files, staged, watch};
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};
use torquewise::Watched;
use torquewise::dynamics::{MotionKind, MotionPlan, Noise, SimulatedLog, add_noise, arms};
use torquewise::inspect::pattern_rows;
use torquewise::logs::TableWriter;
use torquewise::motion::{Pattern, Recording};
use torquewise::twin::TwinLog;

/// Move an arm and write a log whose truth is known
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Built-in arm (see --list), .urdf file, .toml file with a DH table, or a model file: the twin
    /// of the robot it was learned from, friction included
    #[arg(required_unless_present = "list")]
    arm: Option<String>,
    /// List the built-in arms
    #[arg(long, conflicts_with_all = ["arm", "output"])]
    list: bool,
    /// Log to write, .csv or .parquet
    #[arg(short, long, value_name = "LOG", required_unless_present = "list")]
    output: Option<PathBuf>,
    /// How the joints are moved
    #[arg(help_heading = "Motion", long, value_parser = choice(&MOTIONS), default_value = "moves")]
    motion: MotionKind,
    /// Recorded time in seconds
    #[arg(help_heading = "Motion", long, value_name = "S", default_value_t = MotionPlan::default().seconds)]
    seconds: f64,
    /// Rows per second
    #[arg(help_heading = "Motion", long, value_name = "HZ", default_value_t = MotionPlan::default().rate)]
    rate: f64,
    /// Seed of motion and noise
    #[arg(help_heading = "Motion", long, default_value_t = 0)]
    seed: u64,
    /// Noise level: 1 none, 2 70/50/30 dB, 3 60/40/30 dB on q/dq/ddq
    #[arg(help_heading = "Noise and friction", long, value_name = "1|2|3", default_value_t = 1)]
    #[arg(value_parser = clap::value_parser!(u8).range(1..=3))]
    case: u8,
    /// Signal-to-noise ratios of q, dq and ddq in dB; `inf` for no noise
    #[arg(help_heading = "Noise and friction", long, value_name = "Q,DQ,DDQ")]
    #[arg(conflicts_with = "case", allow_hyphen_values = true, value_parser = noise_levels)]
    noise_db: Option<Noise>,
    /// Friction of the joints, .toml: [JOINT] with coulomb, stiction, speed, viscous, [backward]
    #[arg(help_heading = "Noise and friction", long, value_name = "FILE")]
    friction: Option<PathBuf>,
    /// Joints of a .urdf to hold at 0, their mass kept
    #[arg(long, value_name = "JOINT", value_delimiter = ',')]
    lock: Vec<String>,
    /// Table to write with the number and the true pattern of each row, .csv or .parquet
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
}

const MOTIONS: [Word<MotionKind>; 3] = [
    (
        "moves",
        "Positioning and sorting: dwell, accelerate, cruise, brake, dwell",
        MotionKind::Moves,
    ),
    ("sines", "Smooth sums of sines", MotionKind::Sines),
    ("staged", "Poses held, then constant speeds, then constant accelerations", MotionKind::Staged),
];

pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let (Some(name), Some(output)) = (&arguments.arm, &arguments.output) else {
        return Ok(list());
    };
    let mut inputs = vec![PathBuf::from(name)];
    inputs.extend(arguments.friction.clone());
    let outputs = std::iter::once(output).chain(&arguments.truth);
    check_files(&inputs, outputs.map(|file| (file.as_path(), TABLES)))?;
    let (arm, twin) = read_arm(name, &arguments.lock, arguments.friction.as_deref())?;
    let Arguments { seconds, rate, seed, .. } = *arguments;
    let plan = MotionPlan { kind: arguments.motion, seconds, rate, seed };
    let friction = read_friction(arguments.friction.as_deref(), &arm)?;
    let clean = SimulatedLog::new(&arm, &plan)?.with_friction(friction)?;
    let noise = match (arguments.noise_db, arguments.case) {
        (None, 1) => None,
        (None, case) => Some(Noise::case(case)?),
        (noise, _) => noise,
    };
    if noise.is_some() {
        check_rows(seconds, rate, MOST_NOISY_ROWS)?;
    }
    let twin = twin.map(|model| TwinLog::new(&model, &plan)).transpose()?;
    let recording: &dyn Recording = match &twin {
        Some(twin) => twin,
        None => &clean,
    };
    match noise {
        // The level of the noise is relative to the whole log, which therefore has to be held.
        Some(noise) => {
            let whole = match &twin {
                Some(twin) => twin.trajectories()?.remove(0),
                None => clean.whole()?.motion,
            };
            write_log(output, &add_noise(&whole, &noise, seed)?)?;
        }
        None => write_log(output, recording)?,
    }
    let (file, rows, joints) = (output.display(), clean.n_rows(), arm.joints());
    let json = json!({
        "arm": name,
        "joints": joints,
        "rows": rows,
        "seconds": seconds,
        "rate_hz": rate,
        "seed": seed,
        "patterns": pattern_rows(write_truth(arguments.truth.as_deref(), &clean)?),
        "file": file.to_string(),
        "truth": arguments.truth.as_ref().map(|truth| truth.display().to_string()),
    });
    let mut text = format!("log: {file} ({rows} rows, {} joints)\n", joints.len());
    text.extend(arguments.truth.iter().map(|truth| format!("truth: {}\n", truth.display())));
    Ok(Outcome { text, json, ..Outcome::default() })
}

/// Rows whose noise is known from all of them at most: 200 bytes each for three joints.
const MOST_NOISY_ROWS: f64 = 2e7;

fn write_log(file: &Path, recording: &dyn Recording) -> Result<()> {
    let mut writer = TableWriter::log(&staged(file)?, recording.joints(), true)?;
    let shown = watch();
    let write = Watched::new(recording, &shown, "writing", None);
    write.read(&mut |_, block| Ok(writer.append_motion(block)?))?;
    Ok(writer.finish()?)
}

/// Counts the rows of each pattern, and writes row by row which it is.
fn write_truth(file: Option<&Path>, clean: &SimulatedLog) -> Result<[u64; 3]> {
    let mut table = PatternTable::create(file)?;
    clean.read(&mut |_, block| {
        let states = (0..block.n_rows()).map(|row| block.state(row));
        let truth: Vec<Pattern> = states.map(|[_, dq, ddq]| Pattern::of(&dq, &ddq)).collect();
        Ok(table.append(&truth)?)
    })?;
    Ok(table.finish()?)
}

fn list() -> Outcome {
    let mut text = String::new();
    let mut table = Table::new(["arm", "joints"]);
    for arm in arms() {
        table.row(arm.name, [arm.joints.to_string()]);
    }
    let descriptions = std::iter::once("").chain(arms().into_iter().map(|arm| arm.description));
    for (line, description) in table.text().lines().zip(descriptions) {
        text.push_str(format!("{line}  {description}").trim_end());
        text.push('\n');
    }
    let json = json!({ "arms": arms() });
    Outcome { text, json, ..Outcome::default() }
}
