//! What a command found, written to stdout and stderr, and its exit code.

use crate::error::{CliError, in_flags};
use anyhow::Error;
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::env;
use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;
use torquewise::dynamics::SimError;
use torquewise::export::ExportError;
use torquewise::identify::IdentifyError;
use torquewise::logs::LogError;
use torquewise::model::ModelError;
use torquewise::motion::MotionError;
use torquewise::regression::SparseError;
use torquewise::report::ReportError;

/// What a command found.
#[derive(Clone, Debug, Default)]
pub(crate) struct Outcome {
    /// For people.
    pub(crate) text: String,
    /// For programs: an object.
    pub(crate) json: Value,
    /// What does not stop the work but may spoil its result.
    pub(crate) warnings: Vec<String>,
    /// What is good to know and changes nothing.
    pub(crate) notes: Vec<String>,
}

/// The object that programs read.
pub(crate) fn object(result: &impl Serialize) -> Value {
    // Results have neither keys that are no text nor numbers that JSON cannot hold.
    serde_json::to_value(result).unwrap_or_default()
}

/// Exit codes other than 0.
const FAILED: u8 = 1;
const WRONG_USAGE: u8 = 2;
const WITH_WARNINGS: u8 = 3;

/// Writes results to stdout and all else to stderr, and says how it went.
pub(crate) fn report(found: Result<Outcome, Error>, as_json: bool) -> ExitCode {
    let code = match found {
        Ok(outcome) => match write_results(&outcome, as_json) {
            Ok(()) => {
                for note in &outcome.notes {
                    complain("note", "36", note);
                }
                for warning in &outcome.warnings {
                    complain("warning", "33", warning);
                }
                if outcome.warnings.is_empty() { 0 } else { WITH_WARNINGS }
            }
            Err(source) => fail(&CliError::Stdout { source }.into(), false),
        },
        Err(error) => fail(&in_flags(error), as_json),
    };
    ExitCode::from(code)
}

/// Writes what the command line itself has to say: help, the version, or wrong usage.
pub(crate) fn told(told: &clap::Error) -> ExitCode {
    let usual = if told.use_stderr() { WRONG_USAGE } else { 0 };
    match quiet_if_closed(told.print().and_then(|()| io::stdout().flush())) {
        Ok(()) => ExitCode::from(usual),
        Err(source) => ExitCode::from(fail(&CliError::Stdout { source }.into(), false)),
    }
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

fn write_results(outcome: &Outcome, as_json: bool) -> io::Result<()> {
    let text = if as_json {
        let mut object = outcome.json.as_object().cloned().unwrap_or_else(Map::new);
        object.insert("warnings".into(), json!(outcome.warnings));
        object.insert("notes".into(), json!(outcome.notes));
        Value::Object(object).to_string() + "\n"
    } else {
        printable(&outcome.text)
    };
    write_stdout(&text)
}

fn write_stdout(text: &str) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    quiet_if_closed(stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()))
}

fn fail(error: &Error, as_json: bool) -> u8 {
    let lines = explanation(error);
    complain("error", "31", &lines.join("\n"));
    if as_json {
        let object = json!({ "error": lines.join("; ") });
        // Ignored: stdout is gone.
        let _ = write_stdout(&(object.to_string() + "\n"));
    }
    match error.downcast_ref() {
        Some(CliError::Usage(_)) => WRONG_USAGE,
        _ if error.downcast_ref().is_some_and(torquewise::Error::is_usage) => WRONG_USAGE,
        _ => FAILED,
    }
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

/// The chain of causes, a line each, and what to do at the end.
///
/// A message of ours ends in what to do. Where a cause from elsewhere (the operating system, a
/// parser) follows it, that last part is moved behind the cause.
fn explanation(error: &Error) -> Vec<String> {
    let mut messages: Vec<String> = error.chain().map(ToString::to_string).collect();
    let last_own = error.chain().enumerate().filter(|(_, cause)| is_own(*cause)).last();
    let mut advice = None;
    if let Some((place, _)) = last_own.filter(|(place, _)| place + 1 < messages.len())
        && let Some(end) = messages[place].rfind(": ")
    {
        advice = Some(format!("  help: {}", &messages[place][end + 2..]));
        messages[place].truncate(end);
    }
    // A transparent error says what its source says.
    messages.dedup();
    let mut lines = Vec::with_capacity(messages.len() + 1);
    for (place, message) in messages.iter().enumerate() {
        let message: Vec<String> = message.trim_end().lines().map(cut).collect();
        let message = message.join("\n    ");
        lines.push(if place == 0 { message } else { format!("  because: {message}") });
    }
    lines.extend(advice);
    lines
}

/// A line as long as people read: what quotes a file may be longer.
fn cut(line: &str) -> String {
    const LONGEST: usize = 400;
    let mut letters = line.chars();
    let mut cut: String = letters.by_ref().take(LONGEST).collect();
    if letters.next().is_some() {
        cut.push('…');
    }
    cut
}

fn is_own(cause: &(dyn std::error::Error + 'static)) -> bool {
    cause.is::<CliError>()
        || cause.is::<torquewise::Error>()
        || cause.is::<LogError>()
        || cause.is::<IdentifyError>()
        || cause.is::<ModelError>()
        || cause.is::<SimError>()
        || cause.is::<MotionError>()
        || cause.is::<SparseError>()
        || cause.is::<ReportError>()
        || cause.is::<ExportError>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::Context;

    #[test]
    fn an_explanation_ends_with_what_to_do() {
        let source = io::Error::from(io::ErrorKind::NotFound);
        let error = Error::from(CliError::Read { file: "a.json".into(), source });

        let lines = explanation(&error);

        let expected = [
            "a.json cannot be read",
            "  because: entity not found",
            "  help: check that it exists and may be read",
        ];
        assert_eq!(lines, expected);
    }

    #[test]
    fn an_error_of_ours_at_the_end_is_left_whole() {
        let error = Err::<(), _>(CliError::OutputIsFolder("out".into())).context("no model");

        let lines = explanation(&error.unwrap_err());

        assert_eq!(lines, ["no model", "  because: out is a folder: name a file in it"]);
    }

    #[test]
    fn e29_a_terminal_shows_control_characters_and_obeys_none() {
        assert_eq!(printable("a\n\tb\u{1b}[31m\0\u{9b}"), "a\n\tb\\u{1b}[31m\\u{0}\\u{9b}");
    }

    #[test]
    fn d26_lines_that_quote_a_file_are_cut() {
        let error = anyhow::anyhow!("a").context("x".repeat(20_000));

        assert!(explanation(&error).iter().all(|line| line.chars().count() < 1_100));
    }

    #[test]
    fn a_reader_that_closed_its_end_is_no_failure() {
        let closed = io::Error::from(io::ErrorKind::BrokenPipe);

        assert!(quiet_if_closed(Err(closed)).is_ok());
        assert!(quiet_if_closed(Err(io::Error::from(io::ErrorKind::StorageFull))).is_err());
    }
}
