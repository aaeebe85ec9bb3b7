//! From folder of a log to files with as many rows, which hold the signals that the log lacks.

use crate::format::Format;
use crate::layout::Signal;
use crate::source::named_rows;
use crate::suggest::guess::{Family, Found, families};
use std::path::{Path, PathBuf};

/// Files of a folder, and bytes of a file, that are looked at.
const MOST_FILES: usize = 50;
const MOST_BYTES: u64 = 1 << 28;

/// A file beside the log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Neighbour {
    /// What its columns are to be called with.
    pub(super) name: &'static str,
    pub(super) file: String,
    /// Signals that the log lacks; their columns are in `Found` by now.
    pub(super) signals: Vec<Signal>,
}

/// Adds the signals of files with as many rows to those of the log.
pub(super) fn beside(log: &Path, n_rows: u64, found: &mut Found) -> Vec<Neighbour> {
    let n_joints = found.get(Signal::Q).map_or(0, |q| q.columns.len());
    let mut neighbours = Vec::new();
    for file in candidates(log) {
        let Some(name) = file.file_name().and_then(|name| name.to_str()) else { continue };
        let Some((names, count)) = counted(&file) else { continue };
        if count != n_rows {
            continue;
        }
        let others = families(&file, &names);
        let lacking = others.signals.into_iter().filter(|(signal, family)| {
            !found.signals.contains_key(signal) && family.columns.len() == n_joints
        });
        let lacking: Vec<(Signal, Family)> = lacking.collect();
        let Some((first, family)) = lacking.first() else { continue };
        let called = called(*first, family.is_current);
        let signals = lacking.iter().map(|(signal, _)| *signal).collect();
        for (signal, family) in lacking {
            found.signals.insert(signal, prefixed(family, called));
        }
        neighbours.push(Neighbour { name: called, file: name.to_owned(), signals });
    }
    neighbours
}

fn called(signal: Signal, is_current: bool) -> &'static str {
    match signal {
        Signal::Q => "position",
        Signal::Dq => "velocity",
        Signal::Ddq => "acceleration",
        Signal::Tau if is_current => "current",
        Signal::Tau => "torque",
    }
}

fn prefixed(family: Family, name: &str) -> Family {
    let with = |column: &String| format!("{name}.{column}");
    Family {
        columns: family.columns.iter().map(with).collect(),
        prefix: family.prefix.as_ref().map(with),
        ..family
    }
}

/// Files that may be read with the log, in alphabetical order.
fn candidates(log: &Path) -> Vec<PathBuf> {
    let folder = log.parent().filter(|folder| !folder.as_os_str().is_empty());
    let Ok(entries) = std::fs::read_dir(folder.unwrap_or(Path::new("."))) else {
        return Vec::new();
    };
    let is_small = |file: &PathBuf| file.metadata().is_ok_and(|m| m.len() < MOST_BYTES);
    let is_table = |file: &PathBuf| matches!(Format::of(file), Ok(Format::Csv | Format::Parquet));
    let mut files: Vec<_> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|file| file.file_name() != log.file_name() && is_table(file) && is_small(file))
        .take(MOST_FILES)
        .collect();
    files.sort();
    files
}

/// Columns and rows of a file, if it can be read; any other is no neighbour.
fn counted(file: &Path) -> Option<(Vec<String>, u64)> {
    let mut rows = named_rows(file).ok()?;
    let names = rows.names().to_vec();
    rows.choose(&[0]).ok()?;
    let mut row = [0.0];
    let mut count = 0;
    while rows.next(&mut row).ok()? {
        count += 1;
    }
    Some((names, count))
}
