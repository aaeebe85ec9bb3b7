//! Manifest and files → Package: a crate for tests, read from no disk.

use super::{Package, Source, Workspace};
use std::path::PathBuf;

/// A crate `name` in `crates/name`, with its manifest after `[package]` and its files.
pub(crate) fn package(name: &str, manifest: &str, files: &[(&str, &str)]) -> Package {
    let folder = format!("crates/{name}");
    let path = |within: &str| format!("{folder}/{within}");
    let sources = files.iter().map(|(within, text)| Source::new(&folder, &path(within), text));
    Package::new(name, &folder, &manifest.parse().unwrap(), sources.collect())
}

/// A workspace of these crates, in no folder.
pub(crate) fn workspace(packages: Vec<Package>) -> Workspace {
    Workspace { root: PathBuf::new(), packages }
}
