//! The program `torquewise`.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(torquewise_cli::run(&std::env::args_os().collect::<Vec<_>>()))
}
