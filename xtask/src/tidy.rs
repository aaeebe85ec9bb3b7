//! Rules that no compiler checks: the paths that ARCHITECTURE.md names exist, files and repository
//! are no longer than they may be and made of no more crates, errors of libraries name no flags, and
//! the learner does not know the arms it is tried on.

use crate::ci::command;
use anyhow::{Context, Result, bail};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Lines of a file of Rust, and of all of them.
const MOST_LINES_OF_FILE: usize = 400;
const MOST_LINES: usize = 80_000;

/// What cargo builds, and the crates it may be made of, with itself.
const MOST_CRATES: [(&str, usize); 2] =
    [("--package torquewise-cli", 200), ("--package torquewise --no-default-features", 100)];

/// Prints every broken rule.
pub(crate) fn run(root: &Path) -> Result<()> {
    let broken = check(root)?;
    for rule in &broken {
        eprintln!("{rule}");
    }
    if broken.is_empty() { Ok(()) } else { bail!("tidy found {} broken rules", broken.len()) }
}

fn check(root: &Path) -> Result<Vec<String>> {
    let mut broken = missing_paths(root, &read(&root.join("ARCHITECTURE.md"))?);
    let mut files = Vec::new();
    for folder in ["crates", "fuzz", "python", "xtask"] {
        rust_files(&root.join(folder), &mut files)?;
    }
    let mut total = 0;
    for file in files {
        let text = read(&file)?;
        let lines = text.lines().count();
        let is_of_command_line = file.components().any(|part| part.as_os_str() == "torquewise-cli");
        if file.ends_with("error.rs") && !is_of_command_line && text.contains(" --") {
            broken.push(format!("{} names a flag of the command line", file.display()));
        }
        total += lines;
        if lines > MOST_LINES_OF_FILE {
            broken.push(format!("{} has {lines} lines", file.display()));
        }
    }
    if total > MOST_LINES {
        broken.push(format!("{total} lines of Rust, at most {MOST_LINES} are allowed"));
    }
    for (of, most) in MOST_CRATES {
        let number = number_of_crates(root, of)?;
        eprintln!("{of}: {number} crates");
        if number == 0 || number > most {
            broken.push(format!("{of}: {number} crates, at most {most} are allowed"));
        }
    }
    // Cargo refuses circles; this edge would be none.
    let manifest: toml::Table =
        read(&root.join("crates/torquewise-identify/Cargo.toml"))?.parse()?;
    if manifest.get("dependencies").is_some_and(|own| own.get("torquewise-sim").is_some()) {
        broken.push("torquewise-identify must not know true arms: its tests alone may".into());
    }
    Ok(broken)
}

/// How many crates something is made of.
fn number_of_crates(root: &Path, of: &str) -> Result<usize> {
    let line = format!("tree {of} --edges normal,build --prefix none --format {{p}}");
    let listed = command(root, &line).output().context("cannot start cargo tree")?;
    let listed = String::from_utf8_lossy(&listed.stdout);
    let names: BTreeSet<_> = listed.lines().map(|line| line.split(" (").next()).collect();
    Ok(names.len())
}

/// The files of Rust in a folder and those in it, but for what tools leave there.
fn rust_files(folder: &Path, files: &mut Vec<PathBuf>) -> Result<()> {
    for entry in fs::read_dir(folder).with_context(|| format!("no {}", folder.display()))? {
        let (entry, skipped) = (entry?, ["target", "corpus", "artifacts", "coverage"]);
        let (path, name) = (entry.path(), entry.file_name());
        let name = name.to_string_lossy();
        if entry.file_type()?.is_dir() {
            if !name.starts_with('.') && !skipped.contains(&&*name) {
                rust_files(&path, files)?;
            }
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            files.push(path);
        }
    }
    Ok(())
}

/// Paths between backticks in a text that do not exist.
fn missing_paths(root: &Path, text: &str) -> Vec<String> {
    let is_path = |word: &&str| word.contains('/') && !word.contains([' ', '*', '…']);
    let quoted = text.split('`').skip(1).step_by(2).filter(is_path);
    let missing = quoted.filter(|path| !root.join(path).exists());
    missing.map(|path| format!("ARCHITECTURE.md names {path}, which does not exist")).collect()
}

fn read(file: &Path) -> Result<String> {
    fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_workspace_is_tidy() {
        let broken = check(&crate::root()).unwrap();

        assert!(broken.is_empty(), "{}", broken.join("\n"));
    }

    #[test]
    fn a_path_that_does_not_exist_is_named() {
        let broken = missing_paths(&crate::root(), "`xtask/src/main.rs` `xtask/src/no.rs` `a b/c`");

        assert_eq!(broken, ["ARCHITECTURE.md names xtask/src/no.rs, which does not exist"]);
    }
}
