//! Workspace → docs/MAP.md: every crate and file with its first line, in reading order.

use crate::workspace::{Package, Workspace, read_text};
use anyhow::{Context, Result, bail};
use std::fmt::Write;
use std::path::Path;

const FILE: &str = "docs/MAP.md";
const HEAD: &str = "\
# Map

Every file with its first line, crates and modules in reading order. Written by `cargo xtask map`.
";

/// Crates from the bottom layer up; a crate not named here comes last.
const CRATES: [&str; 17] = [
    "torquewise-motion",
    "torquewise-regression",
    "torquewise-model",
    "torquewise-dynamics",
    "torquewise-signals",
    "torquewise-logs",
    "torquewise-rigid",
    "torquewise-survey",
    "torquewise-stepwise",
    "torquewise-diagnose",
    "torquewise-identify",
    "torquewise-report",
    "torquewise-excite",
    "torquewise-experiments",
    "torquewise",
    "torquewise-cli",
    "xtask",
];

/// Writes the map of the workspace under `root`.
///
/// # Errors
/// If a file cannot be read or the map cannot be written.
pub(crate) fn write(root: &Path) -> Result<()> {
    let text = map(&Workspace::read(root)?);
    std::fs::write(root.join(FILE), text).with_context(|| format!("cannot write {FILE}"))
}

/// Fails if the map under `root` is not the one [`write`] would write.
///
/// # Errors
/// If the map is stale, or a file cannot be read.
pub(crate) fn check(root: &Path) -> Result<()> {
    if read_text(&root.join(FILE))? != map(&Workspace::read(root)?) {
        bail!("{FILE} is stale: run `cargo xtask map`");
    }
    Ok(())
}

/// The text of the map.
fn map(workspace: &Workspace) -> String {
    let mut packages: Vec<&Package> = workspace.packages.iter().collect();
    packages.sort_by_key(|package| CRATES.iter().position(|name| *name == package.name));
    packages.sort_by_key(|package| !CRATES.contains(&package.name.as_str()));
    let mut text = HEAD.to_owned();
    for package in packages {
        let _ = write!(text, "\n## {}\n\n", package.folder);
        write_files(&mut text, package);
    }
    text
}

/// A block with one line per file, first lines aligned.
fn write_files(text: &mut String, package: &Package) {
    let width = package.sources.iter().map(|source| source.within.len()).max().unwrap_or(0);
    text.push_str("```text\n");
    for source in &package.sources {
        let line = source.first_line().unwrap_or("(says nothing)");
        let _ = writeln!(text, "{:width$}  {line}", source.within);
    }
    text.push_str("```\n");
}

#[cfg(test)]
mod tests {
    use super::map;
    use crate::workspace::fixture::{package, workspace};

    #[test]
    fn the_map_is_in_reading_order() {
        let lib = ("src/lib.rs", "//! What an arm did.\n\npub mod motion;\npub mod error;\n");
        let motion = ("src/motion.rs", "//! Signals → Motion: checked.\n");
        let error = ("src/error.rs", "//! What can be wrong.\n");
        let model = package("torquewise-model", "", &[("src/lib.rs", "//! Terms.\n")]);
        let packages = vec![model, package("torquewise-motion", "", &[error, lib, motion])];

        let text = map(&workspace(packages));

        let expected = "\
## crates/torquewise-motion

```text
src/lib.rs     What an arm did.
src/motion.rs  Signals → Motion: checked.
src/error.rs   What can be wrong.
```

## crates/torquewise-model

```text
src/lib.rs  Terms.
```
";
        assert!(text.ends_with(expected), "{text}");
    }
}
