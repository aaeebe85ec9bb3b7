//! From a request to its answer.

use crate::examples::csv;
use crate::fitted::fitted;
use crate::request::{FileAt, LogAt, Question};
use serde_json::{Value, json};
use torquewise::evaluate::{evaluate_prepared, prepare};
use torquewise::exported::{ExportOptions, Target, export, function_name};
use torquewise::inspect::inspect;
use torquewise::logs::{LogError, LogInput, Logs, Options, Profile, preview, suggest};
use torquewise::model::from_json;
use torquewise::{Diagnostic, Error, Filter, Fit, FitOptions, Log, Observer, Rows};

/// Rows of a column that are shown before anything is fitted.
const PREVIEW_ROWS: usize = 2_000;

/// What the page is told: an object, and the bytes of a file where it asked for one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answer {
    /// Either what was asked for, or `problem` with a `message` and the `help` for it.
    pub json: Value,
    /// The content of a file.
    pub content: Vec<u8>,
}

/// The bytes that the page holds of a file.
pub type Held<'a> = &'a dyn Fn(&FileAt) -> LogInput;

/// Answers a request.
pub fn answer(request: &str, held: Held<'_>, observer: Observer<'_>) -> Answer {
    let request = match serde_json::from_str(request) {
        Ok(request) => request,
        Err(error) => return problem(&error.to_string(), Some("reload the page")),
    };
    answered(request, held, observer).unwrap_or_else(|error| refusal(&error))
}

fn refusal(error: &Error) -> Answer {
    problem(&error.to_string(), error.help().map(|help| help.to_string()).as_deref())
}

fn problem(message: &str, help: Option<&str>) -> Answer {
    Answer::of(json!({ "problem": { "message": message, "help": help } }))
}

impl Answer {
    fn of(json: Value) -> Self {
        Self { json, content: Vec::new() }
    }
}

fn answered(request: Question, held: Held<'_>, observer: Observer<'_>) -> Result<Answer, Error> {
    match request {
        Question::Open(log) => open(&log, held, observer).map(Answer::of),
        Question::Fit { log, options, date } => {
            let options = FitOptions::of_keywords(&options)?;
            options.check()?;
            let names: Vec<String> = log.files.iter().map(|file| file.name.clone()).collect();
            let fit = Fit::new(&log.open(held)?).options(options).observer(observer).run()?;
            fitted(&fit, &names, &date, observer).map(Answer::of)
        }
        Question::Evaluate { model, log } => {
            let model = from_json(&model)?;
            let log = prepare(&model, &log.open(held)?)?;
            let evaluation = evaluate_prepared(&model, &log, observer)?;
            let warnings: Vec<String> =
                evaluation.warnings.iter().cloned().chain(log.warnings()).collect();
            Ok(Answer::of(json!({
                "scores": evaluation, "warnings": warnings, "notes": evaluation.notes,
            })))
        }
        Question::Export { model, to, name, force } => exported(&model, &to, &name, force),
        Question::Example { name } => {
            let csv = csv(&name)?.ok_or_else(|| unknown("example", &name))?;
            let json = json!({ "name": format!("{name}.csv") });
            Ok(Answer { json, content: csv.into_bytes() })
        }
    }
}

impl LogAt {
    fn inputs(&self, held: Held<'_>) -> Vec<LogInput> {
        self.files.iter().map(held).collect()
    }

    fn open(&self, held: Held<'_>) -> Result<Log, Error> {
        // A profile is checked where it is read from text.
        let profile = self.profile.as_ref().map(|own| Profile::from_toml(&own.to_toml()));
        let options = Options { profile: profile.transpose()?, ..Options::default() };
        let filter = self.cutoff.map_or(Filter::Auto, Filter::Hz);
        Ok(Log { filter, ..Log::from(Logs::of_inputs(&self.inputs(held), &options)?) })
    }
}

/// What a log holds: its columns, a profile to begin with, and what a fit would suffer from, or why
/// it cannot be read with the profile at hand.
fn open(log: &LogAt, held: Held<'_>, observer: Observer<'_>) -> Result<Value, Error> {
    let inputs = log.inputs(held);
    let first = inputs.first().ok_or(LogError::NoFiles)?;
    let columns = preview(first, PREVIEW_ROWS)?;
    let mut found = json!({ "columns": columns, "options": FitOptions::keywords() });
    if log.profile.is_none() {
        let suggestion = suggest(std::slice::from_ref(first))?;
        found["suggestion"] = json!({
            "profile": Profile::from_toml(&suggestion.toml)?,
            "reasons": suggestion.reasons,
            "is_complete": suggestion.is_complete,
        });
    }
    let looked = log.open(held).and_then(|own| {
        let recorded = own.prepare(Rows::Filtered)?;
        let inspection = inspect(&recorded, observer)?;
        let warnings: Vec<String> =
            inspection.warnings().into_iter().chain(recorded.warnings()).collect();
        Ok(json!({
            "found": inspection, "warnings": warnings, "is_filtered": own.is_filtered(),
            "profile": log.profile.as_ref().map(Profile::to_toml),
        }))
    });
    match looked {
        Ok(log) => found["log"] = log,
        Err(Error::Interrupted) => return Err(Error::Interrupted),
        Err(error) => {
            found["refused"] = refusal(&error).json["problem"].take();
            let unnamed = matches!(error, Error::Log(LogError::NoColumn { .. }));
            found["refused"]["is_unnamed"] = unnamed.into();
        }
    }
    Ok(found)
}

fn exported(model: &str, to: &str, name: &str, force: bool) -> Result<Answer, Error> {
    let target = Target::NAMED.into_iter().find(|(named, _, _)| *named == to);
    let (_, _, target) = target.ok_or_else(|| unknown("export", to))?;
    let name = function_name(name);
    // There is no compiler in a page: a unit holds sources.
    let options = ExportOptions { binary: false, force, ..ExportOptions::named(&name) };
    let made = export(&from_json(model)?, target, &options)?;
    let ending = target.endings().first().ok_or_else(|| unknown("export", to))?;
    let content = made.files.into_iter().next().map(|(_, content)| content).unwrap_or_default();
    let json = json!({ "name": format!("{name}.{ending}"), "left_out": made.left_out });
    Ok(Answer { json, content })
}

fn unknown(what: &'static str, name: &str) -> Error {
    Error::WrongValue { setting: what, reason: format!("there is no {name}") }
}
