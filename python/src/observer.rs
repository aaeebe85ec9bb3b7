//! Torque that others put on an arm, and the load on a link.

use crate::errors::{value_error, wrong};
use crate::log::Log;
use crate::model::{Model, json};
use crate::work::work;
use numpy::PyArray2;
use numpy::ndarray::Array2;
use pyo3::prelude::*;
use std::sync::Arc;
use torquewise::external::{External, ExternalOptions};
use torquewise::payload::LoadPlace;

/// Rows of t, n torques and n thresholds; how these were set and contacts as JSON; hints.
type Observed<'py> = (Bound<'py, PyArray2<f64>>, [String; 2], Vec<String>);

/// External torque of a log.
#[pyfunction]
pub(crate) fn contacts<'py>(
    py: Python<'py>,
    model: &Model,
    log: &Log,
    free: Option<&Log>,
    bandwidth: Option<f64>,
    false_alarms: Option<f64>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Observed<'py>> {
    let usual = ExternalOptions::default();
    let options = ExternalOptions {
        bandwidth: bandwidth.unwrap_or(usual.bandwidth),
        false_alarms_per_hour: false_alarms.unwrap_or(usual.false_alarms_per_hour),
    };
    for (name, value) in
        [("bandwidth", options.bandwidth), ("false_alarms", options.false_alarms_per_hour)]
    {
        if !(value > 0.0 && value <= 1e4) {
            return wrong(format!("{name}: expected a number above 0, at most 10000"));
        }
    }
    let width = 2 * model.model.n_joints() + 1;
    let (model, log) = (Arc::clone(&model.model), log.log.clone());
    let free = free.map(|free| free.log.clone());
    let (rows, found) = work(py, progress, move |observer| {
        let mut rows: Vec<f64> = Vec::new();
        let found = torquewise::external::contacts(
            &model,
            &log,
            free.as_ref(),
            options,
            observer,
            &mut |t, external, most| {
                if external.iter().all(|x| x.is_finite()) {
                    rows.push(t);
                    rows.extend_from_slice(external);
                    rows.extend_from_slice(most);
                }
                Ok(())
            },
        )?;
        Ok((rows, found))
    })?;
    let table = Array2::from_shape_vec((rows.len() / width, width), rows).map_err(value_error)?;
    let External { thresholds, contacts, warnings, .. } = found;
    let found = [json(&thresholds)?, json(&contacts)?];
    Ok((PyArray2::from_owned_array(py, table), found, warnings))
}

/// The load on a link: JSON, hints, and the model of the arm that carries it.
#[pyfunction]
pub(crate) fn payload(
    py: Python<'_>,
    model: &Model,
    log: &Log,
    link: Option<&str>,
    center: Option<[f64; 3]>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<(String, Vec<String>, Model)> {
    let Some(place) = LoadPlace::named(&model.model, link, center) else {
        return wrong(format!("link: no link of the model is called {}", link.unwrap_or("")));
    };
    let (model, log) = (Arc::clone(&model.model), log.log.clone());
    let (found, loaded) = work(py, progress, move |observer| {
        let found = torquewise::payload::payload(&model, &log, place, observer)?;
        let loaded = found.added_to(&model)?;
        Ok((found, loaded))
    })?;
    let hints = found.hints();
    Ok((json(&found)?, hints, Model::new(loaded)))
}

/// What a unit of each torque column is worth: JSON, hints.
#[pyfunction]
pub(crate) fn gains(
    py: Python<'_>,
    model: &Model,
    log: &Log,
    mass: f64,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<(String, Vec<String>)> {
    if !(mass > 0.0 && mass <= 1e4) {
        return wrong("mass: expected a number above 0, at most 10000 kg".to_owned());
    }
    let Some(place) = LoadPlace::named(&model.model, None, None) else {
        return wrong("model: expected joints".to_owned());
    };
    let (model, log) = (Arc::clone(&model.model), log.log.clone());
    let found = work(py, progress, move |observer| {
        torquewise::payload::gains(&model, &log, place, mass, observer)
    })?;
    Ok((json(&found)?, found.hints()))
}
