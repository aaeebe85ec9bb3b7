//! Workspace → verdict: everything a change must pass, cheapest first.

use crate::workspace::Workspace;
use crate::{map, tidy};
use anyhow::{Context, Result, bail};
use std::env;
use std::path::Path;
use std::process::{Command, Stdio};

/// One call of cargo: its arguments and the variables it needs.
#[derive(Clone, Debug, PartialEq)]
struct Step {
    arguments: Vec<String>,
    variables: Vec<(&'static str, &'static str)>,
}

/// Runs every check and stops at the first that fails.
///
/// # Errors
/// The step that failed.
pub(crate) fn run(root: &Path) -> Result<()> {
    let workspace = Workspace::read(root)?;
    run_step(root, &step("fmt --all -- --check"))?;
    announce("xtask tidy");
    tidy::run(root)?;
    announce("xtask map --check");
    map::check(root)?;
    for step in compiled_steps(&workspace, has_nextest(root)) {
        run_step(root, &step)?;
    }
    announce("all passed");
    Ok(())
}

/// Every step that needs a compiler. A machine without nextest runs the same tests.
fn compiled_steps(workspace: &Workspace, with_nextest: bool) -> Vec<Step> {
    let tests = if with_nextest {
        "nextest run --workspace"
    } else {
        "test --workspace --lib --bins --tests"
    };
    let mut documentation = step("doc --workspace --no-deps --lib");
    documentation.variables.push(("RUSTDOCFLAGS", "-D warnings"));
    let mut steps = vec![
        step("clippy --workspace --all-targets -- -D warnings"),
        documentation,
        step(tests),
        step("test --workspace --doc"),
    ];
    steps.extend(examples(workspace));
    steps
}

/// Every `examples/*.rs`, by number.
fn examples(workspace: &Workspace) -> impl Iterator<Item = Step> {
    workspace.packages.iter().flat_map(|package| {
        let files = package.sources.iter().map(|source| source.within.as_str());
        let names = files.filter_map(|file| file.strip_prefix("examples/")?.strip_suffix(".rs"));
        let alone = names.filter(|name| !name.contains('/'));
        alone.map(|name| step(&format!("run --package {} --example {name}", package.name)))
    })
}

fn step(line: &str) -> Step {
    Step { arguments: line.split(' ').map(str::to_owned).collect(), variables: Vec::new() }
}

fn announce(name: &str) {
    eprintln!("\n=== {name}");
}

fn run_step(root: &Path, step: &Step) -> Result<()> {
    let line = format!("cargo {}", step.arguments.join(" "));
    announce(&line);
    let status = cargo(root)
        .args(&step.arguments)
        .envs(step.variables.iter().copied())
        .status()
        .with_context(|| format!("cannot start `{line}`"))?;
    if !status.success() {
        bail!("`{line}` failed: see above");
    }
    Ok(())
}

/// The cargo that runs this program.
fn cargo(root: &Path) -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root);
    command
}

fn has_nextest(root: &Path) -> bool {
    let mut asked = cargo(root);
    asked.args(["nextest", "--version"]).stdout(Stdio::null()).stderr(Stdio::null());
    asked.status().is_ok_and(|status| status.success())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace::fixture::{package, workspace};

    #[test]
    fn a_machine_without_nextest_runs_the_same_tests() {
        let lines = |with_nextest| -> Vec<String> {
            let steps = compiled_steps(&workspace(Vec::new()), with_nextest);
            steps.iter().map(|step| step.arguments.join(" ")).collect()
        };

        assert_eq!(lines(true)[2], "nextest run --workspace");
        assert_eq!(lines(false)[2], "test --workspace --lib --bins --tests");
        assert_eq!(
            (&lines(true)[..2], &lines(true)[3..]),
            (&lines(false)[..2], &lines(false)[3..])
        );
    }

    #[test]
    fn every_example_runs() {
        let files = [("examples/02_friction.rs", ""), ("examples/01_quickstart.rs", "")];
        let workspace = workspace(vec![package("torquewise", "", &files)]);

        let lines: Vec<String> = examples(&workspace).map(|s| s.arguments.join(" ")).collect();

        let expected = ["01_quickstart", "02_friction"];
        assert_eq!(
            lines,
            expected.map(|name| format!("run --package torquewise --example {name}"))
        );
    }

    #[test]
    fn a_failing_step_is_named() {
        let error = run_step(Path::new("."), &step("no-such-chore")).unwrap_err();

        assert_eq!(error.to_string(), "`cargo no-such-chore` failed: see above");
    }
}
