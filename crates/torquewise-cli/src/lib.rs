//! The command line: one file per command, no logic beyond putting the library's parts together.
//!
//! [`run`] is the whole program, for `main` and for the console script of the Python package.

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
mod selection;
mod arguments;
mod pattern_table;
mod call_costs;
mod commands;

pub(crate) use error::{CliError, Result};
pub(crate) use files::{TABLES, check_files, read_model, staged, write_whole};
pub(crate) use outcome::{Outcome, object};
pub(crate) use progress::watch;
pub(crate) use table::Table;

use clap::Parser;
use std::ffi::OsString;

/// Runs the command that words name, the first of them being that of the program; returns the code
/// to exit with.
///
/// Ctrl-C ends the process from here on.
pub fn run(words: &[OsString]) -> u8 {
    match commands::CommandLine::try_parse_from(words) {
        Ok(line) => {
            interrupt::listen(matches!(line.command, commands::Command::Serve(_)));
            threads::start();
            let run = || line.command.run(words);
            outcome::report(files::all_or_none(run), line.json, line.strict)
        }
        Err(told) => outcome::told(&told),
    }
}
