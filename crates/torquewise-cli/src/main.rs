//! The command line: one file per command, no logic beyond putting the library's parts together.

mod error;
mod table;
mod score_table;
mod interrupt;
mod outcome;
mod files;
mod moments_file;
mod progress;
mod signal_arguments;
mod conditioning;
mod selection;
mod arguments;
mod pattern_table;
mod call_costs;
mod commands;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    interrupt::listen();
    let line = commands::CommandLine::parse();
    outcome::report(line.command.run(), line.json)
}
