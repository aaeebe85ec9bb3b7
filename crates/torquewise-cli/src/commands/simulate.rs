//! From arm, motion, noise to log with known truth.

use crate::arguments::noise_levels;
use crate::files::{
    check_distinct, check_output, check_rows, read_arm, read_friction, read_twin, staged,
};
use crate::outcome::Outcome;
use crate::pattern_table::PatternTable;
use crate::progress::watch;
use anyhow::{Result, anyhow};
use clap::{Args, ValueEnum};
use faer::MatRef;
use serde_json::json;
use std::path::{Path, PathBuf};
use torquewise::dynamics::{MotionKind, MotionPlan, Noise, SimulatedLog, add_noise};
use torquewise::inspect::PatternRows;
use torquewise::logs::{Contents, LogWriter};
use torquewise::motion::{Pattern, Recording};
use torquewise::observe::Watched;
use torquewise::twin::TwinLog;

/// Move an arm and write a log whose truth is known
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Built-in arm (see `torquewise arms`), .urdf file, .toml file with a DH table, or a model
    /// file: the twin of the robot it was learned from, friction included
    arm: String,
    /// Log to write, .csv or .parquet
    #[arg(short, long, value_name = "LOG")]
    output: PathBuf,
    /// How the joints are moved
    #[arg(long, value_enum, default_value_t)]
    motion: Motions,
    /// Recorded time in seconds
    #[arg(long, value_name = "S", default_value_t = MotionPlan::default().seconds)]
    seconds: f64,
    /// Rows per second
    #[arg(long, value_name = "HZ", default_value_t = MotionPlan::default().rate)]
    rate: f64,
    /// Seed of motion and noise
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Noise of the paper: 1 none, 2 70/50/30 dB, 3 60/40/30 dB on q/dq/ddq
    #[arg(long, value_name = "1|2|3", default_value_t = 1)]
    #[arg(value_parser = clap::value_parser!(u8).range(1..=3))]
    case: u8,
    /// Signal-to-noise ratios of q, dq and ddq in dB; `inf` for no noise
    #[arg(long, value_name = "Q,DQ,DDQ", conflicts_with = "case", allow_hyphen_values = true)]
    #[arg(value_parser = noise_levels)]
    noise_db: Option<Noise>,
    /// Friction of the joints, .toml: [JOINT] with coulomb, stiction, speed, viscous, [backward]
    #[arg(long, value_name = "FILE")]
    friction: Option<PathBuf>,
    /// Joints of a .urdf to hold at 0, their mass kept
    #[arg(long, value_name = "JOINT", value_delimiter = ',')]
    lock: Vec<String>,
    /// Table to write with the number and the true pattern of each row, .csv or .parquet
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
}

/// How the joints are moved.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(crate) enum Motions {
    /// Positioning and sorting: dwell, accelerate, cruise, brake, dwell
    #[default]
    Moves,
    /// Smooth sums of sines
    Sines,
    /// Poses held, then constant speeds, then constant accelerations
    Staged,
}

impl Motions {
    fn kind(self) -> MotionKind {
        match self {
            Self::Moves => MotionKind::Moves,
            Self::Sines => MotionKind::Sines,
            Self::Staged => MotionKind::Staged,
        }
    }
}

/// Simulates and writes.
pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let mut inputs = vec![PathBuf::from(&arguments.arm)];
    inputs.extend(arguments.friction.clone());
    for file in std::iter::once(&arguments.output).chain(&arguments.truth) {
        check_output(file, &inputs)?;
    }
    check_distinct(std::iter::once(&arguments.output).chain(&arguments.truth))?;
    let arm = read_arm(&arguments.arm, &arguments.lock)?;
    let twin = read_twin(&arguments.arm, arguments.friction.as_deref())?;
    let Arguments { seconds, rate, seed, .. } = *arguments;
    let plan = MotionPlan { kind: arguments.motion.kind(), seconds, rate, seed };
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
    match noise {
        // The level of the noise is relative to the whole log, which therefore has to be held.
        Some(noise) => {
            let whole = match &twin {
                Some(twin) => twin.whole()?,
                None => clean.whole()?.motion,
            };
            write_log(&arguments.output, &add_noise(&whole, &noise, seed)?)?;
        }
        None => match &twin {
            Some(twin) => write_log(&arguments.output, twin)?,
            None => write_log(&arguments.output, &clean)?,
        },
    }
    let patterns = write_truth(arguments.truth.as_deref(), &clean)?;
    Ok(outcome(arguments, arm.joints(), clean.n_rows(), patterns))
}

/// Rows whose noise is known from all of them at most: 200 bytes each for three joints.
const MOST_NOISY_ROWS: f64 = 2e7;

fn write_log(file: &Path, recording: &dyn Recording) -> Result<()> {
    let mut writer = LogWriter::create(&staged(file)?, recording.joints(), Contents::default())?;
    let shown = watch();
    let write = Watched::new(recording, &shown, "writing", (None, 1));
    write.read(&mut |_, block| Ok(writer.append(block)?)).map_err(|error| anyhow!(error))?;
    Ok(writer.finish()?)
}

/// Counts the rows of each pattern, and writes row by row which it is.
fn write_truth(file: Option<&Path>, clean: &SimulatedLog) -> Result<[u64; 3]> {
    let mut table = PatternTable::create(file)?;
    let row_of =
        |signal: MatRef<'_, f64>, row| -> Vec<f64> { signal.row(row).iter().copied().collect() };
    clean
        .read(&mut |_, block| {
            let rows = 0..block.n_rows();
            let truth: Vec<Pattern> = rows
                .map(|row| Pattern::of(&row_of(block.dq(), row), &row_of(block.ddq(), row)))
                .collect();
            Ok(table.append(&truth)?)
        })
        .map_err(|error| anyhow!(error))?;
    Ok(table.finish()?)
}

fn outcome(arguments: &Arguments, joints: &[String], rows: usize, counts: [u64; 3]) -> Outcome {
    let file = arguments.output.display();
    let json = json!({
        "arm": arguments.arm,
        "joints": joints,
        "rows": rows,
        "seconds": arguments.seconds,
        "rate_hz": arguments.rate,
        "seed": arguments.seed,
        "patterns": PatternRows::of(counts),
        "file": file.to_string(),
        "truth": arguments.truth.as_ref().map(|truth| truth.display().to_string()),
    });
    let truth = arguments.truth.iter().map(|truth| format!("truth: {}\n", truth.display()));
    let text = format!("log: {file} ({rows} rows, {} joints)\n", joints.len())
        + &truth.collect::<String>();
    Outcome { notes: Vec::new(), text, json, warnings: Vec::new() }
}
