//! From errors of the engine to exceptions of Python.

use pyo3::create_exception;
use pyo3::exceptions::{PyFileNotFoundError, PyKeyboardInterrupt, PyValueError};
use pyo3::prelude::*;
use std::error::Error as StdError;
use std::io::ErrorKind;
use torquewise::Error;
use torquewise::logs::LogError as Logs;

create_exception!(torquewise, TorquewiseError, PyValueError, "What torquewise cannot do, and why.");
create_exception!(torquewise, LogError, TorquewiseError, "A log that cannot be read or used.");
create_exception!(torquewise, ColumnError, LogError, "Columns that a profile is to name.");
create_exception!(torquewise, FitError, TorquewiseError, "A log that no model can be fitted to.");
create_exception!(
    torquewise,
    ModelError,
    TorquewiseError,
    "A model that is none, or another arm's."
);
create_exception!(torquewise, UsageError, TorquewiseError, "Options that contradict each other.");
create_exception!(torquewise, Interrupted, PyKeyboardInterrupt, "Ctrl-C ended the work.");

/// An error of the engine with all that caused it, its options as keywords, and what to do.
pub(crate) fn message(error: &Error) -> String {
    let text = with_causes(error.message(keyword), error.source());
    error.advice(keyword).map_or(text.clone(), |help| format!("{text}\nhelp: {help}"))
}

fn keyword(name: &str, value: Option<&str>) -> String {
    let value = match (name, value) {
        ("force", _) => Some("True".to_owned()),
        ("binary", _) => Some("False".to_owned()),
        (_, value) => value.map(|value| format!("{value:?}")),
    };
    value.map_or_else(|| name.to_owned(), |value| format!("{name}={value}"))
}

fn with_causes(mut text: String, mut cause: Option<&(dyn StdError + 'static)>) -> String {
    while let Some(own) = cause {
        text = format!("{text}: {own}");
        cause = own.source();
    }
    text
}

/// The exception for an error of the engine, or of a part of it.
pub(crate) fn raised(error: impl Into<Error>) -> PyErr {
    let error = error.into();
    let text = message(&error);
    match error {
        Error::Interrupted => Interrupted::new_err(text),
        Error::WrongValue { .. } => PyValueError::new_err(text),
        _ if error.is_usage() => UsageError::new_err(text),
        Error::Log(Logs::Read { source, .. }) if source.kind() == ErrorKind::NotFound => {
            PyFileNotFoundError::new_err(text)
        }
        Error::Log(Logs::NoColumn { .. }) => ColumnError::new_err(text),
        Error::Log(_) | Error::Motion(_) | Error::Read(_) => LogError::new_err(text),
        Error::Model(_) => ModelError::new_err(text),
        _ => FitError::new_err(text),
    }
}

/// Refuses a value of a keyword, or arrays.
pub(crate) fn wrong<T>(message: impl Into<String>) -> PyResult<T> {
    Err(PyValueError::new_err(message.into()))
}

pub(crate) fn choice<T: Copy>(keyword: &str, word: &str, all: &[(&str, T)]) -> PyResult<T> {
    if let Some((_, value)) = all.iter().find(|(own, _)| *own == word) {
        return Ok(*value);
    }
    let names: Vec<&str> = all.iter().map(|(own, _)| *own).collect();
    wrong(format!("{keyword}={word:?}: expected one of {}", names.join(", ")))
}

/// The exception for any other error: a wrong value.
pub(crate) fn value_error(error: impl StdError + 'static) -> PyErr {
    PyValueError::new_err(with_causes(error.to_string(), error.source()))
}
