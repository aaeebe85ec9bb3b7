//! Logs summed up apart, merged, and solved for the model that all of them give.

use crate::errors::{LogError, message, raised};
use crate::fit::{Fit, fit_options};
use crate::log::Log;
use crate::work::work;
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyType};
use torquewise::identify::{IdentifyError, Summary as Sums, rounds};
use torquewise::sums::{Solved, solve_sums, sum_up};

/// Sums of logs that add up: picklable, merged in any order, solved for a model.
#[pyclass(module = "torquewise", frozen, subclass)]
#[derive(Clone, Debug)]
pub(crate) struct Summary {
    sums: Sums,
}

/// What a chain asks of another pass over the rows of all logs.
#[pyclass(module = "torquewise", frozen)]
#[derive(Clone, Debug)]
pub(crate) struct Request {
    request: rounds::Request,
}

fn damaged(error: IdentifyError) -> PyErr {
    LogError::new_err(message(&error.into()))
}

#[pymethods]
impl Summary {
    /// The same sums.
    #[new]
    fn new(sums: &Self) -> Self {
        sums.clone()
    }

    /// Sums up a log.
    #[classmethod]
    fn _of(
        _class: &Bound<'_, PyType>,
        py: Python<'_>,
        log: &Log,
        request: Option<&Request>,
        options: Option<&Bound<'_, PyDict>>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let options = fit_options(options, log.log.joints(), 0)?;
        let (log, request) = (log.log.clone(), request.map(|own| own.request.clone()));
        let sums = work(py, progress, move |observer| {
            sum_up(&log, &options, request.as_ref(), observer).map(|(sums, _)| sums)
        })?;
        Ok(Self { sums })
    }

    /// The sums of these logs and others.
    fn merge(&self, other: &Self) -> PyResult<Self> {
        let mut sums = self.sums.clone();
        sums.merge(&other.sums).map_err(raised)?;
        Ok(Self { sums })
    }

    /// The fit of a model, or the request of another pass.
    fn _solve<'py>(
        &self,
        py: Python<'py>,
        options: Option<&Bound<'py, PyDict>>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let seed = self.sums.settings.patterns.seed;
        let options = fit_options(options, self.sums.joints(), seed)?;
        let sums = self.sums.clone();
        let solved = work(py, progress, move |observer| solve_sums(sums, &options, observer))?;
        match solved {
            Solved::Model(found) => Fit::new(py, *found, Vec::new())?.into_bound_py_any(py),
            Solved::Request(request) => Request { request: *request }.into_bound_py_any(py),
        }
    }

    /// Rows summed up.
    #[getter]
    fn rows(&self) -> usize {
        self.sums.rows()
    }

    /// Logs summed up.
    #[getter]
    fn logs(&self) -> usize {
        self.sums.logs
    }

    /// Joint names, base to tip.
    #[getter]
    fn joints(&self) -> Vec<String> {
        self.sums.joints().to_vec()
    }

    /// The bytes of a moments file, with a checksum.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| self.sums.to_bytes()).map_err(raised)?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Sums from such bytes.
    #[classmethod]
    fn from_bytes(_class: &Bound<'_, PyType>, bytes: &[u8]) -> PyResult<Self> {
        Sums::from_bytes(bytes).map(|sums| Self { sums }).map_err(damaged)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Py<PyBytes>,))> {
        let class = py.import("torquewise")?.getattr("Summary")?.getattr("from_bytes")?;
        Ok((class, (self.to_bytes(py)?.unbind(),)))
    }

    fn __repr__(&self) -> String {
        format!("Summary({} rows of {} logs)", self.sums.rows(), self.sums.logs)
    }
}

#[pymethods]
impl Request {
    /// The pass that is asked for, 1 for the first after the survey.
    #[getter]
    fn pass_number(&self) -> usize {
        self.request.pass()
    }

    /// The bytes of a request file.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = self.request.to_bytes().map_err(raised)?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// A request from such bytes.
    #[classmethod]
    fn from_bytes(_class: &Bound<'_, PyType>, bytes: &[u8]) -> PyResult<Self> {
        let request = rounds::Request::from_bytes(bytes).map_err(damaged)?;
        Ok(Self { request })
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Py<PyBytes>,))> {
        let class = py.import("torquewise")?.getattr("Request")?.getattr("from_bytes")?;
        Ok((class, (self.to_bytes(py)?.unbind(),)))
    }

    fn __repr__(&self) -> String {
        format!("Request({})", self.request.name())
    }
}
