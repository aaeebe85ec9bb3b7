//! Workspace → violations: the rules of the house that no compiler checks.

mod layers;
mod reading_order;
mod lengths;
mod names;
mod forbidden;
mod crate_roots;
mod architecture;

use crate::violation::Violation;
use crate::workspace::Workspace;
use anyhow::{Result, bail};
use std::path::Path;

/// Checks the workspace under `root` and prints every broken rule.
///
/// # Errors
/// If a rule is broken, or a file cannot be read.
pub(crate) fn run(root: &Path) -> Result<()> {
    let violations = check(&Workspace::read(root)?)?;
    for violation in &violations {
        eprintln!("{violation}");
    }
    match violations.len() {
        0 => Ok(()),
        n => bail!("tidy found {n} broken rules"),
    }
}

/// Every broken rule, by place.
///
/// # Errors
/// If `ARCHITECTURE.md` cannot be read.
pub(crate) fn check(workspace: &Workspace) -> Result<Vec<Violation>> {
    let mut violations = architecture::check(&workspace.root)?;
    violations.extend(layers::check(workspace));
    for package in &workspace.packages {
        violations.extend(reading_order::check(package));
        violations.extend(crate_roots::check(package));
    }
    for source in workspace.sources() {
        violations.extend(lengths::check(source));
        violations.extend(names::check(source));
        violations.extend(forbidden::check(source));
    }
    violations.sort();
    violations.dedup();
    Ok(violations)
}

#[cfg(test)]
mod tests {
    use super::check;
    use crate::workspace::{Workspace, root};

    #[test]
    fn the_workspace_is_tidy() {
        let workspace = Workspace::read(&root()).unwrap();

        let violations = check(&workspace).unwrap();

        let list: Vec<String> = violations.iter().map(ToString::to_string).collect();
        assert!(list.is_empty(), "{}", list.join("\n"));
    }
}
