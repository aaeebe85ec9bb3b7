//! The suite of the Python package, on the engine that the workspace was built with.

use crate::ci::{call, is_there};
use anyhow::{Context, Result, bail};
use std::env;
use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Runs the suite: package and engine are put side by side as an installed wheel has them, which
/// spares building everything a second time, beside what the suite needs in an environment of its own.
/// Returns whether there is a Python to run it.
///
/// - `target`: folder that cargo built into
pub(crate) fn run(root: &Path, target: &Path) -> Result<bool> {
    let python = python();
    if !is_there(&python) {
        if env::var_os("TORQUEWISE_PYTHON_REQUIRED").is_some() {
            bail!("no {}: install Python 3.10 or newer", python.display());
        }
        eprintln!("skipped: no {}, name one in TORQUEWISE_PYTHON", python.display());
        return Ok(false);
    }
    let folder = target.join("python");
    let site = folder.join("site");
    lay_out(root, target, &site)?;
    let environment = folder.join("environment");
    let inside = environment.join(if cfg!(windows) { "Scripts/python" } else { "bin/python" });
    let needs = requirements(&root.join("python/pyproject.toml"))?;
    if !is_there(&inside) {
        call(Command::new(&python).args(["-m", "venv"]).arg(&environment))?;
    }
    let install = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
    call(Command::new(&inside).args(install).args(needs))?;
    let mut suite = Command::new(&inside);
    suite
        .args(["-m", "pytest", "--quiet", "-p", "no:cacheprovider"])
        .args(["--numprocesses", "auto", "--maxprocesses", "4"])
        .arg(root.join("python/tests"));
    call(suite.env("PYTHONPATH", &site).current_dir(&folder))?;
    Ok(true)
}

/// Builds and tries what is published.
pub(crate) fn package(root: &Path, flags: &[&str]) -> Result<()> {
    let script = root.join("python/tools/package.py");
    call(Command::new(python()).arg("-B").arg(script).args(flags).current_dir(root))
}

fn python() -> OsString {
    env::var_os("TORQUEWISE_PYTHON").unwrap_or_else(|| "python3".into())
}

/// Copies the package, and the engine under the name that Python loads.
fn lay_out(root: &Path, target: &Path, site: &Path) -> Result<()> {
    let package = site.join("torquewise");
    if package.exists() {
        fs::remove_dir_all(&package)?;
    }
    copy(&root.join("python/package/torquewise"), &package)?;
    let engine: PathBuf = target.join(format!("debug/{DLL_PREFIX}_core{DLL_SUFFIX}"));
    let name = if cfg!(windows) { "_core.pyd" } else { "_core.abi3.so" };
    fs::copy(&engine, package.join(name)).with_context(|| format!("no {}", engine.display()))?;
    Ok(())
}

/// Copies a folder and those in it, but for what Python keeps beside its files.
fn copy(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let name = entry.file_name();
        if entry.file_type()?.is_file() {
            fs::copy(entry.path(), to.join(name))?;
        } else if name != "__pycache__" {
            copy(&entry.path(), &to.join(name))?;
        }
    }
    Ok(())
}

/// What the package needs, and its suite.
fn requirements(file: &Path) -> Result<Vec<String>> {
    let text = fs::read_to_string(file).with_context(|| format!("no {}", file.display()))?;
    let table: toml::Table = text.parse().context("pyproject.toml is no TOML")?;
    let project = table.get("project").context("pyproject.toml has no project")?;
    let own = project.get("dependencies");
    let suite = project.get("optional-dependencies").and_then(|extras| extras.get("test"));
    let checks = table.get("dependency-groups").and_then(|groups| groups.get("dev"));
    let lists = [own, suite, checks].into_iter().flatten().filter_map(toml::Value::as_array);
    Ok(lists.flatten().filter_map(toml::Value::as_str).map(str::to_owned).collect())
}
