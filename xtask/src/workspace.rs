//! Folder → Workspace: the crates, what each may reach, and its source files in reading order.

use crate::code::{self, Child};
use anyhow::{Context, Result, bail};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The crates of a workspace, by name.
#[derive(Clone, Debug)]
pub(crate) struct Workspace {
    /// Folder that holds the workspace `Cargo.toml`.
    pub(crate) root: PathBuf,
    /// `crates/*` in alphabetical order, then `xtask`.
    pub(crate) packages: Vec<Package>,
}

/// One crate.
#[derive(Clone, Debug)]
pub(crate) struct Package {
    /// Its name, which is that of its folder.
    pub(crate) name: String,
    /// Its folder, relative to the workspace root.
    pub(crate) folder: String,
    /// Names under `[dependencies]`, `[build-dependencies]` and their `[target]` forms.
    pub(crate) dependencies: BTreeSet<String>,
    /// Names under `[dev-dependencies]`.
    pub(crate) dev_dependencies: BTreeSet<String>,
    /// Every Rust file: those of `src` in reading order, then the others by path.
    pub(crate) sources: Vec<Source>,
}

/// One Rust file.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    /// Path relative to the workspace root, with `/` between the parts.
    pub(crate) path: String,
    /// Path relative to the folder of the crate.
    pub(crate) within: String,
    /// The file as it stands.
    pub(crate) text: String,
    /// The file without comments and literals, see [`code::blank`].
    pub(crate) code: Vec<char>,
    /// The code without its tests, see [`code::shipped`].
    pub(crate) shipped: Vec<char>,
    /// Whether all of it is tests: under `tests/`, a `tests.rs`, or declared under `cfg(test)`.
    pub(crate) is_test: bool,
}

/// The workspace this program was built from.
pub(crate) fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).to_path_buf()
}

impl Workspace {
    /// Reads `crates/*` and `xtask` under `root`.
    ///
    /// # Errors
    /// A folder or file that cannot be read, or a `Cargo.toml` that is not one.
    pub(crate) fn read(root: &Path) -> Result<Self> {
        let mut folders: Vec<String> = entries(&root.join("crates"))?
            .into_iter()
            .filter(|name| root.join("crates").join(name).join("Cargo.toml").is_file())
            .map(|name| format!("crates/{name}"))
            .collect();
        if root.join("xtask/Cargo.toml").is_file() {
            folders.push("xtask".to_owned());
        }
        let packages = folders.iter().map(|folder| Package::read(root, folder));
        Ok(Self { root: root.to_path_buf(), packages: packages.collect::<Result<_>>()? })
    }

    /// Every Rust file of every crate.
    pub(crate) fn sources(&self) -> impl Iterator<Item = &Source> {
        self.packages.iter().flat_map(|package| &package.sources)
    }
}

impl Package {
    fn read(root: &Path, folder: &str) -> Result<Self> {
        let manifest = root.join(folder).join("Cargo.toml");
        let text = read_text(&manifest)?;
        let table: toml::Table =
            text.parse().with_context(|| format!("{} is not TOML", manifest.display()))?;
        let Some(name) = table.get("package").and_then(|package| package.get("name")?.as_str())
        else {
            bail!("{} has no package name", manifest.display());
        };
        let mut paths = Vec::new();
        collect_rust_files(root, folder, &mut paths)?;
        let sources = paths.iter().map(|path| Source::read(root, folder, path));
        Ok(Self::new(name, folder, &table, sources.collect::<Result<_>>()?))
    }

    /// A crate from its manifest and files.
    fn new(name: &str, folder: &str, manifest: &toml::Table, sources: Vec<Source>) -> Self {
        let mut package = Self {
            name: name.to_owned(),
            folder: folder.to_owned(),
            dependencies: dependencies(manifest, &["dependencies", "build-dependencies"]),
            dev_dependencies: dependencies(manifest, &["dev-dependencies"]),
            sources,
        };
        package.mark_tests();
        package.sort_by_reading_order();
        package
    }

    /// The file that lists the modules: `src/lib.rs`, or `src/main.rs` where there is no library.
    pub(crate) fn crate_root(&self) -> Option<&Source> {
        ["src/lib.rs", "src/main.rs"].into_iter().find_map(|path| self.source(path))
    }

    /// The file at a path relative to the crate.
    pub(crate) fn source(&self, within: &str) -> Option<&Source> {
        self.sources.iter().find(|source| source.within == within)
    }

    /// The modules that the module at `path` declares, in order.
    pub(crate) fn children(&self, path: &[String]) -> Vec<Child> {
        let source = self.module(path);
        source.map_or_else(Vec::new, |source| code::children(&source.code))
    }

    /// The file of the module at `path`.
    fn module(&self, path: &[String]) -> Option<&Source> {
        if path.is_empty() {
            return self.crate_root();
        }
        let stem = format!("src/{}", path.join("/"));
        let plain = self.source(&format!("{stem}.rs"));
        plain.or_else(|| self.source(&format!("{stem}/mod.rs")))
    }

    /// Marks the modules that their parent declares for tests only.
    fn mark_tests(&mut self) {
        let marks: Vec<bool> =
            self.sources.iter().map(|s| s.is_test || self.tests_only(s)).collect();
        for (source, is_test) in self.sources.iter_mut().zip(marks) {
            source.is_test = is_test;
        }
    }

    fn tests_only(&self, source: &Source) -> bool {
        let path = source.module_path().unwrap_or_default();
        let Some((name, parent)) = path.split_last() else {
            return false;
        };
        let declares = |code: &[char]| code::children(code).iter().any(|c| c.name == *name);
        self.module(parent).is_some_and(|m| declares(&m.code) && !declares(&m.shipped))
    }

    /// Puts `src` first, each module before those it declares, those in the declared order.
    fn sort_by_reading_order(&mut self) {
        let keys: Vec<Vec<usize>> = self.sources.iter().map(|s| self.reading_key(s)).collect();
        let mut keyed: Vec<(Vec<usize>, Source)> =
            keys.into_iter().zip(std::mem::take(&mut self.sources)).collect();
        keyed.sort_by(|a, b| (&a.0, &a.1.path).cmp(&(&b.0, &b.1.path)));
        self.sources = keyed.into_iter().map(|(_, source)| source).collect();
    }

    /// Position of each part of the module path; a file outside `src` comes last.
    fn reading_key(&self, source: &Source) -> Vec<usize> {
        let Some(path) = source.module_path() else {
            return vec![usize::MAX];
        };
        let mut key = Vec::new();
        for (depth, name) in path.iter().enumerate() {
            let children = self.children(&path[..depth]);
            let place = children.iter().position(|child| child.name == *name);
            key.push(place.unwrap_or(children.len()));
        }
        key
    }
}

impl Source {
    /// A file from its text.
    pub(crate) fn new(folder: &str, path: &str, text: &str) -> Self {
        let code = code::blank(text);
        let within = path.strip_prefix(folder).unwrap_or(path).trim_start_matches('/');
        Self {
            path: path.to_owned(),
            within: within.to_owned(),
            text: text.to_owned(),
            shipped: code::shipped(&code),
            code,
            is_test: within.starts_with("tests/") || path.ends_with("/tests.rs"),
        }
    }

    fn read(root: &Path, folder: &str, path: &str) -> Result<Self> {
        Ok(Self::new(folder, path, &read_text(&root.join(path))?))
    }

    /// Module path of a file of `src`: empty for the crate root, `None` for tests, examples, ….
    pub(crate) fn module_path(&self) -> Option<Vec<String>> {
        let stem = self.within.strip_prefix("src/")?.strip_suffix(".rs")?;
        let stem = stem.strip_suffix("/mod").unwrap_or(stem);
        if matches!(stem, "lib" | "main") {
            return Some(Vec::new());
        }
        Some(stem.split('/').map(str::to_owned).collect())
    }

    /// The first line without its `//! `; `None` if it is no such line.
    pub(crate) fn first_line(&self) -> Option<&str> {
        self.text.lines().next()?.strip_prefix("//! ")
    }
}

/// Real package names under each of the named tables, plain and per target.
fn dependencies(manifest: &toml::Table, names: &[&str]) -> BTreeSet<String> {
    let targets = manifest.get("target").and_then(toml::Value::as_table);
    let per_target = targets.into_iter().flat_map(|targets| targets.values());
    let tables = std::iter::once(manifest).chain(per_target.filter_map(toml::Value::as_table));
    let mut found = BTreeSet::new();
    for table in tables {
        let named = names.iter().filter_map(|name| table.get(*name)?.as_table());
        for (key, value) in named.flatten() {
            let renamed = value.get("package").and_then(toml::Value::as_str);
            found.insert(renamed.unwrap_or(key).to_owned());
        }
    }
    found
}

fn collect_rust_files(root: &Path, folder: &str, found: &mut Vec<String>) -> Result<()> {
    for name in entries(&root.join(folder))? {
        let path = format!("{folder}/{name}");
        if root.join(&path).is_dir() {
            if name != "target" && !name.starts_with('.') {
                collect_rust_files(root, &path, found)?;
            }
        } else if Path::new(&path).extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    Ok(())
}

/// Names in a folder, sorted.
fn entries(folder: &Path) -> Result<Vec<String>> {
    let listing =
        fs::read_dir(folder).with_context(|| format!("cannot list {}", folder.display()))?;
    let mut names = Vec::new();
    for entry in listing {
        let entry = entry.with_context(|| format!("cannot list {}", folder.display()))?;
        names.push(entry.file_name().to_string_lossy().into_owned());
    }
    names.sort();
    Ok(names)
}

/// A text file, whole.
///
/// # Errors
/// The file's path, and why it cannot be read.
pub(crate) fn read_text(path: &Path) -> Result<String> {
    fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))
}

#[cfg(test)]
pub(crate) mod fixture;
#[cfg(test)]
mod tests;
