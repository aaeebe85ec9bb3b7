//! What a command found, written to stdout and stderr, and its exit code.

use crate::{CliError, Result};
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::env;
use std::io::{self, IsTerminal, Write};

#[derive(Clone, Debug, Default)]
pub(crate) struct Outcome {
    pub(crate) text: String,
    /// For programs: an object.
    pub(crate) json: Value,
    /// What does not stop the work but may spoil its result.
    pub(crate) warnings: Vec<String>,
    /// What is good to know and changes nothing.
    pub(crate) notes: Vec<String>,
    /// Whether the result must not be used: a verdict on a model.
    pub(crate) is_unusable: bool,
}

pub(crate) fn object(result: &impl Serialize) -> Value {
    // Results have neither keys that are no text nor numbers that JSON cannot hold.
    serde_json::to_value(result).unwrap_or_default()
}

/// Exit codes other than 0.
const FAILED: u8 = 1;
const WRONG_USAGE: u8 = 2;
const UNUSABLE: u8 = 3;

/// Writes results to stdout and all else to stderr, and says how it went.
///
/// - `strict`: whether any warning makes the result one not to be used
pub(crate) fn report(found: Result<Outcome>, as_json: bool, strict: bool) -> u8 {
    match found {
        Ok(outcome) => {
            let text = if as_json {
                let mut object = outcome.json.as_object().cloned().unwrap_or_else(Map::new);
                object.insert("warnings".into(), json!(outcome.warnings));
                object.insert("notes".into(), json!(outcome.notes));
                Value::Object(object).to_string() + "\n"
            } else {
                printable(&outcome.text)
            };
            if let Err(source) = write_stdout(&text) {
                return fail(&CliError::Stdout { source }, false);
            }
            for note in &outcome.notes {
                complain("note", "36", note);
            }
            for warning in &outcome.warnings {
                complain("warning", "33", warning);
            }
            let is_doubtful = strict && !outcome.warnings.is_empty();
            if outcome.is_unusable || is_doubtful { UNUSABLE } else { 0 }
        }
        Err(error) => fail(&error, as_json),
    }
}

/// Writes what the command line itself has to say: help, the version, or wrong usage.
pub(crate) fn told(told: &clap::Error) -> u8 {
    let usual = if told.use_stderr() { WRONG_USAGE } else { 0 };
    let printed = quiet_if_closed(told.print().and_then(|()| io::stdout().flush()));
    printed.map_or_else(|source| fail(&CliError::Stdout { source }, false), |()| usual)
}

/// A text whose control characters a terminal shows instead of obeying them.
fn printable(text: &str) -> String {
    let is_layout = |c| c == '\n' || c == '\t';
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() && !is_layout(c) {
            shown.extend(c.escape_default());
        } else {
            shown.push(c);
        }
    }
    shown
}

/// A reader that has seen enough, such as `head`, is no failure.
fn quiet_if_closed(written: io::Result<()>) -> io::Result<()> {
    match written {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}

fn write_stdout(text: &str) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    quiet_if_closed(stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()))
}

fn fail(error: &CliError, as_json: bool) -> u8 {
    let causes: Vec<String> = error.causes().iter().map(|cause| cut(cause)).collect();
    complain("error", "31", &causes.join("\n  because: "));
    let help = error.advice();
    if let Some(help) = &help {
        complain("help", "36", help);
    }
    if as_json {
        let object = json!({ "error": causes.join("; "), "help": help });
        // Ignored: stdout is gone.
        let _ = write_stdout(&(object.to_string() + "\n"));
    }
    if error.is_usage() { WRONG_USAGE } else { FAILED }
}

/// Writes to stderr, its first word coloured where people look at it.
fn complain(word: &str, colour: &str, text: &str) {
    let text = printable(text);
    let mut stderr = io::stderr().lock();
    let plain = env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    // Ignored: stderr is gone.
    let _ = if stderr.is_terminal() && !plain {
        writeln!(stderr, "\x1b[1;{colour}m{word}:\x1b[0m {text}")
    } else {
        writeln!(stderr, "{word}: {text}")
    };
}

/// A message whose lines are as long as people read: what quotes a file may be longer.
fn cut(message: &str) -> String {
    const LONGEST: usize = 400;
    let cut = |line: &str| match line.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &line[..end]),
        None => line.to_owned(),
    };
    message.trim_end().lines().map(cut).collect::<Vec<_>>().join("\n    ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_terminal_shows_control_characters_and_long_lines_are_cut() {
        assert_eq!(printable("a\n\tb\u{1b}[31m\0\u{9b}"), "a\n\tb\\u{1b}[31m\\u{0}\\u{9b}");
        assert_eq!(cut(&"x".repeat(20_000)).chars().count(), 401);
    }
}
