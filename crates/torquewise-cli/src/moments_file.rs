//! From moments file to summary and back, and what is said of it.

use crate::error::{CliError, Result};
use crate::files::{read_bytes, write_whole};
use serde_json::{Value, json};
use std::path::Path;
use torquewise::identify::Summary;
use torquewise::identify::rounds::Request;

pub(crate) fn read_moments(file: &Path) -> Result<Summary> {
    let bytes = read_bytes(file)?;
    let what = || format!("{} is not a moments file", file.display());
    Summary::from_bytes(&bytes).map_err(|error| CliError::from(error).within(what()))
}

pub(crate) fn read_request(file: &Path) -> Result<Request> {
    let bytes = read_bytes(file)?;
    let what = || format!("{} is not a request file", file.display());
    Request::from_bytes(&bytes).map_err(|error| CliError::from(error).within(what()))
}

/// Writes a moments file; returns its size in bytes.
pub(crate) fn write_moments(file: &Path, summary: &Summary) -> Result<usize> {
    let bytes = summary.to_bytes()?;
    write_whole(file, &bytes)?;
    Ok(bytes.len())
}

pub(crate) fn text(summary: &Summary, file: &Path, bytes: usize) -> String {
    format!(
        "{} rows of {} logs{}\nmoments: {} ({:.1} MB)\n",
        summary.rows(),
        summary.logs(),
        summary.request().map_or_else(String::new, |request| format!(", {}", request.name())),
        file.display(),
        bytes as f64 / 1e6
    )
}

pub(crate) fn json(summary: &Summary, file: &Path, bytes: usize) -> Value {
    let settings = summary.settings();
    json!({
        "rows": summary.rows(),
        "logs": summary.logs(),
        "joints": settings.joints,
        "settings": settings,
        "request": summary.request().map(Request::name),
        "bytes": bytes,
        "file": file.display().to_string(),
    })
}
