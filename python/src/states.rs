//! Quantities of a model at one state, or at each of several.

use crate::arrays::{Rows, array, matrices, same_rows};
use crate::errors::model_error;
use crate::model::Model;
use faer::Mat;
use numpy::PyArray1;
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
        if let Some(one) = one_state(&inputs) {
            let found = of(&self.torque, one).map_err(model_error)?;
            return Ok(PyArray1::from_vec(py, found).into_any());
        }
        let n = self.n();
        let inputs = same_rows(inputs, n)?;
        let rows = inputs.first().map_or(0, Mat::nrows);
        let found = py.detach(|| {
            let mut all = Mat::zeros(rows, n);
            for row in 0..rows {
                let own = of(&self.torque, state_of(&inputs, row).each_ref().map(Vec::as_slice))?;
                own.iter().enumerate().for_each(|(joint, value)| all[(row, joint)] = *value);
            }
            Ok(all)
        });
        Ok(array(py, found.map_err(|error: model::ModelError| model_error(error))?.as_ref())
            .into_any())
    }

    pub(crate) fn matrix_at_each<'py, const K: usize>(
        &self,
        py: Python<'py>,
        inputs: [(&str, &Rows<'py>); K],
        of: impl Fn(&Torque, [&[f64]; K]) -> Result<Mat<f64>, model::ModelError> + Send + Sync,
    ) -> Answer<'py> {
        if let Some(one) = one_state(&inputs) {
            let found = of(&self.torque, one).map_err(model_error)?;
            return Ok(array(py, found.as_ref()).into_any());
        }
        let inputs = same_rows(inputs, self.n())?;
        let rows = inputs.first().map_or(0, Mat::nrows);
        let found = py.detach(|| {
            let at = |row| of(&self.torque, state_of(&inputs, row).each_ref().map(Vec::as_slice));
            (0..rows).map(at).collect::<Result<Vec<_>, _>>()
        });
        Ok(matrices(py, &found.map_err(model_error)?, self.n()).into_any())
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
