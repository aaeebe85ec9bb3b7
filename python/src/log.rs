//! Logs of an arm: files of any format, or arrays.

use crate::arrays::{ArrayFrame, Rows as ArrayRows, Shared, array, mat, motion};
use crate::errors::{raised, value_error, wrong};
use crate::model::{self, Model};
use crate::work::work;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use serde_json::json;
use std::path::PathBuf;
use std::sync::Arc;
use torquewise::identify::{find_patterns, survey};
use torquewise::inspect::missing_patterns;
use torquewise::logs::{self, Frame, Logs, Options, Profile};
use torquewise::motion::{Motion, Recording};
use torquewise::{Filter, FitOptions, Rows};

/// Logs of one arm; see :func:`torquewise.read_log`.
#[pyclass(module = "torquewise", frozen, subclass)]
#[derive(Clone, Debug)]
pub(crate) struct Log {
    pub(crate) log: torquewise::Log,
}

/// Files, or frames with their labels.
#[derive(FromPyObject)]
pub(crate) enum Sources {
    /// Paths of files, or of folders of bags.
    Files(Vec<PathBuf>),
    Frames(Vec<(String, Py<ArrayFrame>)>),
}

/// `auto`, `none` or a cut-off [Hz].
#[derive(FromPyObject)]
pub(crate) enum FilterWord {
    Hz(f64),
    Word(String),
}

#[pymethods]
impl Log {
    #[new]
    #[pyo3(signature = (sources, *, profile=None, topic=None, repair=false, filter=None, delay=None))]
    fn new(
        py: Python<'_>,
        sources: Sources,
        profile: Option<PathBuf>,
        topic: Option<String>,
        repair: bool,
        filter: Option<FilterWord>,
        delay: Option<f64>,
    ) -> PyResult<Self> {
        let profile = profile.map(|file| Profile::read(&file)).transpose().map_err(raised)?;
        let options = Options { profile, topic, repair };
        let files = match sources {
            Sources::Files(files) => py.detach(|| Logs::open_with(&files, &options)),
            Sources::Frames(frames) => {
                let frame = |(label, frame)| -> (PathBuf, Arc<dyn Frame>) {
                    (PathBuf::from(label), Arc::new(Shared(frame)))
                };
                let frames: Vec<_> = frames.into_iter().map(frame).collect();
                py.detach(|| Logs::of_frames(&frames, &options))
            }
        };
        let mut log = torquewise::Log::from(files.map_err(raised)?);
        log.filter = match filter {
            None => Filter::Auto,
            Some(FilterWord::Word(word)) if word == "auto" => Filter::Auto,
            Some(FilterWord::Word(word)) if word == "none" => Filter::None,
            Some(FilterWord::Hz(hz)) if hz.is_finite() && hz > 0.0 => Filter::Hz(hz),
            _ => return wrong("filter: expected \"auto\", \"none\" or a cut-off above 0 Hz"),
        };
        if delay.is_some_and(|delay| delay.is_nan() || delay.abs() > 1.0) {
            return wrong("delay: expected seconds within ±1");
        }
        log.delay = delay;
        Ok(Self { log })
    }

    /// Joint names, base to tip.
    #[getter]
    fn joints(&self) -> Vec<String> {
        self.log.joints().to_vec()
    }

    /// Files or labels, as given.
    #[getter]
    pub(crate) fn files(&self) -> Vec<String> {
        self.log.files.paths().iter().map(|path| path.display().to_string()).collect()
    }

    /// Whether all files hold torque.
    #[getter]
    fn has_torque(&self) -> bool {
        self.log.files.has_tau()
    }

    /// Whether its signals are filtered before anything is fitted to them.
    #[getter]
    fn is_filtered(&self) -> bool {
        self.log.is_filtered()
    }

    /// Its trajectories: a list of dicts with t [s] (m), and q [rad], dq, ddq and tau [N·m] (m×n).
    ///
    /// - `conditioned`: filtered at eight times the band of the motion and thinned; else as recorded,
    ///   every row, missing dq and ddq by differences
    /// - `model`: filtered as its own log was, the ends left out where the filter has not settled;
    ///   `conditioned` too, as its fit saw them
    #[pyo3(signature = (conditioned=false, model=None))]
    fn trajectories<'py>(
        &self,
        py: Python<'py>,
        conditioned: bool,
        model: Option<&Model>,
    ) -> PyResult<Bound<'py, PyList>> {
        let log = self.log.clone();
        let known = model.map(|model| Arc::clone(&model.model));
        let blocks = work(py, None, move |observer| {
            if !conditioned && known.is_none() {
                return Ok(log.files.read_all()?);
            }
            let wanted = if conditioned { Rows::Filtered } else { Rows::Settled };
            let rows = match known {
                Some(model) => log.prepare_as(model.training.filter, wanted)?,
                None => log.prepare(Rows::Filtered)?,
            };
            Ok(rows.watched(observer, "reading").trajectories()?)
        })?;
        let dicts = blocks.iter().map(|motion| motion_dict(py, motion));
        PyList::new(py, dicts.collect::<PyResult<Vec<_>>>()?)
    }

    fn __repr__(&self) -> String {
        format!("Log({}; {} joints)", self.files().join(", "), self.log.joints().len())
    }
}

pub(crate) fn motion_dict<'py>(py: Python<'py>, motion: &Motion) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("t", PyArray1::from_slice(py, motion.t()))?;
    let signals = [("q", motion.q()), ("dq", motion.dq()), ("ddq", motion.ddq())];
    for (name, values) in signals.into_iter().chain(motion.tau().map(|tau| ("tau", tau))) {
        dict.set_item(name, array(py, values))?;
    }
    Ok(dict)
}

/// Writes a `.csv` or `.parquet` log, whole or not at all.
#[pyfunction]
pub(crate) fn write_log(
    path: PathBuf,
    joints: Vec<String>,
    t: Vec<f64>,
    q: ArrayRows<'_>,
    dq: ArrayRows<'_>,
    ddq: ArrayRows<'_>,
    tau: Option<ArrayRows<'_>>,
) -> PyResult<()> {
    let signals = [&q, &dq, &ddq].map(|own| mat(own.view()));
    let motion = motion(&joints, t, signals, tau.as_ref().map(|own| mat(own.view())))?;
    logs::write_motion(&path, &motion).map_err(raised)
}

/// What a log holds and what it lacks: JSON, and warnings.
#[pyfunction]
pub(crate) fn inspect(
    py: Python<'_>,
    log: &Log,
    model: Option<&Model>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<(String, Vec<String>)> {
    let log = log.log.clone();
    let filter = model.map(|model| model.model.training.filter);
    let (found, warnings): (_, Vec<String>) = work(py, progress, move |observer| {
        let rows = match filter {
            Some(filter) => log.prepare_as(filter, Rows::Filtered)?,
            None => log.prepare(Rows::Filtered)?,
        };
        let found = torquewise::inspect::inspect(&rows, observer)?;
        let warnings = found.warnings().into_iter().chain(rows.warnings()).collect();
        Ok((found, warnings))
    })?;
    Ok((model::json(&found)?, warnings))
}

/// The profile that the columns of a log, and of files beside it, ask for: TOML, reasons, and whether it is complete.
#[pyfunction]
pub(crate) fn suggest(files: Vec<PathBuf>) -> PyResult<(String, Vec<String>, bool)> {
    let found = logs::suggest(&files.iter().map(Into::into).collect::<Vec<_>>()).map_err(raised)?;
    Ok((found.toml, found.reasons, found.is_complete))
}

/// The pattern of each row, of 0 standstill, 1 uniform, 2 variable; inertia of 1, 2, … clusters; and
/// warnings.
#[pyfunction]
#[expect(clippy::type_complexity, reason = "a tuple for Python")]
pub(crate) fn patterns<'py>(
    py: Python<'py>,
    log: &Log,
    activation: &str,
    clusters: Option<usize>,
    seed: u64,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<(Bound<'py, PyArray1<u8>>, Vec<f64>, Vec<String>)> {
    let keywords = json!({ "activation": activation, "clusters": clusters, "seed": seed });
    let options = serde_json::from_value(keywords).map_err(value_error)?;
    let plan = FitOptions::of_keywords(&options).map_err(raised)?.patterns();
    let log = log.log.clone();
    let (labels, found) = work(py, progress, move |observer| {
        let rows = log.prepare(Rows::Every)?;
        let watched = rows.watched(observer, "looking through the log");
        let found = find_patterns(&survey(&watched)?, &plan)?;
        let mut labels: Vec<u8> = Vec::new();
        watched.read(&mut |_, block| {
            labels.extend(found.label(block).into_iter().map(|own| own as u8));
            Ok(())
        })?;
        Ok((labels, found))
    })?;
    let warnings = missing_patterns(&found.present).into_iter().collect();
    Ok((PyArray1::from_vec(py, labels), found.inertia.clone(), warnings))
}
