//! The command line: one file per command, no logic beyond putting the library's parts together.

mod error;
mod table;
mod score_table;
mod outcome;
mod files;
mod compiler;
mod progress;
mod recorded;
mod timed;
mod arguments;
mod pattern_table;
mod training_range;
mod physics;
mod commands;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    let line = commands::CommandLine::parse();
    outcome::report(line.command.run(), line.json)
}
