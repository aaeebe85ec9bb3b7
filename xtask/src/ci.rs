//! Everything a change must pass, cheapest first.

use crate::{python, tidy};
use anyhow::{Context, Result, bail};
use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Crates that the library without its default features may be made of.
const MOST_LEAN_CRATES: usize = 99;

/// How long mutated files are tried, by all readers together.
const FUZZ_SECONDS: u32 = 60;

/// Runs every check and stops at the first that fails.
///
/// # Errors
/// The step that failed.
pub(crate) fn run(root: &Path) -> Result<()> {
    cargo(root, "fmt --all -- --check")?;
    announce("xtask tidy");
    tidy::run(root)?;
    supply_chain(root)?;
    announce("crates of the lean library");
    lean_crates(root)?;
    cargo(root, "clippy --workspace --all-targets -- -D warnings")?;
    cargo(root, "clippy --package torquewise --no-default-features -- -D warnings")?;
    cargo(root, "doc --workspace --no-deps --lib")?;
    let has_nextest = command(root, "nextest --version")
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success());
    // A machine without nextest runs the same tests.
    cargo(
        root,
        if has_nextest {
            "nextest run --workspace"
        } else {
            "test --workspace --lib --bins --tests"
        },
    )?;
    cargo(root, "test --workspace --doc")?;
    // With the features of the workspace, so that nothing is compiled again.
    cargo(root, "build --workspace --lib --examples")?;
    let target = target(root);
    for example in examples(root)? {
        announce(&format!("example {example}"));
        run_example(root, &target.join("debug/examples").join(&example))?;
    }
    cargo(
        root,
        &format!("run --package torquewise-fuzz -- --cases 1000000 --seconds {FUZZ_SECONDS}"),
    )?;
    announce("python");
    python::run(root, &target)?;
    announce("all passed");
    Ok(())
}

/// The folder that cargo builds into.
pub(crate) fn target(root: &Path) -> PathBuf {
    env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from)
}

/// Runs an example that was built.
fn run_example(root: &Path, program: &Path) -> Result<()> {
    let status = Command::new(program).current_dir(root).stdin(Stdio::null()).status();
    let status = status.with_context(|| format!("cannot start {}", program.display()))?;
    if status.success() { Ok(()) } else { bail!("{} failed: see above", program.display()) }
}

/// Names of the examples of the front door, by number.
fn examples(root: &Path) -> Result<Vec<String>> {
    let folder = root.join("crates/torquewise/examples");
    let mut names = Vec::new();
    for entry in fs::read_dir(&folder).with_context(|| format!("no {}", folder.display()))? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        names.extend(name.strip_suffix(".rs").map(str::to_owned));
    }
    names.sort();
    Ok(names)
}

/// Licences, sources and versions of all crates, where `cargo deny` is installed; advisories where
/// their database can be had.
fn supply_chain(root: &Path) -> Result<()> {
    let runs = |line: &str| {
        let quiet = command(root, line).stdout(Stdio::null()).stderr(Stdio::null()).status();
        quiet.is_ok_and(|status| status.success())
    };
    announce("supply chain");
    if !runs("deny --version") {
        eprintln!("skipped: `cargo install cargo-deny` to check licences, sources and versions");
        return Ok(());
    }
    cargo(root, "deny --log-level error check licenses bans sources")?;
    if !runs("deny fetch db") {
        eprintln!("advisories are not checked: their database cannot be had");
        return Ok(());
    }
    cargo(root, "deny --log-level error check advisories")
}

/// Fails where the lean library is made of more crates than it may.
fn lean_crates(root: &Path) -> Result<()> {
    let line = "tree --package torquewise --no-default-features --edges normal --prefix none \
                --format {p}";
    let listed = command(root, line).output().context("cannot start cargo tree")?;
    let listed = String::from_utf8_lossy(&listed.stdout).into_owned();
    let mut crates: Vec<&str> =
        listed.lines().map(|line| line.split(" (").next().unwrap_or(line)).collect();
    crates.sort_unstable();
    crates.dedup();
    match crates.len() {
        0 => bail!("cargo tree lists nothing"),
        n if n > MOST_LEAN_CRATES => bail!("{n} crates, at most {MOST_LEAN_CRATES} are allowed"),
        n => eprintln!("{n}"),
    }
    Ok(())
}

fn announce(name: &str) {
    eprintln!("\n=== {name}");
}

/// Runs cargo with the words of a line.
fn cargo(root: &Path, line: &str) -> Result<()> {
    announce(&format!("cargo {line}"));
    let status = command(root, line).status();
    let status = status.with_context(|| format!("cannot start `cargo {line}`"))?;
    if status.success() { Ok(()) } else { bail!("`cargo {line}` failed: see above") }
}

/// The cargo that runs this program, without standard input.
fn command(root: &Path, line: &str) -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root).args(line.split_whitespace()).stdin(Stdio::null());
    command.env("RUSTDOCFLAGS", "-D warnings");
    command
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failing_step_is_named() {
        let error = cargo(Path::new("."), "no-such-chore").unwrap_err();

        assert_eq!(error.to_string(), "`cargo no-such-chore` failed: see above");
    }
}
