//! Moments files read and written.

use crate::files::read_bytes;
use crate::{CliError, Outcome, Result, write_whole};
use serde_json::json;
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

pub(crate) fn write_moments(file: &Path, summary: &Summary) -> Result<Outcome> {
    let bytes = summary.to_bytes()?;
    write_whole(file, &bytes)?;
    let settings = &summary.settings;
    let (rows, logs, request) = (summary.rows(), summary.logs, summary.request());
    let next = request.map_or_else(String::new, |request| format!(", {}", request.name()));
    let text = format!(
        "{rows} rows of {logs} logs{next}\nmoments: {} ({:.1} MB)\n",
        file.display(),
        bytes.len() as f64 / 1e6
    );
    let json = json!({
        "rows": rows,
        "logs": logs,
        "joints": settings.joints,
        "settings": settings,
        "request": request.map(Request::name),
        "bytes": bytes.len(),
        "file": file.display().to_string(),
    });
    Ok(Outcome { text, json, ..Outcome::default() })
}
