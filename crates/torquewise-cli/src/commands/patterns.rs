//! `patterns`: clusters of rows, and the pattern of each row.

use crate::arguments::PatternArguments;
use crate::pattern_table::{PatternTable, counts_text};
use crate::signal_arguments::FilterArguments;
use crate::{Outcome, Result, TABLES, check_files, watch};
use clap::Args;
use serde_json::json;
use std::path::PathBuf;
use torquewise::Rows;
use torquewise::identify::{Patterns, find_patterns, survey};
use torquewise::inspect::{missing_patterns, pattern_rows};
use torquewise::model::number;
use torquewise::motion::Recording;

/// Tell standstill, uniform and variable velocity apart
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Logs of one arm
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Table to write with the number and the pattern of each row, .csv or .parquet
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    patterns: PatternArguments,
    #[command(flatten)]
    filter: FilterArguments,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    check_files(&arguments.logs, arguments.output.iter().map(|file| (file.as_path(), TABLES)))?;
    let log = arguments.filter.signals.open(&arguments.logs)?;
    let logs = arguments.filter.prepare(&log, Rows::Every)?;
    let found = {
        let shown = watch();
        let watched = logs.watched(&shown, "looking through the log");
        find_patterns(&survey(&watched)?, &arguments.patterns.plan()?)?
    };
    // All rows, beyond the sample that was clustered.
    let mut table = PatternTable::create(arguments.output.as_deref())?;
    logs.watched(&watch(), "labelling rows")
        .read(&mut |_, block| Ok(table.append(&found.label(block))?))?;
    Ok(outcome(arguments, &found, table.finish()?))
}

fn outcome(arguments: &Arguments, found: &Patterns, counts: [u64; 3]) -> Outcome {
    let inertia: Vec<String> = found.inertia.iter().map(|&inertia| number(inertia)).collect();
    let file = arguments.output.as_ref().map(|file| file.display().to_string());
    let written = file.iter().map(|file| format!("rows and their patterns: {file}\n"));
    let text = format!(
        "{}\n{} clusters; inertia of 1, 2, … clusters: {}\n{}",
        counts_text(counts),
        found.n_clusters(),
        inertia.join("  "),
        written.collect::<String>(),
    );
    let json = json!({
        "clusters": found.n_clusters(),
        "inertia": found.inertia,
        "patterns": pattern_rows(counts),
        "file": file,
    });
    Outcome {
        text,
        json,
        warnings: missing_patterns(&found.present).into_iter().collect(),
        ..Outcome::default()
    }
}
