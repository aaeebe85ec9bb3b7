//! A model as files for other programs.

use crate::errors::{raised, write_error};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::path::PathBuf;
use torquewise::Model;
use torquewise::export::Precision;
use torquewise::exported::{ExportOptions, Target, export as exported, function_name};
use torquewise::motion::whole_file;

/// What is asked for, as Python says it.
pub(crate) struct Wanted<'a> {
    pub(crate) to: &'a str,
    pub(crate) name: &'a str,
    pub(crate) precision: &'a str,
    pub(crate) reversal: Option<f64>,
    pub(crate) onto: Option<&'a str>,
    pub(crate) lock: Vec<String>,
    pub(crate) binary: bool,
    pub(crate) force: bool,
}

/// Paths and contents, and what is not in them.
pub(crate) type Exported = (Vec<(String, Vec<u8>)>, Vec<String>);

pub(crate) fn export(model: &Model, wanted: &Wanted<'_>) -> PyResult<Exported> {
    let names = || Target::ALL.map(Target::name).join(", ");
    let to = Target::ALL.into_iter().find(|target| target.name() == wanted.to);
    let to = to.ok_or_else(|| {
        PyValueError::new_err(format!(
            "to={:?} is not known: expected one of {}",
            wanted.to,
            names()
        ))
    })?;
    let precision = match wanted.precision {
        "double" => Precision::Double,
        "float" => Precision::Single,
        other => {
            let message = format!("precision={other:?}: expected double or float");
            return Err(PyValueError::new_err(message));
        }
    };
    if wanted.reversal.is_some_and(|width| !(width.is_finite() && width >= 0.0)) {
        return Err(PyValueError::new_err("reversal is 0 or more radians per second"));
    }
    let options = ExportOptions {
        name: &function_name(wanted.name),
        precision,
        reversal: wanted.reversal,
        onto: wanted.onto.map(|text| (text, &wanted.lock[..])),
        binary: wanted.binary,
        force: wanted.force,
        work: None,
    };
    let found = exported(model, to, &options).map_err(raised)?;
    Ok((found.files, found.left_out))
}

/// Writes a file whole or not at all: beside it first, then renamed.
#[pyfunction]
pub(crate) fn write_whole(py: Python<'_>, path: PathBuf, content: &[u8]) -> PyResult<()> {
    py.detach(|| whole_file::write_whole(&path, content))
        .map_err(|error| write_error(&path, &error))
}
