//! The command line: one file per command, no logic beyond putting the library's parts together.

mod error;
mod table;
mod score_table;
mod interrupt;
mod threads;
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
    match commands::CommandLine::try_parse() {
        Ok(line) => {
            threads::start();
            outcome::report(files::all_or_none(|| line.command.run()), line.json, line.strict)
        }
        Err(told) => outcome::told(&told),
    }
}
