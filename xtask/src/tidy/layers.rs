//! Manifests → forbidden edges: dependencies between crates point one way.

use crate::violation::Violation;
use crate::workspace::{Package, Workspace};
use std::collections::BTreeSet;

/// A row of the layer table: what a crate of the workspace may import of the others.
struct Layer {
    crate_name: &'static str,
    may_import: &'static [&'static str],
    tests_may_also_import: &'static [&'static str],
}

const fn layer(
    crate_name: &'static str,
    may_import: &'static [&'static str],
    tests_may_also_import: &'static [&'static str],
) -> Layer {
    Layer { crate_name, may_import, tests_may_also_import }
}

const MOTION: &str = "torquewise-motion";
const REGRESSION: &str = "torquewise-regression";
const MODEL: &str = "torquewise-model";
const RIGID: &str = "torquewise-rigid";
const DYNAMICS: &str = "torquewise-dynamics";
const LOGS: &str = "torquewise-logs";
const SIGNALS: &str = "torquewise-signals";
const SURVEY: &str = "torquewise-survey";
const STEPWISE: &str = "torquewise-stepwise";
const DIAGNOSE: &str = "torquewise-diagnose";
const IDENTIFY: &str = "torquewise-identify";
const CONTROL: &str = "torquewise-control";
const REPORT: &str = "torquewise-report";
const EXPORT: &str = "torquewise-export";
const EXCITE: &str = "torquewise-excite";
const EXPERIMENTS: &str = "torquewise-experiments";
const FRONT_DOOR: &str = "torquewise";

/// The table of `ARCHITECTURE.md`. A new edge between crates starts with a change here.
const LAYERS: [Layer; 19] = [
    layer(MOTION, &[], &[]),
    layer(REGRESSION, &[], &[]),
    layer(RIGID, &[REGRESSION], &[MOTION, MODEL, DYNAMICS]),
    layer(MODEL, &[MOTION, RIGID], &[DYNAMICS]),
    layer(DYNAMICS, &[MOTION, RIGID], &[]),
    layer(SIGNALS, &[MOTION], &[DYNAMICS]),
    layer(LOGS, &[MOTION, SIGNALS], &[DYNAMICS]),
    // Of rigid, survey knows the error alone, which its own holds.
    layer(SURVEY, &[MOTION, REGRESSION, MODEL, RIGID], &[DYNAMICS]),
    layer(STEPWISE, &[MOTION, REGRESSION, MODEL, SURVEY], &[DYNAMICS]),
    layer(DIAGNOSE, &[MOTION, MODEL, SURVEY, STEPWISE], &[DYNAMICS]),
    layer(
        IDENTIFY,
        &[MOTION, REGRESSION, MODEL, RIGID, SURVEY, STEPWISE, DIAGNOSE],
        &[DYNAMICS, SIGNALS, LOGS],
    ),
    layer(REPORT, &[MOTION, MODEL, STEPWISE, DIAGNOSE, IDENTIFY], &[DYNAMICS]),
    layer(EXPORT, &[MODEL], &[DYNAMICS]),
    layer(EXCITE, &[MOTION, REGRESSION, MODEL, DYNAMICS, STEPWISE, IDENTIFY], &[]),
    layer(CONTROL, &[MOTION, MODEL, DYNAMICS], &[]),
    layer(
        EXPERIMENTS,
        &[
            MOTION, REGRESSION, MODEL, DYNAMICS, SIGNALS, SURVEY, STEPWISE, IDENTIFY, REPORT,
            EXCITE, CONTROL,
        ],
        &[],
    ),
    layer(
        FRONT_DOOR,
        &[
            MOTION,
            REGRESSION,
            MODEL,
            DYNAMICS,
            SIGNALS,
            LOGS,
            SURVEY,
            STEPWISE,
            DIAGNOSE,
            IDENTIFY,
            REPORT,
            EXPORT,
            EXCITE,
            CONTROL,
            EXPERIMENTS,
        ],
        &[],
    ),
    layer("torquewise-cli", &[FRONT_DOOR], &[DYNAMICS, LOGS]),
    layer("xtask", &[], &[]),
];

/// Every edge between two crates of the workspace that the table does not hold.
pub(crate) fn check(workspace: &Workspace) -> Vec<Violation> {
    let names: BTreeSet<&str> = workspace.packages.iter().map(|p| p.name.as_str()).collect();
    workspace.packages.iter().flat_map(|package| check_package(package, &names)).collect()
}

fn check_package(package: &Package, workspace: &BTreeSet<&str>) -> Vec<Violation> {
    let manifest = format!("{}/Cargo.toml", package.folder);
    let name = &package.name;
    let Some(layer) = LAYERS.iter().find(|layer| layer.crate_name == name) else {
        let message = format!("crate {name} has no layer: give it one in xtask/src/tidy/layers.rs");
        return vec![Violation::new(&manifest, 1, message)];
    };
    let within = |dependency: &&String| workspace.contains(dependency.as_str());
    let allowed = |dependency: &str| layer.may_import.contains(&dependency);
    let allowed_in_tests = |dependency: &str| layer.tests_may_also_import.contains(&dependency);
    let mut violations = Vec::new();
    for dependency in package.dependencies.iter().filter(within).filter(|d| !allowed(d)) {
        let message = format!(
            "{name} must not depend on {dependency}, only on {}: move the code, or change the \
             layer table first",
            listed(layer.may_import)
        );
        violations.push(Violation::new(&manifest, 1, message));
    }
    for dependency in package.dev_dependencies.iter().filter(within) {
        if !allowed(dependency) && !allowed_in_tests(dependency) {
            let message = format!(
                "tests of {name} must not depend on {dependency}: move the test to a layer that may"
            );
            violations.push(Violation::new(&manifest, 1, message));
        }
    }
    violations
}

fn listed(names: &[&str]) -> String {
    if names.is_empty() { "no crate of the workspace".to_owned() } else { names.join(", ") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace::fixture::{package, workspace};

    /// Messages for a crate with this manifest, in a workspace that also has the usual crates.
    fn messages(name: &str, manifest: &str) -> Vec<String> {
        let others = [
            MOTION,
            REGRESSION,
            MODEL,
            RIGID,
            DYNAMICS,
            LOGS,
            SIGNALS,
            SURVEY,
            STEPWISE,
            IDENTIFY,
            REPORT,
            EXPORT,
            EXCITE,
            CONTROL,
            EXPERIMENTS,
            FRONT_DOOR,
        ];
        let mut packages = vec![package(name, manifest, &[])];
        packages.extend(others.iter().filter(|o| **o != name).map(|o| package(o, "", &[])));
        check(&workspace(packages)).into_iter().map(|violation| violation.message).collect()
    }

    #[test]
    fn the_learner_cannot_peek_at_the_truth() {
        let manifest = "[dependencies]\ntorquewise-dynamics.workspace = true";

        let found = messages(IDENTIFY, manifest);

        assert_eq!(found.len(), 1);
        assert!(found[0].starts_with("torquewise-identify must not depend on torquewise-dynamics"));
    }

    #[test]
    fn tests_of_the_learner_may_use_dynamics() {
        let manifest = "[dev-dependencies]\ntorquewise-dynamics.workspace = true";

        assert_eq!(messages(IDENTIFY, manifest), [""; 0]);
    }

    #[test]
    fn logs_are_for_tests_of_the_command_line_only() {
        let manifest = "[dev-dependencies]\ntorquewise-logs.workspace = true";

        assert_eq!(messages("torquewise-cli", manifest), [""; 0]);
        assert_eq!(messages(REPORT, manifest).len(), 1);
    }

    #[test]
    fn crates_of_others_are_free() {
        assert_eq!(messages(REGRESSION, "[dependencies]\nfaer.workspace = true"), [""; 0]);
    }

    #[test]
    fn a_crate_outside_the_table_is_reported() {
        assert!(messages("torquewise-extra", "")[0].contains("has no layer"));
    }

    #[test]
    fn the_table_only_points_down() {
        for (place, layer) in LAYERS.iter().enumerate() {
            for import in layer.may_import {
                let below = LAYERS[..place].iter().any(|lower| lower.crate_name == *import);
                assert!(below, "{} imports {import}", layer.crate_name);
            }
        }
    }
}
