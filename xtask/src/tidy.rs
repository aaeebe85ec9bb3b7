//! Rules that no compiler checks: dependencies between crates point one way, and the paths that
//! ARCHITECTURE.md names exist.

use anyhow::{Context, Result, bail};
use std::fs;
use std::path::Path;

/// A crate, what it may import of the others, and what its tests may import beside.
type Layer = (&'static str, &'static str, &'static str);

/// The table of `ARCHITECTURE.md`. A new edge between crates starts with a change here.
const LAYERS: [Layer; 15] = [
    ("motion", "", ""),
    ("regression", "", ""),
    ("rigid", "regression", "motion model sim"),
    ("model", "motion rigid", "sim"),
    ("logs", "motion", "sim"),
    // Of rigid, stepwise knows the error alone, which its own holds.
    ("stepwise", "motion regression model rigid", "sim"),
    ("identify", "motion regression model rigid stepwise", "sim logs"),
    ("sim", "motion regression rigid model stepwise", ""),
    ("report", "motion model stepwise identify", "sim"),
    ("export", "rigid model sim", ""),
    ("paper", "motion regression model sim stepwise identify report", ""),
    ("", "motion regression model sim logs stepwise identify report export", ""),
    ("cli", "torquewise paper", "sim logs"),
    ("python", "torquewise", ""),
    ("xtask", "", ""),
];

/// Prints every broken rule.
///
/// # Errors
/// If a rule is broken, or a file cannot be read.
pub(crate) fn run(root: &Path) -> Result<()> {
    let broken = check(root)?;
    for rule in &broken {
        eprintln!("{rule}");
    }
    if broken.is_empty() { Ok(()) } else { bail!("tidy found {} broken rules", broken.len()) }
}

fn check(root: &Path) -> Result<Vec<String>> {
    let mut broken = missing_paths(root, &read(&root.join("ARCHITECTURE.md"))?);
    let mut folders: Vec<_> = fs::read_dir(root.join("crates"))?
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<std::io::Result<_>>()?;
    folders.extend(["python", "xtask"].map(|folder| root.join(folder)));
    for folder in folders {
        let manifest = read(&folder.join("Cargo.toml"))?;
        broken.extend(edges(&manifest.parse().context("a Cargo.toml is no TOML")?));
    }
    broken.sort();
    Ok(broken)
}

/// Dependencies of a crate on others of the workspace that the table does not hold.
fn edges(manifest: &toml::Table) -> Vec<String> {
    let name = manifest.get("package").and_then(|package| package.get("name")?.as_str());
    let name = name.unwrap_or_default();
    let Some((_, may, tests_may)) = LAYERS.iter().find(|(layer, _, _)| package_name(layer) == name)
    else {
        return vec![format!("crate {name} has no layer: give it one in xtask/src/tidy.rs")];
    };
    let allowed = |names: &str, found: &str| {
        names.split_whitespace().any(|layer| package_name(layer) == found)
    };
    let mut broken = Vec::new();
    for (table, of_tests) in
        [("dependencies", false), ("build-dependencies", false), ("dev-dependencies", true)]
    {
        let found = manifest.get(table).and_then(toml::Value::as_table).into_iter().flatten();
        for (found, _) in found.filter(|(found, _)| found.starts_with("torquewise")) {
            if !(allowed(may, found) || of_tests && allowed(tests_may, found)) {
                broken.push(format!(
                    "{name} must not have {found} among its {table}: move the code, or change the \
                     table in xtask/src/tidy.rs first"
                ));
            }
        }
    }
    broken
}

/// The name of the package of a layer.
fn package_name(layer: &str) -> String {
    match layer {
        "" | "torquewise" => "torquewise".to_owned(),
        "xtask" => "xtask".to_owned(),
        layer => format!("torquewise-{layer}"),
    }
}

/// Paths between backticks in a text that do not exist.
fn missing_paths(root: &Path, text: &str) -> Vec<String> {
    let quoted = text.split('`').skip(1).step_by(2);
    let is_path = |word: &&str| word.contains('/') && !word.contains([' ', '*', '…']);
    quoted
        .filter(is_path)
        .filter(|path| !root.join(path).exists())
        .map(|path| format!("ARCHITECTURE.md names {path}, which does not exist"))
        .collect()
}

fn read(file: &Path) -> Result<String> {
    fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn broken(text: &str) -> Vec<String> {
        edges(&text.parse().unwrap())
    }

    #[test]
    fn the_workspace_is_tidy() {
        let broken = check(&crate::root()).unwrap();

        assert!(broken.is_empty(), "{}", broken.join("\n"));
    }

    #[test]
    fn the_learner_may_not_import_true_arms_but_its_tests_may() {
        let of = |table: &str| {
            let name = "[package]\nname = 'torquewise-identify'\n";
            broken(&format!("{name}[{table}]\ntorquewise-sim.workspace = true\n"))
        };

        assert!(of("dependencies")[0].starts_with("torquewise-identify must not have"));
        assert!(of("dev-dependencies").is_empty());
    }

    #[test]
    fn a_crate_without_a_layer_is_named() {
        let broken = broken("[package]\nname = 'torquewise-extra'\n");

        assert!(broken[0].contains("torquewise-extra has no layer"));
    }

    #[test]
    fn a_path_that_does_not_exist_is_named() {
        let broken = missing_paths(&crate::root(), "`xtask/src/main.rs` `xtask/src/no.rs` `a b/c`");

        assert_eq!(broken, ["ARCHITECTURE.md names xtask/src/no.rs, which does not exist"]);
    }
}
