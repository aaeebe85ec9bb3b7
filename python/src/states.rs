//! Quantities of a model at one state, or at each of several.

use crate::arrays::{Rows, array, matrices, same_rows};
use crate::errors::raised;
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
        Ok(match self.each(py, inputs, of)? {
            Found::One(own) => PyArray1::from_vec(py, own).into_any(),
            Found::Many(all) => {
                let all = Mat::from_fn(all.len(), self.n(), |row, joint| all[row][joint]);
                array(py, all.as_ref()).into_any()
            }
        })
    }

    /// The same of a matrix, n×n.
    pub(crate) fn matrix_at_each<'py, const K: usize>(
        &self,
        py: Python<'py>,
        inputs: [(&str, &Rows<'py>); K],
        of: impl Fn(&Torque, [&[f64]; K]) -> Result<Mat<f64>, model::ModelError> + Send + Sync,
    ) -> Answer<'py> {
        Ok(match self.each(py, inputs, of)? {
            Found::One(own) => array(py, own.as_ref()).into_any(),
            Found::Many(all) => matrices(py, &all, self.n()).into_any(),
        })
    }

    fn each<T: Send, const K: usize>(
        &self,
        py: Python<'_>,
        inputs: [(&str, &Rows<'_>); K],
        of: impl Fn(&Torque, [&[f64]; K]) -> Result<T, model::ModelError> + Send + Sync,
    ) -> PyResult<Found<T>> {
        if let Some(one) = one_state(&inputs) {
            return of(&self.torque, one).map(Found::One).map_err(raised);
        }
        let inputs = same_rows(inputs, self.n())?;
        let rows = inputs.first().map_or(0, Mat::nrows);
        let at = |row| of(&self.torque, state_of(&inputs, row).each_ref().map(Vec::as_slice));
        let found = py.detach(|| (0..rows).map(at).collect::<Result<_, _>>());
        found.map(Found::Many).map_err(raised)
    }
}

/// What a quantity is at one state, or at each of several.
enum Found<T> {
    One(T),
    Many(Vec<T>),
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
