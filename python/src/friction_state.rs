//! What friction remembers of a path, sample by sample.

use crate::arrays::{Rows, check_columns};
use crate::errors::{raised, wrong};
use crate::model::Model;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::sync::Arc;
use torquewise::Torque;
use torquewise::motion::path::Path;

/// What friction remembers of the path: give :meth:`step` every sample of q.
#[pyclass(module = "torquewise")]
#[derive(Debug)]
pub(crate) struct FrictionState {
    pub(crate) model: Py<Model>,
    pub(crate) n: usize,
    pub(crate) torque: Arc<Torque>,
    pub(crate) path: Path,
}

#[pymethods]
impl FrictionState {
    /// Forgets the path.
    fn reset(&mut self) {
        self.path.reset();
    }

    /// Takes the next sample of q [rad], n.
    fn step(&mut self, q: Rows<'_>) -> PyResult<()> {
        let view = q.view();
        check_columns("q", &view, self.n)?;
        for row in view.rows() {
            self.path.step(&row.iter().copied().collect::<Vec<f64>>());
        }
        Ok(())
    }

    /// tau [N·m] at the last sample, n.
    fn torque<'py>(
        &self,
        py: Python<'py>,
        dq: Rows<'py>,
        ddq: Rows<'py>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (dq, ddq) = (self.one("dq", &dq)?, self.one("ddq", &ddq)?);
        let tau = self.torque.after(&self.path, &dq, &ddq).map_err(raised)?;
        Ok(PyArray1::from_vec(py, tau))
    }

    /// F [N·m] at the last sample, n.
    fn friction<'py>(&self, py: Python<'py>, dq: Rows<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let dq = self.one("dq", &dq)?;
        let tau = self.torque.friction_after(&self.path, &dq).map_err(raised)?;
        Ok(PyArray1::from_vec(py, tau))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let make = py.import("operator")?.getattr("methodcaller")?.call1(("state",))?;
        let path = (self.path.q().to_vec(), self.path.states().to_vec());
        (make, (&self.model,), path).into_pyobject(py)
    }

    fn __setstate__(&mut self, path: (Vec<f64>, Vec<f64>)) -> PyResult<()> {
        let (q, states) = path;
        if states.len() != self.path.states().len() || !q.is_empty() && q.len() != self.n {
            return wrong("the state is not of this model");
        }
        self.path.resume(q, states);
        Ok(())
    }
}

impl FrictionState {
    fn one(&self, name: &str, rows: &Rows<'_>) -> PyResult<Vec<f64>> {
        if self.path.q().len() != self.n {
            return wrong("give step() a sample of q first");
        }
        match rows {
            Rows::One(one) => Ok(one.clone()),
            Rows::Many(_) => wrong(format!("{name} is one state")),
        }
    }
}
