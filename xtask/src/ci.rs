//! Everything a change must pass, cheapest first.

use crate::{python, tidy, web};
use anyhow::{Context, Result, bail};
use std::env;
use std::env::consts::EXE_SUFFIX;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

/// Largest program that users get \[bytes\].
const LARGEST_PROGRAM: u64 = 20_000_000;

/// Runs every check and stops at the first that fails.
pub(crate) fn run(root: &Path) -> Result<()> {
    let (begun, tree) = (Instant::now(), changes(root));
    let step = |name: &str| eprintln!("\n=== {} s: {name}", begun.elapsed().as_secs());
    let cargo = |line: &str| {
        step(&format!("cargo {line}"));
        cargo(root, line)
    };
    cargo("fmt --all -- --check")?;
    step("tidy");
    tidy::run(root)?;
    if succeeds(root, "deny --version") {
        cargo("deny --log-level error check licenses bans sources")?;
        if succeeds(root, "deny fetch db") {
            cargo("deny --log-level error check advisories")?;
        } else {
            step("NOT CHECKED: advisories, as their database cannot be had");
        }
    } else {
        step("NOT CHECKED: licences, sources and advisories; `cargo install cargo-deny`");
    }
    cargo("clippy --workspace --all-targets -- -D warnings")?;
    cargo("clippy --package torquewise --no-default-features -- -D warnings")?;
    // With the examples come the features that clippy has checked all dependencies with.
    cargo("doc --workspace --no-deps --lib --examples")?;
    // A machine without nextest runs the same tests.
    cargo(if succeeds(root, "nextest --version") {
        "nextest run --workspace"
    } else {
        "test --workspace --lib --bins --tests"
    })?;
    cargo("test --workspace --doc")?;
    // With the features of the workspace, so that nothing is compiled again.
    cargo("build --workspace --lib --examples")?;
    let target = target(root);
    for example in examples(root)? {
        step(&format!("example {example}"));
        call(Command::new(target.join("debug/examples").join(&example)).current_dir(root))?;
    }
    step("python");
    if python::run(root, &target)? {
        step("what is published");
        python::package(root, &["--sources"])?;
    }
    cargo("build --release")?;
    step("the program that users get");
    run_release(&program(root, "release"), &target.join("demo"))?;
    step("web");
    // With the program of the tests: linking another for users takes minutes.
    web::run(root, "debug")?;
    step("clean work tree");
    if changes(root) != tree {
        bail!("files of the work tree changed: see `git status`");
    }
    step("all passed");
    Ok(())
}

/// The folder that cargo builds into.
pub(crate) fn target(root: &Path) -> PathBuf {
    env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from)
}

/// Builds the program with the page in this folder, in the folder of a profile.
pub(crate) fn build_with(root: &Path, page: &Path, profile: &str) -> Result<PathBuf> {
    let flags = if profile == "release" { "--release" } else { "--workspace --bin torquewise" };
    call(command(root, &format!("build {flags}")).env("TORQUEWISE_PAGE", page))?;
    Ok(program(root, profile))
}

fn program(root: &Path, profile: &str) -> PathBuf {
    target(root).join(profile).join(format!("torquewise{EXE_SUFFIX}"))
}

/// What git says of the work tree; nothing where it is none.
fn changes(root: &Path) -> Option<String> {
    let output = Command::new("git").current_dir(root).args(["status", "--porcelain"]).output();
    let output = output.ok().filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Fails where a program is too large, or cannot do what it is first asked for.
fn run_release(program: &Path, folder: &Path) -> Result<()> {
    let size = fs::metadata(program).with_context(|| format!("no {}", program.display()))?.len();
    eprintln!("{:.1} MB", size as f64 / 1e6);
    if size > LARGEST_PROGRAM {
        bail!("{} has {size} bytes, at most {LARGEST_PROGRAM} are allowed", program.display());
    }
    if folder.exists() {
        fs::remove_dir_all(folder)?;
    }
    fs::create_dir_all(folder)?;
    call(Command::new(program).arg("demo").current_dir(folder))
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

/// Runs cargo with the words of a line.
fn cargo(root: &Path, line: &str) -> Result<()> {
    call(&mut command(root, line)).with_context(|| format!("`cargo {line}` failed"))
}

fn succeeds(root: &Path, line: &str) -> bool {
    let quiet = command(root, line).stdout(Stdio::null()).stderr(Stdio::null()).status();
    quiet.is_ok_and(|status| status.success())
}

/// Runs a program without standard input.
pub(crate) fn call(command: &mut Command) -> Result<()> {
    let name = command.get_program().display().to_string();
    let status = command.stdin(Stdio::null()).status();
    let status = status.with_context(|| format!("cannot start {name}"))?;
    if status.success() { Ok(()) } else { bail!("{name} failed: see above") }
}

pub(crate) fn is_there(program: impl AsRef<OsStr>) -> bool {
    let mut command = Command::new(program);
    command.arg("--version").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}

/// The cargo that runs this program.
pub(crate) fn command(root: &Path, line: &str) -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root).args(line.split_whitespace()).stdin(Stdio::null());
    command.env("RUSTDOCFLAGS", "-D warnings");
    command
}
