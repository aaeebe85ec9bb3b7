//! From errors of the engine to exceptions of Python.

use pyo3::create_exception;
use pyo3::exceptions::{
    PyException, PyFileNotFoundError, PyKeyboardInterrupt, PyOSError, PyValueError,
};
use pyo3::prelude::*;
use std::error::Error as StdError;
use std::io::ErrorKind;
use torquewise::Error;
use torquewise::identify::IdentifyError;
use torquewise::logs::LogError as Logs;
use torquewise::motion::ReadError;

create_exception!(torquewise, TorquewiseError, PyException, "What torquewise cannot do, and why.");
create_exception!(torquewise, LogError, TorquewiseError, "A log that cannot be read or used.");
create_exception!(torquewise, FitError, TorquewiseError, "A log that no model can be fitted to.");
create_exception!(
    torquewise,
    ModelError,
    TorquewiseError,
    "A model that is none, or another arm's."
);
create_exception!(torquewise, UsageError, TorquewiseError, "Options that contradict each other.");
create_exception!(torquewise, Interrupted, PyKeyboardInterrupt, "Ctrl-C ended the work.");

/// An error with all that caused it, in one line.
pub(crate) fn message(error: &(dyn StdError + 'static)) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(own) = cause {
        let own_text = own.to_string();
        if !text.contains(&own_text) {
            text = format!("{text}: {own_text}");
        }
        cause = own.source();
    }
    text
}

/// The exception for an error of the engine.
pub(crate) fn raised(error: &Error) -> PyErr {
    let text = message(error);
    match error {
        Error::Interrupted => Interrupted::new_err(text),
        _ if error.is_usage() => UsageError::new_err(text),
        Error::Log(Logs::Read { source, .. }) if source.kind() == ErrorKind::NotFound => {
            PyFileNotFoundError::new_err(text)
        }
        Error::Log(_) => LogError::new_err(text),
        Error::Model(_) => ModelError::new_err(text),
        Error::Read(source) | Error::Identify(IdentifyError::Read(source)) => read(source, text),
        _ => FitError::new_err(text),
    }
}

/// The exception for what a reader met: an error of the log, or one that was handed through it.
fn read(source: &ReadError, text: String) -> PyErr {
    if let Some(own) = source.downcast_ref::<Error>() {
        return raised(own);
    }
    match source.downcast_ref::<IdentifyError>() {
        Some(IdentifyError::Read(inner)) => read(inner, text),
        Some(_) => FitError::new_err(text),
        None => LogError::new_err(text),
    }
}

/// The exception for any other error: a wrong value.
pub(crate) fn value_error(error: impl StdError + 'static) -> PyErr {
    PyValueError::new_err(message(&error))
}

/// The exception for a model that does not fit what it is asked.
pub(crate) fn model_error(error: impl StdError + 'static) -> PyErr {
    ModelError::new_err(message(&error))
}

/// The exception for a file that cannot be written.
pub(crate) fn write_error(file: &std::path::Path, error: &std::io::Error) -> PyErr {
    PyOSError::new_err(format!("{} cannot be written: {error}", file.display()))
}
