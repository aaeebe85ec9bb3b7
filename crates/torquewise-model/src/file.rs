//! Model → text → Model: a versioned JSON file.

use crate::error::ModelError;
use crate::model::{Form, Model, Weighted};
use crate::term::Term;
use serde::{Deserialize, Serialize};

/// Version of the file format this program writes, and the newest it reads.
pub const FILE_VERSION: u64 = 1;
const FORMAT: &str = "torquewise-model";

#[derive(Serialize)]
struct Written<'a> {
    format: &'a str,
    version: u64,
    #[serde(flatten)]
    model: &'a Model,
}

#[derive(Deserialize)]
struct Header {
    format: String,
    version: u64,
}

/// The text of a model file.
///
/// # Errors
/// [`ModelError::NotFinite`] if a coefficient is not finite, which JSON cannot hold.
pub fn to_json(model: &Model) -> Result<String, ModelError> {
    check(model)?;
    let written = Written { format: FORMAT, version: FILE_VERSION, model };
    serde_json::to_string_pretty(&written)
        .map(|text| text + "\n")
        .map_err(|error| ModelError::NotAModel { reason: error.to_string() })
}

/// Reads the text of a model file.
///
/// # Errors
/// [`ModelError::NotAModel`] if it is cut off, no JSON or no model, [`ModelError::Version`] if a
/// newer program wrote it, [`ModelError::Shape`] or [`ModelError::NotFinite`] if its parts do not
/// fit.
pub fn from_json(text: &str) -> Result<Model, ModelError> {
    let not_a_model =
        |error: serde_json::Error| ModelError::NotAModel { reason: error.to_string() };
    let mut value: serde_json::Value = serde_json::from_str(text).map_err(not_a_model)?;
    let header: Header = serde_json::from_value(value.clone()).map_err(not_a_model)?;
    if header.format != FORMAT {
        return Err(ModelError::NotAModel { reason: format!("its format is {:?}", header.format) });
    }
    if header.version != FILE_VERSION {
        return Err(ModelError::Version { found: header.version, known: FILE_VERSION });
    }
    if let Some(fields) = value.as_object_mut() {
        fields.remove("format");
        fields.remove("version");
    }
    let model: Model = serde_json::from_value(value).map_err(not_a_model)?;
    check(&model)?;
    Ok(model)
}

/// Whether all parts fit the number of joints and are finite.
fn check(model: &Model) -> Result<(), ModelError> {
    let n = model.n_joints();
    if n == 0 {
        return Err(ModelError::NotAModel { reason: "it has no joints".into() });
    }
    let stages = model.stages.iter().map(|stage| &stage.form);
    std::iter::once(&model.form).chain(stages).try_for_each(|form| check_form(form, n))
}

fn check_form(form: &Form, n: usize) -> Result<(), ModelError> {
    match form {
        Form::Torque(joints) => {
            expect("the list of torque equations", joints.len(), n)?;
            joints.iter().flatten().try_for_each(|w| check_weighted(w, &w.term, n))
        }
        Form::Energy(terms) => terms.iter().try_for_each(|w| {
            if let crate::energy::Place::Inertia(i, j) = w.term.place {
                expect("an entry of the mass matrix", i.max(j).max(n - 1) + 1, n)?;
            }
            check_weighted(w, &w.term.function, n)
        }),
    }
}

fn check_weighted<T>(weighted: &Weighted<T>, term: &Term, n: usize) -> Result<(), ModelError> {
    expect("the velocities of a term", term.dq.len(), n)?;
    expect("the accelerations of a term", term.ddq.len(), n)?;
    for factor in &term.factors {
        expect("the angles of a term", factor.multiples.len(), n)?;
    }
    for (what, value) in
        [("a coefficient", weighted.coefficient), ("a standard error", weighted.std_error)]
    {
        if !value.is_finite() {
            return Err(ModelError::NotFinite { what, place: term.name() });
        }
    }
    Ok(())
}

fn expect(what: &'static str, found: usize, expected: usize) -> Result<(), ModelError> {
    if found == expected { Ok(()) } else { Err(ModelError::Shape { what, found, expected }) }
}
