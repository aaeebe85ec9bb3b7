//! Between arrays of NumPy and the engine.

use crate::errors::{value_error, wrong};
use faer::{Mat, MatRef};
use numpy::ndarray::{Array2, Array3, ArrayView1, ArrayView2, Axis, Slice};
use numpy::{
    AllowTypeChange, PyArray1, PyArray2, PyArray3, PyArrayLike1, PyArrayLike2, PyArrayMethods,
    PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use torquewise::logs;
use torquewise::motion::{Motion, Signals};

/// Columns of arrays that are read as a log: no copy is made of them.
#[pyclass(module = "torquewise._core", frozen)]
#[derive(Debug)]
pub(crate) struct ArrayFrame {
    names: Vec<String>,
    joints: Option<Vec<String>>,
    n_rows: usize,
    /// Of each column its parts, with the row that each ends before.
    columns: Vec<Vec<(usize, Py<PyArray1<f64>>)>>,
}

#[pymethods]
impl ArrayFrame {
    /// Columns by name: each one or several arrays of float64, one after the other.
    #[new]
    #[pyo3(signature = (columns, joints=None))]
    fn new(
        py: Python<'_>,
        columns: Vec<(String, Vec<Py<PyArray1<f64>>>)>,
        joints: Option<Vec<String>>,
    ) -> PyResult<Self> {
        let (names, parts): (Vec<String>, Vec<_>) = columns.into_iter().unzip();
        let ends = |parts: Vec<Py<PyArray1<f64>>>| -> Vec<(usize, Py<PyArray1<f64>>)> {
            let mut end = 0;
            let with_end = |part: Py<PyArray1<f64>>| {
                end += part.bind(py).len();
                (end, part)
            };
            parts.into_iter().map(with_end).collect()
        };
        let columns: Vec<_> = parts.into_iter().map(ends).collect();
        let rows = |column: &Vec<(usize, _)>| column.last().map_or(0, |(end, _)| *end);
        let n_rows = columns.first().map_or(0, rows);
        if let Some(k) = columns.iter().position(|column| rows(column) != n_rows) {
            let (name, other, first) = (&names[k], rows(&columns[k]), &names[0]);
            return wrong(format!(
                "{name} has {other} rows, {first} has {n_rows}: give columns of one length"
            ));
        }
        Ok(Self { names, joints, n_rows, columns })
    }
}

/// A frame in hand of the engine.
#[derive(Debug)]
pub(crate) struct Shared(pub(crate) Py<ArrayFrame>);

impl logs::Frame for Shared {
    fn names(&self) -> &[String] {
        &self.0.get().names
    }

    fn joints(&self) -> Option<&[String]> {
        self.0.get().joints.as_deref()
    }

    fn n_rows(&self) -> usize {
        self.0.get().n_rows
    }

    fn read(&self, column: usize, first: usize, values: &mut [f64]) -> Result<(), String> {
        let last = first + values.len();
        let mut begin = 0;
        for (end, part) in &self.0.get().columns[column] {
            let (from, to) = (first.max(begin), last.min(*end));
            if from < to {
                Python::attach(|py| {
                    let part = part.bind(py).try_readonly().map_err(|error| error.to_string())?;
                    let array = part.as_array();
                    if array.len() != end - begin {
                        return Err("its length has changed".to_owned());
                    }
                    let own = array.slice_axis(Axis(0), Slice::from(from - begin..to - begin));
                    values[from - first..to - first].iter_mut().zip(own).for_each(|(v, x)| *v = *x);
                    Ok(())
                })?;
            }
            begin = *end;
        }
        Ok(())
    }
}

/// One state, or rows of states.
pub(crate) enum Rows<'py> {
    /// n numbers.
    One(Vec<f64>),
    /// m×n numbers.
    Many(PyArrayLike2<'py, f64, AllowTypeChange>),
}

impl<'py> FromPyObject<'_, 'py> for Rows<'py> {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        // What a controller gives a thousand times a second.
        if let Ok(one) = object.cast::<PyArray1<f64>>()
            && let Ok(numbers) = one.to_vec()
        {
            return Ok(Self::One(numbers));
        }
        if let Ok(one) = object.extract::<PyArrayLike1<'_, f64, AllowTypeChange>>() {
            return Ok(Self::One(one.as_array().iter().copied().collect()));
        }
        object.extract().map(Self::Many).or_else(|_| {
            wrong(
                "expected numbers of one state, one for each joint, or of several states in rows, \
                 one column for each joint",
            )
        })
    }
}

impl Rows<'_> {
    /// The rows, one where there is one state.
    pub(crate) fn view(&self) -> ArrayView2<'_, f64> {
        match self {
            Self::One(one) => ArrayView1::from(one).insert_axis(Axis(0)),
            Self::Many(many) => many.as_array(),
        }
    }
}

pub(crate) fn mat(view: ArrayView2<'_, f64>) -> Mat<f64> {
    Mat::from_fn(view.nrows(), view.ncols(), |row, column| view[(row, column)])
}

pub(crate) fn array<'py>(py: Python<'py>, mat: MatRef<'_, f64>) -> Bound<'py, PyArray2<f64>> {
    let values = Array2::from_shape_fn((mat.nrows(), mat.ncols()), |(i, j)| mat[(i, j)]);
    PyArray2::from_owned_array(py, values)
}

pub(crate) fn matrices<'py>(
    py: Python<'py>,
    all: &[Mat<f64>],
    n: usize,
) -> Bound<'py, PyArray3<f64>> {
    let shape = (all.len(), n, n);
    let values = Array3::from_shape_fn(shape, |(row, i, j)| all[row][(i, j)]);
    PyArray3::from_owned_array(py, values)
}

pub(crate) fn motion(
    joints: &[String],
    t: Option<Vec<f64>>,
    [q, dq, ddq]: [ArrayView2<'_, f64>; 3],
    tau: Option<ArrayView2<'_, f64>>,
) -> PyResult<Motion> {
    let signals = Signals {
        joints: joints.to_vec(),
        t: t.unwrap_or_else(|| (0..q.nrows()).map(|row| row as f64).collect()),
        q: mat(q),
        dq: mat(dq),
        ddq: mat(ddq),
        tau: tau.map(mat),
    };
    Motion::new(signals).map_err(value_error)
}

pub(crate) fn check_columns(name: &str, view: &ArrayView2<'_, f64>, n: usize) -> PyResult<()> {
    match view.ncols() {
        own if own == n => Ok(()),
        own => wrong(format!(
            "{name} has {own} columns, the model has {n} joints: give one column for each joint"
        )),
    }
}
