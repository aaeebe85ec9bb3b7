//! From logs to a model.

use crate::errors::{UsageError, raised};
use crate::log::{Log, pattern_plan};
use crate::model::{Model, json};
use crate::work::work;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::path::PathBuf;
use std::sync::Arc;
use torquewise::identify::plan::Regression;
use torquewise::log::{Prepared, Rows};
use torquewise::motion::bounded_file;
use torquewise::page::{LogFile, Origin, page};
use torquewise::regression::select::Selector;
use torquewise::regression::select::criterion::Criterion;
use torquewise::regression::select::lasso::Lasso;
use torquewise::regression::select::stlsq::Stlsq;
use torquewise::urdf::known_geometry;
use torquewise::{Fit as Run, FitOptions, FitResult, FrictionKind, Library};

/// A model, how it was found, and how far to trust it; see :func:`torquewise.fit`.
#[pyclass(module = "torquewise", frozen)]
pub(crate) struct Fit {
    found: Arc<FitResult>,
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

/// The value of a keyword of a fit.
fn keyword<'py, T>(options: &Bound<'py, PyDict>, name: &str) -> PyResult<Option<T>>
where
    T: for<'a> FromPyObject<'a, 'py>,
{
    let Some(value) = options.get_item(name)?.filter(|value| !value.is_none()) else {
        return Ok(None);
    };
    options.del_item(name)?;
    let wrong = || PyValueError::new_err(format!("{name}: {value} is not what it takes"));
    value.extract().map(Some).map_err(|_| wrong())
}

/// One of some words.
fn one_of<T>(name: &str, word: Option<String>, all: &[(&str, T)]) -> PyResult<Option<T>>
where
    T: Clone,
{
    let Some(word) = word else { return Ok(None) };
    let found = all.iter().find(|(own, _)| *own == word);
    found.map(|(_, value)| Some(value.clone())).ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(|(own, _)| *own).collect();
        PyValueError::new_err(format!("{name}={word:?}: expected one of {}", names.join(", ")))
    })
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
    let Some(options) = options else {
        return Ok(FitOptions { seed, ..FitOptions::default() });
    };
    let options = &options.copy()?;
    let libraries =
        [("energy", Library::Energy), ("product", Library::Product), ("chain", Library::Chain)];
    let methods = [("stepwise", Regression::Stepwise), ("sindy", Regression::OneShot)];
    let all =
        [FrictionKind::None, FrictionKind::Linear, FrictionKind::Stribeck, FrictionKind::Auto];
    let frictions = all.map(|kind| (kind.name(), kind));
    let selectors = [
        ("bic", Selector::Criterion(Criterion::default())),
        ("lasso", Selector::Lasso(Lasso::default())),
        ("stlsq", Selector::Stlsq(Stlsq::default())),
    ];
    let seed = keyword(options, "seed")?.unwrap_or(seed);
    let activation = keyword::<String>(options, "activation")?;
    let patterns = pattern_plan(
        activation.as_deref().unwrap_or("scaled"),
        keyword(options, "clusters")?,
        seed,
    )?;
    let found = FitOptions {
        library: one_of("library", keyword(options, "library")?, &libraries)?,
        regression: one_of("method", keyword(options, "method")?, &methods)?
            .unwrap_or(Regression::Stepwise),
        friction: one_of("friction", keyword(options, "friction")?, &frictions)?,
        interaction: bounded(options, "interaction", 16)?,
        trig_order: bounded(options, "trig_order", 8)?.and_then(|order| u8::try_from(order).ok()),
        gravity_order: bounded(options, "gravity_order", 8)?
            .and_then(|order| u8::try_from(order).ok()),
        selector: one_of("select", keyword(options, "select")?, &selectors)?,
        threshold: keyword(options, "threshold")?,
        bags: match keyword::<usize>(options, "bags")? {
            Some(bags) if bags > 1_000 => {
                return Err(PyValueError::new_err("bags: expected at most 1000"));
            }
            bags => bags,
        },
        geometry: geometry(options, joints)?,
        counterbalanced: keyword(options, "counterbalance")?.unwrap_or_default(),
        noise_correction: keyword(options, "noise_correction")?.unwrap_or(true),
        patterns,
        seed,
    };
    if found.threshold.is_some_and(|x| !(x >= 0.0 && x.is_finite())) {
        return Err(PyValueError::new_err("threshold: expected a number that is zero or more"));
    }
    refuse_unknown(options)?;
    Ok(found)
}

/// Fails where keywords are left that nothing has taken.
fn refuse_unknown(options: &Bound<'_, PyDict>) -> PyResult<()> {
    let Some((name, _)) = options.iter().find(|(_, value)| !value.is_none()) else {
        return Ok(());
    };
    Err(UsageError::new_err(format!(
        "{name} is no option of a fit: expected library, method, friction, interaction, trig_order, \
         gravity_order, select, threshold, bags, urdf, lock, gravity, counterbalance, \
         noise_correction, activation, clusters or seed"
    )))
}

fn bounded(options: &Bound<'_, PyDict>, name: &str, most: usize) -> PyResult<Option<usize>> {
    match keyword::<usize>(options, name)? {
        Some(own) if !(1..=most).contains(&own) => {
            Err(PyValueError::new_err(format!("{name}: expected a number from 1 to {most}")))
        }
        own => Ok(own),
    }
}

/// Where the axes lie, if a URDF says so.
fn geometry(
    options: &Bound<'_, PyDict>,
    joints: &[String],
) -> PyResult<Option<torquewise::identify::plan::KnownGeometry>> {
    let urdf: Option<PathBuf> = keyword(options, "urdf")?;
    let lock: Option<Vec<String>> = keyword(options, "lock")?;
    let gravity: Option<[f64; 3]> = keyword(options, "gravity")?;
    let Some(file) = urdf else {
        let given = lock.map(|_| "lock").or(gravity.map(|_| "gravity"));
        return match given {
            Some(name) => Err(UsageError::new_err(format!("{name} goes with urdf: give one"))),
            None => Ok(None),
        };
    };
    if gravity.is_some_and(|g| g.iter().all(|x| *x == 0.0) || g.iter().any(|x| !x.is_finite())) {
        return Err(PyValueError::new_err("gravity: expected three numbers, not all 0"));
    }
    let text = bounded_file::read_text(&file)?;
    let known = known_geometry(&text, joints, &lock.unwrap_or_default(), gravity);
    known.map(Some).map_err(|error| {
        PyValueError::new_err(format!(
            "{} does not help: {}",
            file.display(),
            crate::errors::message(&error)
        ))
    })
}

/// Fits the equations of motion to a log.
#[pyfunction]
#[pyo3(signature = (log, options=None, progress=None))]
pub(crate) fn fit(
    py: Python<'_>,
    log: &Log,
    options: Option<&Bound<'_, PyDict>>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Fit> {
    let options = fit_options(options, log.log.joints(), 0)?;
    options.check().map_err(|error| raised(&error))?;
    let own = log.log.clone();
    let found = work(
        py,
        progress,
        Box::new(move |observer| Run::new(&own).options(options).observer(observer).run()),
    )?;
    let files = log.log.files().paths().iter();
    Fit::new(py, found, files.map(|path| path.display().to_string()).collect())
}

#[pymethods]
impl Fit {
    /// `good`, `usable` or `unusable`, from held-out blocks of the log; None if it is not known.
    #[getter]
    fn verdict(&self) -> Option<String> {
        self.found.verdict().map(|verdict| verdict.grade.to_string())
    }

    /// Why, in sentences.
    #[getter]
    fn because(&self) -> Vec<String> {
        self.found.verdict().map(|verdict| verdict.because).unwrap_or_default()
    }

    /// What to know before the model is used, in sentences.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        let own = self.found.warnings.iter().filter(|warning| !warning.is_remark());
        let of_log = self.found.log.iter().flat_map(Prepared::warnings);
        own.map(ToString::to_string).chain(of_log).collect()
    }

    /// What is good to know and changes nothing.
    #[getter]
    fn notes(&self) -> Vec<String> {
        let notes = self.found.warnings.iter().filter(|warning| warning.is_remark());
        notes.map(ToString::to_string).collect()
    }

    /// Time it took [s].
    #[getter]
    fn seconds(&self) -> f64 {
        self.found.seconds
    }

    /// Logs it was fitted to.
    #[getter]
    fn logs(&self) -> Vec<String> {
        self.logs.clone()
    }

    /// All numbers: the JSON of the command line.
    fn _summary(&self) -> PyResult<String> {
        json(&self.found.summary().map_err(|error| raised(&error))?)
    }

    /// The report as one page of HTML.
    ///
    /// - `date`: to be printed
    #[pyo3(signature = (date, test=None, progress=None))]
    fn _report<'py>(
        &self,
        py: Python<'py>,
        date: String,
        test: Option<&Log>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let file = |name: &String| LogFile { name: name.clone(), date: String::new() };
        let logs: Vec<LogFile> = self.logs.iter().map(file).collect();
        let paths = test.map(|test| test.log.files().paths()).into_iter().flatten();
        let tests: Vec<LogFile> = paths.map(|path| file(&path.display().to_string())).collect();
        let (found, test) = (Arc::clone(&self.found), test.map(|test| test.log.clone()));
        let text = work(
            py,
            progress,
            Box::new(move |observer| {
                let known = found.model.training.filter;
                let test = test.map(|test| test.prepare_as(known, Rows::WithRawTorque));
                let origin = Origin {
                    logs: &logs,
                    tests: &tests,
                    model: "model.json",
                    command: "torquewise.fit(…)",
                    version: env!("CARGO_PKG_VERSION"),
                    date: &date,
                };
                page(&found, test.transpose()?.as_ref(), origin, observer)
            }),
        )?;
        Ok(PyBytes::new(py, text.unwrap_or_default().as_bytes()))
    }

    fn __repr__(&self) -> String {
        let verdict = self.found.verdict().map_or_else(String::new, |own| format!("; {own}"));
        format!("Fit({}{verdict})", self.logs.join(", "))
    }
}
