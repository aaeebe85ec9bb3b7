//! Between arrays of NumPy and the engine.

use crate::errors::{value_error, wrong};
use faer::{Mat, MatRef};
use numpy::ndarray::{Array2, ArrayView1, ArrayView2, Axis, Slice};
use numpy::{
    PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::intern;
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
    Many(PyReadonlyArray2<'py, f64>),
}

impl<'py> FromPyObject<'_, 'py> for Rows<'py> {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        // What a controller gives a thousand times a second.
        if object.is_exact_instance_of::<PyUntypedArray>()
            && let Ok(one) = object.cast::<PyArray1<f64>>()
            && let Ok(numbers) = one.to_vec()
        {
            return Self::One(numbers).finite();
        }
        let py = object.py();
        let arrays = py.import(intern!(py, "torquewise._arrays"))?;
        let found = arrays.call_method1(intern!(py, "states"), (object,))?;
        match found.cast::<PyArray1<f64>>() {
            Ok(one) => Self::One(one.readonly().as_array().to_vec()).finite(),
            Err(_) => Self::Many(found.cast::<PyArray2<f64>>()?.try_readonly()?).finite(),
        }
    }
}

impl Rows<'_> {
    fn finite(self) -> PyResult<Self> {
        let view = self.view();
        let wanted = view.iter().all(|value| value.is_finite());
        let wrong_one = || view.indexed_iter().find(|(_, value)| !value.is_finite());
        match (!wanted).then(wrong_one).flatten() {
            Some(((row, joint), value)) => wrong(format!(
                "the value of joint {} in row {row} is {value}: expected finite numbers, fill it or \
                 leave the state out",
                joint + 1
            )),
            None => Ok(self),
        }
    }

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

/// Where rows of states are wanted, a single one stands for all.
pub(crate) fn same_rows<const K: usize>(
    inputs: [(&str, &Rows<'_>); K],
    n: usize,
) -> PyResult<[Mat<f64>; K]> {
    let (mut first, mut rows) = ("", 1);
    for (name, own) in &inputs {
        let view = own.view();
        check_columns(name, &view, n)?;
        match view.nrows() {
            1 => {}
            many if rows == 1 => (first, rows) = (name, many),
            many if many != rows => {
                return wrong(format!(
                    "{name} has {many} rows, {first} has {rows}: give as many states of each, or one"
                ));
            }
            _ => {}
        }
    }
    Ok(inputs.map(|(_, own)| {
        let view = own.view();
        let last = view.nrows().saturating_sub(1);
        Mat::from_fn(rows, n, |row, joint| view[(row.min(last), joint)])
    }))
}

pub(crate) fn motion(
    joints: &[String],
    t: Vec<f64>,
    [q, dq, ddq]: [Mat<f64>; 3],
    tau: Option<Mat<f64>>,
) -> PyResult<Motion> {
    let signals = Signals { joints: joints.to_vec(), t, q, dq, ddq, tau };
    Motion::new(signals).map_err(value_error)
}

/// Whether each of some inputs is of one state.
pub(crate) fn is_one_state<const K: usize>(inputs: [&Rows<'_>; K]) -> bool {
    inputs.iter().all(|own| matches!(own, Rows::One(_)))
}

/// Rows of a result: n numbers where all inputs were of one state.
pub(crate) fn rows_of<'py, const K: usize>(
    py: Python<'py>,
    mat: MatRef<'_, f64>,
    inputs: [&Rows<'_>; K],
) -> Bound<'py, PyAny> {
    if is_one_state(inputs) {
        return PyArray1::from_iter(py, mat.row(0).iter().copied()).into_any();
    }
    array(py, mat).into_any()
}

pub(crate) fn check_columns(name: &str, view: &ArrayView2<'_, f64>, n: usize) -> PyResult<()> {
    match view.ncols() {
        own if own == n => Ok(()),
        own => wrong(format!(
            "{name} has {own} columns, the model has {n} joints: give one column for each joint"
        )),
    }
}
