//! A suggested profile for an unknown log, with reasons.

mod guess;
mod measure;
mod text;

use crate::source::named_rows;
use crate::{Format, LogError, LogInput, Profile, Result};
use std::collections::BTreeMap;
use std::path::PathBuf;
use torquewise_motion::Signal;

/// A profile for a log that has other columns than `t`, `q1`…`qn`, …
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Suggestion {
    /// The profile as text, with comments where something is to be filled in.
    pub toml: String,
    /// Why, one sentence each.
    pub reasons: Vec<String>,
    /// Whether the clock and the positions were found, so that the log can be read with the
    /// profile as it stands.
    pub is_complete: bool,
    /// Whether it names columns of a torque.
    pub has_torque: bool,
    /// Whether it takes columns from other files of the log's folder.
    pub takes_others: bool,
}

/// Guesses a profile from the column names of a log, and the ranges and slopes of its first rows.
///
/// Names are taken for what they usually mean (`pos`, `vel`, `effort`, …), degrees are told by
/// range and by comparing velocities with the slopes of positions, and the unit of time by the
/// usual step. What no file tells, such as torque constants, is left as a comment. A bag needs no
/// more than its joints and topic.
///
/// - `files`: a log, then files that may hold what it lacks, such as its torques: they are put beside it
///
/// # Errors
/// `LogError` if the file cannot be read; a name that means nothing is no error.
pub fn suggest(files: &[LogInput]) -> Result<Suggestion> {
    let (file, others) = files.split_first().ok_or(LogError::NoFiles)?;
    let rows = named_rows(file)?;
    let names = rows.names().to_vec();
    let is_bag = matches!(Format::of(file)?, Format::Db3 | Format::Mcap);
    if is_bag {
        let joints = rows.joints().unwrap_or_default();
        return checked(text::of_bag(joints, &names));
    }
    drop(rows);
    let mut found = guess::families(file, &names);
    let mut values = BTreeMap::new();
    for (signal, own) in &found.signals {
        values.insert(*signal, measure::columns(file, &own.columns)?);
    }
    let mut time = measure::columns(file, found.time.as_slice())?;
    let (mut beside, mut apart) = (Vec::<(String, PathBuf)>::new(), Vec::new());
    for other in others {
        let own = guess::families(other, named_rows(other)?.names());
        let (clock, mut own) = (own.time.filter(|_| found.time.is_none()), own.signals);
        let is_another = found.get(Signal::Q).is_some() && own.contains_key(&Signal::Q);
        own.retain(|signal, _| !is_another && found.get(*signal).is_none());
        if is_another || (own.is_empty() && clock.is_none()) {
            let what = if is_another {
                "is another log: read it with the same profile"
            } else {
                "has nothing that the log lacks"
            };
            apart.push(format!("{} {what}.", other.display()));
            continue;
        }
        let stem = other.file_stem().unwrap_or_default().to_string_lossy();
        let stem = stem.replace(|c: char| !c.is_ascii_alphanumeric(), "_");
        let numbered = (2..).map(|k| format!("{stem}_{k}"));
        let is_free = |name: &String| beside.iter().all(|(known, _)| known != name);
        let name = std::iter::once(stem.clone()).chain(numbered).find(is_free).unwrap_or_default();
        let near = other.file_name().filter(|_| other.parent() == file.parent());
        let path = near.map(PathBuf::from).or_else(|| std::path::absolute(&**other).ok());
        if let Some(clock) = clock {
            found.time = Some(format!("{name}.{clock}"));
            time = measure::columns(other, &[clock])?;
        }
        for (signal, own) in own {
            values.insert(signal, measure::columns(other, &own.columns)?);
            found.signals.insert(signal, own.of_file(&name));
        }
        beside.push((name, path.unwrap_or_default()));
    }
    let measured = measure::measure(time.first().map(Vec::as_slice), &values);
    let mut suggestion = text::of_columns(&found, &measured, &beside);
    suggestion.reasons.extend(apart);
    checked(suggestion)
}

/// A suggestion must be one that can be read.
fn checked(suggestion: Suggestion) -> Result<Suggestion> {
    Profile::from_toml(&suggestion.toml).map(|_| suggestion)
}

#[cfg(test)]
mod tests;
