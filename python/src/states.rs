//! Quantities of a model at one state, or at each of several.

use crate::arrays::{Rows, same_rows};
use crate::errors::{raised, value_error};
use crate::model::Model;
use faer::Mat;
use numpy::PyArray;
use numpy::ndarray::ArrayD;
use pyo3::prelude::*;
use torquewise::{Torque, model};

pub(crate) type Answer<'py> = PyResult<Bound<'py, PyAny>>;

impl Model {
    /// A quantity at one state, or at each of several.
    ///
    /// - `dimensions`: 1 of n numbers, 2 of a matrix n×n, whose numbers come row by row
    pub(crate) fn each<'py, const K: usize>(
        &self,
        py: Python<'py>,
        inputs: [(&str, &Rows<'py>); K],
        dimensions: usize,
        of: impl Fn(&Torque, [&[f64]; K]) -> Result<Vec<f64>, model::ModelError> + Send + Sync,
    ) -> Answer<'py> {
        let mut shape = vec![self.n(); dimensions];
        let found = if let Some(one) = one_state(&inputs) {
            of(&self.torque, one)
        } else {
            let inputs = same_rows(inputs, self.n())?;
            let rows = inputs.first().map_or(0, Mat::nrows);
            shape.insert(0, rows);
            let at = |row| of(&self.torque, state_of(&inputs, row).each_ref().map(Vec::as_slice));
            py.detach(|| Ok((0..rows).map(at).collect::<Result<Vec<_>, _>>()?.concat()))
        };
        let found = ArrayD::from_shape_vec(shape, found.map_err(raised)?).map_err(value_error)?;
        Ok(PyArray::from_owned_array(py, found).into_any())
    }
}

/// The numbers of a matrix row by row.
pub(crate) fn by_rows(matrix: Mat<f64>) -> Vec<f64> {
    matrix.row_iter().flat_map(|row| row.iter().copied()).collect()
}

/// The numbers of one state, if all inputs are of one.
fn one_state<'a, const K: usize>(inputs: &'a [(&str, &Rows<'_>); K]) -> Option<[&'a [f64]; K]> {
    let mut all = [&[][..]; K];
    for (own, (_, rows)) in all.iter_mut().zip(inputs) {
        let Rows::One(one) = rows else { return None };
        *own = one;
    }
    Some(all)
}

fn state_of<const K: usize>(inputs: &[Mat<f64>; K], row: usize) -> [Vec<f64>; K] {
    inputs.each_ref().map(|values| values.row(row).iter().copied().collect())
}
