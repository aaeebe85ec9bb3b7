//! Chores of the workspace: `cargo xtask ci` and `cargo xtask tidy`.

mod tidy;
mod python;
mod web;
mod ci;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

const USAGE: &str = "\
usage: cargo xtask <chore>

  ci     everything a change must pass, the same for people and machines
  python the suite of the Python package, on what `cargo build --workspace --lib` built
  package [--sources] crates, sources and wheel to publish, built and tried; or without the wheel
  web    the page of web/: its engine in WebAssembly, and the program that serves it, tried in a browser
  tidy   that ARCHITECTURE.md names what exists, how long files are, of how many crates programs";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done = match words.as_slice() {
        ["ci"] => ci::run(&root()),
        ["python"] => python::run(&root(), &ci::target(&root())).map(drop),
        ["package", flags @ ..] => python::package(&root(), flags),
        ["web"] => web::run(&root(), "release"),
        ["tidy"] => tidy::run(&root()),
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

/// The workspace this program was built from.
fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).to_path_buf()
}
