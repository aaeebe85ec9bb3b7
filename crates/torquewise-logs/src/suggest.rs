//! A suggested profile for an unknown log, with reasons.

mod guess;
mod measure;
mod text;

use crate::error::Result;
use crate::format::Format;
use crate::log_input::LogInput;
use crate::profile::Profile;
use crate::source::named_rows;

/// A profile for a log that has other columns than `t`, `q1`…`qn`, …
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Suggestion {
    /// The profile as text, with comments where something is to be filled in.
    pub toml: String,
    /// Why, one sentence each.
    pub reasons: Vec<String>,
    /// Whether the clock and the positions were found, so that the log can be read with the
    /// profile as it stands.
    pub is_complete: bool,
}

/// Guesses a profile from the column names of a log, and the ranges and slopes of its first rows.
///
/// Names are taken for what they usually mean (`pos`, `vel`, `effort`, …), degrees are told by
/// range and by comparing velocities with the slopes of positions, and the unit of time by the
/// usual step. What no file tells, such as torque constants or files beside the log, is left as a comment. A bag needs no
/// more than its joints and topic.
///
/// # Errors
/// `LogError` if the file cannot be read; a name that means nothing is no error.
pub fn suggest(file: impl Into<LogInput>) -> Result<Suggestion> {
    let file = &file.into();
    let rows = named_rows(file)?;
    let names = rows.names().to_vec();
    let is_bag = matches!(Format::of(file)?, Format::Db3 | Format::Mcap);
    if is_bag {
        let joints = rows.joints().unwrap_or_default();
        return checked(text::of_bag(joints, &names));
    }
    drop(rows);
    let found = guess::families(file, &names);
    let measured = measure::measure(file, &names, &found)?;
    checked(text::of_columns(&found, &measured))
}

/// A suggestion must be one that can be read.
fn checked(suggestion: Suggestion) -> Result<Suggestion> {
    Profile::from_toml(&suggestion.toml).map(|_| suggestion)
}

#[cfg(test)]
mod tests;
