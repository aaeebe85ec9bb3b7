//! From logs to a model.

use crate::errors::{UsageError, message, raised, wrong};
use crate::log::Log;
use crate::model::{Model, json};
use crate::work::work;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use serde_json::Map;
use std::path::PathBuf;
use std::sync::Arc;
use torquewise::evaluate::evaluate_prepared;
use torquewise::motion::bounded_file;
use torquewise::page::{LogFile, Origin, page};
use torquewise::urdf::known_geometry;
use torquewise::{Fit as Run, FitOptions, FitResult, Prepared, Rows};

/// A model, how it was found, and how far to trust it; see :func:`torquewise.fit`.
#[pyclass(module = "torquewise", frozen)]
pub(crate) struct Fit {
    found: Arc<FitResult>,
    /// Logs it was fitted to.
    logs: Vec<String>,
    /// The learned equations of motion.
    #[pyo3(get)]
    model: Py<Model>,
}

impl Fit {
    pub(crate) fn new(py: Python<'_>, found: FitResult, logs: Vec<String>) -> PyResult<Self> {
        let model = Py::new(py, Model::new(found.model.clone()))?;
        Ok(Self { found: Arc::new(found), logs, model })
    }
}

/// The options that keywords say, those of the command line; others are an error.
///
/// - `joints`: of the log
/// - `seed`: unless one is given
pub(crate) fn fit_options(
    options: Option<&Bound<'_, PyDict>>,
    joints: &[String],
    seed: u64,
) -> PyResult<FitOptions> {
    let mut keywords = Map::from_iter([("seed".to_owned(), seed.into())]);
    let Some(given) = options else {
        return FitOptions::of_keywords(&keywords).map_err(raised);
    };
    // Whole numbers of NumPy are none of JSON.
    let whole = PyDict::new(given.py());
    whole.set_item("default", given.py().import("operator")?.getattr("index")?)?;
    let dumps = given.py().import("json")?.getattr("dumps")?;
    for (name, value) in given.iter().filter(|(_, value)| !value.is_none()) {
        let name: String = name.extract()?;
        if ["urdf", "lock", "gravity"].contains(&name.as_str()) {
            continue;
        }
        if FitOptions::keywords().iter().all(|own| own.name != name) {
            return Err(raised(torquewise::Error::NoOption { name }));
        }
        let text = dumps.call((&value,), Some(&whole)).and_then(|own| own.extract::<String>());
        let Ok(text) = text else {
            return wrong(format!("{name}: {} is not what it takes", value.get_type()));
        };
        let Ok(own) = serde_json::from_str(&text) else {
            return wrong(format!("{name}: {} is not what it takes", value.repr()?));
        };
        keywords.insert(name, own);
    }
    let found = FitOptions::of_keywords(&keywords).map_err(raised)?;
    Ok(FitOptions { geometry: geometry(given, joints)?, ..found })
}

/// The options of a fit that are plain values, as JSON: the package lists the same.
#[pyfunction]
pub(crate) fn keywords() -> PyResult<String> {
    json(&FitOptions::keywords())
}

/// The value of a keyword that is not one of JSON.
fn keyword<'py, T>(options: &Bound<'py, PyDict>, name: &str) -> PyResult<Option<T>>
where
    T: for<'a> FromPyObject<'a, 'py>,
{
    let Some(value) = options.get_item(name)?.filter(|value| !value.is_none()) else {
        return Ok(None);
    };
    let found = value.extract().map(Some);
    found.or_else(|_| wrong(format!("{name}: {value} is not what it takes")))
}

fn geometry(
    options: &Bound<'_, PyDict>,
    joints: &[String],
) -> PyResult<Option<torquewise::identify::plan::KnownGeometry>> {
    let urdf: Option<PathBuf> = keyword(options, "urdf")?;
    let lock: Option<Vec<String>> = keyword(options, "lock")?;
    let gravity: Option<[f64; 3]> = keyword(options, "gravity")?;
    let Some(file) = urdf else {
        let alone = lock.map(|_| "lock").or(gravity.map(|_| "gravity"));
        let wanted = |name| Err(UsageError::new_err(format!("{name} goes with urdf: give one")));
        return alone.map_or(Ok(None), wanted);
    };
    if gravity.is_some_and(|g| g.iter().all(|x| *x == 0.0) || g.iter().any(|x| !x.is_finite())) {
        return wrong("gravity: expected three numbers, not all 0");
    }
    let text = bounded_file::read_text(&file)?;
    let known = known_geometry(&text, joints, &lock.unwrap_or_default(), gravity);
    known.map(Some).or_else(|error| {
        let (file, why) = (file.display(), message(&error));
        wrong(format!("cannot match {file} to the joints of the log: {why}"))
    })
}

/// Fits the equations of motion to a log.
#[pyfunction]
pub(crate) fn fit(
    py: Python<'_>,
    log: &Log,
    options: Option<&Bound<'_, PyDict>>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Fit> {
    let options = fit_options(options, log.log.joints(), 0)?;
    options.check().map_err(raised)?;
    let own = log.log.clone();
    let found = work(py, progress, move |observer| {
        Run::new(&own).options(options).observer(observer).run()
    })?;
    Fit::new(py, found, log.files())
}

#[pymethods]
impl Fit {
    /// What is known of it without its rows: all numbers, which are the JSON of the command line,
    /// warnings, notes, and what it is in a line.
    fn _facts(&self) -> PyResult<(String, Vec<String>, Vec<String>, String)> {
        let own = self.found.warnings.iter().filter(|warning| !warning.is_remark());
        let of_log = self.found.log.iter().flat_map(Prepared::warnings);
        let warnings = own.map(ToString::to_string).chain(of_log).collect();
        let words = format!("Fit({}; {})", self.logs.join(", "), self.found.verdict());
        let summary = json(&self.found.summary().map_err(raised)?)?;
        Ok((summary, warnings, self.found.notes(), words))
    }

    /// The report as one page of HTML.
    ///
    /// - `date`: to be printed
    fn _report<'py>(
        &self,
        py: Python<'py>,
        date: String,
        test: Option<&Log>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let file = |name: &String| LogFile { name: name.clone(), date: String::new() };
        let logs: Vec<LogFile> = self.logs.iter().map(file).collect();
        let tests = test.map(Log::files).unwrap_or_default();
        let tests: Vec<LogFile> = tests.iter().map(file).collect();
        let (found, test) = (Arc::clone(&self.found), test.map(|test| test.log.clone()));
        let text = work(py, progress, move |observer| {
            let known = found.model.training.filter;
            let test = test.map(|test| test.prepare_as(known, Rows::WithRawTorque)).transpose()?;
            let scores = test.as_ref().map(|test| evaluate_prepared(&found.model, test, observer));
            let scores = scores.transpose()?;
            let origin = Origin {
                logs: &logs,
                tests: &tests,
                model: "model.json",
                command: "torquewise.fit(…)",
                date: &date,
            };
            page(&found, test.as_ref().zip(scores.as_ref()), origin, observer)
        })?;
        Ok(PyBytes::new(py, text.unwrap_or_default().as_bytes()))
    }
}
