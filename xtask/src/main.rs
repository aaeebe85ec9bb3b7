//! Command line → chore: `cargo xtask ci`, `tidy` or `map`.

mod code;
mod violation;
mod workspace;
mod tidy;
mod map;
mod ci;

use std::process::ExitCode;

const USAGE: &str = "\
usage: cargo xtask <chore>

  ci            everything a change must pass, the same for people and machines
  tidy          the rules of the house that no compiler checks
  map           write docs/MAP.md: every file with its first line
  map --check   fail if docs/MAP.md is stale";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let root = workspace::root();
    let done = match words.as_slice() {
        ["ci"] => ci::run(&root),
        ["tidy"] => tidy::run(&root),
        ["map"] => map::write(&root),
        ["map", "--check"] => map::check(&root),
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("xtask: {error:#}");
            ExitCode::FAILURE
        }
    }
}
