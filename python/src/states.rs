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
    /// A quantity of n numbers at one state, or at each of several.
    pub(crate) fn at_each<'py, const K: usize>(
        &self,
        py: Python<'py>,
        inputs: [(&str, &Rows<'py>); K],
        of: impl Fn(&Torque, [&[f64]; K]) -> Result<Vec<f64>, model::ModelError> + Send + Sync,
    ) -> Answer<'py> {
        self.each(py, inputs, vec![self.n()], of)
    }

    /// The same of a matrix, n×n.
    pub(crate) fn matrix_at_each<'py, const K: usize>(
        &self,
        py: Python<'py>,
        inputs: [(&str, &Rows<'py>); K],
        of: impl Fn(&Torque, [&[f64]; K]) -> Result<Mat<f64>, model::ModelError> + Send + Sync,
    ) -> Answer<'py> {
        let by_rows = |torque: &Torque, state: [&[f64]; K]| {
            Ok(of(torque, state)?.row_iter().flat_map(|row| row.iter().copied()).collect())
        };
        self.each(py, inputs, vec![self.n(); 2], by_rows)
    }

    /// - `shape`: of the quantity at one state, whose numbers come row by row
    fn each<'py, const K: usize>(
        &self,
        py: Python<'py>,
        inputs: [(&str, &Rows<'py>); K],
        mut shape: Vec<usize>,
        of: impl Fn(&Torque, [&[f64]; K]) -> Result<Vec<f64>, model::ModelError> + Send + Sync,
    ) -> Answer<'py> {
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
