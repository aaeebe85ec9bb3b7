//! Model files: versioned JSON, written whole or not at all.

use crate::error::expect;
use crate::{Direction, Form, FrictionLaw, FrictionTerm, Model, ModelError, Term, Weighted};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::fmt::Display;
use std::path::Path;
use torquewise_motion::whole_file::write_whole;
use torquewise_motion::{bounded_file, unfit_joint_name};

/// Version of the file format that is written and read.
pub const FILE_VERSION: u64 = 1;

/// Factors of a term at most, and multiples of an angle: what a term is worked out by stays exact.
const MOST_ORDER: u8 = 32;

const FORMAT: &str = "torquewise-model";

/// What a file holds: fields of its own, and those of the model beside them.
#[derive(Serialize, Deserialize)]
struct Header<M> {
    format: String,
    version: u64,
    #[serde(flatten)]
    model: M,
}

impl Model {
    /// Writes the model to a file of JSON, whatever its name ends in, whole or not at all.
    ///
    /// # Errors
    /// [`ModelError::Write`], or as [`to_json`].
    pub fn save(&self, file: impl AsRef<Path>) -> Result<(), ModelError> {
        let file = file.as_ref();
        write_whole(file, to_json(self)?.as_bytes())
            .map_err(|source| ModelError::Write { file: file.into(), source })
    }

    /// Reads a model from a file that [`Self::save`] or `torquewise fit` wrote.
    ///
    /// # Errors
    /// [`ModelError::Read`], or [`ModelError::InFile`] with what [`from_json`] found wrong.
    pub fn load(file: impl AsRef<Path>) -> Result<Self, ModelError> {
        let file = file.as_ref();
        let text = bounded_file::read_text(file)
            .map_err(|source| ModelError::Read { file: file.into(), source })?;
        from_json(&text)
            .map_err(|source| ModelError::InFile { file: file.into(), source: Box::new(source) })
    }
}

/// The text of a model file.
///
/// # Errors
/// [`ModelError::Damaged`] if a coefficient is not finite, which JSON cannot hold, or what
/// [`from_json`] would find wrong with the parts of the model.
pub fn to_json(model: &Model) -> Result<String, ModelError> {
    check(model)?;
    let written = Header { format: FORMAT.to_owned(), version: FILE_VERSION, model };
    serde_json::to_string_pretty(&written)
        .map(|text| text + "\n")
        .map_err(|error| ModelError::NotAModel { reason: error.to_string() })
}

/// Reads the text of a model file.
///
/// # Errors
/// [`ModelError::NotAModel`] if it is cut off, no JSON or no model, [`ModelError::Version`] if it
/// is of another version, [`ModelError::Shape`], [`ModelError::Damaged`] or
/// [`ModelError::Chain`] if its parts do not fit.
pub fn from_json(text: &str) -> Result<Model, ModelError> {
    let not_a_model =
        |error: serde_json::Error| ModelError::NotAModel { reason: error.to_string() };
    let value: Value = serde_json::from_str(text).map_err(not_a_model)?;
    let header: Header<Value> = serde_json::from_value(value).map_err(not_a_model)?;
    let Header { format, version, model } = header;
    if format != FORMAT {
        return Err(ModelError::NotAModel { reason: format!("its format is {format:?}") });
    }
    if version != FILE_VERSION {
        return Err(ModelError::Version { found: version, known: FILE_VERSION });
    }
    let model: Model = serde_json::from_value(model).map_err(not_a_model)?;
    check(&model)?;
    Ok(model)
}

/// Whether all parts fit the number of joints and are finite.
fn check(model: &Model) -> Result<(), ModelError> {
    let n = model.n_joints();
    if n == 0 {
        return Err(ModelError::NotAModel { reason: "it has no joints".into() });
    }
    if let Some(name) = unfit_joint_name(&model.joints) {
        let start: String = name.chars().take(20).flat_map(char::escape_debug).collect();
        let reason = format!(
            "a joint is called \"{start}\": names occur once, have 1 to 200 bytes and no comma, \
             control character or outer space"
        );
        return Err(ModelError::NotAModel { reason });
    }
    let stages = model.stages.iter().map(|stage| (&stage.form, &stage.friction));
    for (form, friction) in std::iter::once((&model.form, &model.friction)).chain(stages) {
        check_form(form, n)?;
        friction.iter().try_for_each(|weighted| check_friction(weighted, n))?;
    }
    for candidate in model.choices.iter().flat_map(|choice| &choice.from) {
        let place = || candidate.label.clone();
        finite("a held-out error", candidate.error, place)?;
        finite("its standard error", candidate.std_error, place)?;
    }
    if let Some(chain) = &model.chain {
        chain.check(n, model.friction.len())?;
    }
    for (log, repairs) in &model.training.conditioning {
        finite("the longest gap of a log", repairs.longest_gap, || log.clone())?;
    }
    Ok(())
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
            if w.term.function.dq.iter().chain(&w.term.function.ddq).any(|&power| power > 0) {
                let reason = "an energy has velocities or accelerations beside its angles";
                return Err(ModelError::NotAModel { reason: reason.into() });
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
        if factor.power == 0 || factor.multiples.iter().any(|k| k.unsigned_abs() > MOST_ORDER) {
            return Err(out_of_bounds("a factor"));
        }
    }
    let orders = |powers: &[u8]| powers.iter().map(|&power| u64::from(power)).sum::<u64>();
    let angles = term.factors.iter().map(|factor| u64::from(factor.power)).sum::<u64>();
    if angles.max(orders(&term.dq)).max(orders(&term.ddq)) > u64::from(MOST_ORDER) {
        return Err(out_of_bounds("a term"));
    }
    finite("a coefficient", weighted.coefficient, || term.name())?;
    finite("a standard error", weighted.std_error, || term.name())
}

fn out_of_bounds(what: &str) -> ModelError {
    let reason = format!("{what} has a power or a multiple outside 1 to {MOST_ORDER}");
    ModelError::NotAModel { reason }
}

/// Whether the shaft is one of n joints and turns, and the law is a function of its speed.
fn check_friction(weighted: &Weighted<FrictionTerm>, n: usize) -> Result<(), ModelError> {
    let term = &weighted.term;
    expect("the shaft of a friction term", term.shaft.len(), n)?;
    for &shaft in &term.shaft {
        finite("a shaft", shaft, || term.name())?;
    }
    let refuse = |what: &str, found: &dyn Display, expected: &str| {
        let place = term.name();
        let reason = format!("{what} of the friction {place} is {found}, expected {expected}");
        Err(ModelError::Damaged { reason })
    };
    if term.shaft.iter().all(|shaft| *shaft == 0.0) {
        return refuse("every entry of the shaft", &0, "one that turns with it");
    }
    if let FrictionLaw::Stribeck { speed, .. } = term.law
        && !(speed.is_finite() && speed > 0.0)
    {
        return refuse("the Stribeck speed", &speed, "a finite one above 0");
    }
    if let FrictionLaw::Coulomb { width } | FrictionLaw::Stribeck { width, .. } = term.law
        && !(width.is_finite() && width >= 0.0)
    {
        return refuse("the width", &width, "a finite one, 0 or above");
    }
    if term.law == FrictionLaw::Offset && term.direction != Direction::Both {
        return refuse("the direction", &"one of two", "both, as an offset has none");
    }
    if let FrictionLaw::Dahl { travel } = term.law {
        if !(travel.is_finite() && travel > 0.0) {
            return refuse("the travel", &travel, "a finite one above 0");
        }
        let own = term.shaft.iter().filter(|shaft| **shaft != 0.0);
        if !own.eq([&1.0]) || term.direction != Direction::Both {
            return refuse("the shaft", &"not one joint", "one joint, in both directions");
        }
    }
    if term.load && term.shaft.iter().filter(|shaft| **shaft != 0.0).count() != 1 {
        return refuse("the shaft", &"of several joints", "of one joint, whose load it feels");
    }
    finite("a coefficient", weighted.coefficient, || term.name())?;
    finite("a standard error", weighted.std_error, || term.name())
}

fn finite(what: &str, value: f64, place: impl FnOnce() -> String) -> Result<(), ModelError> {
    let reason = || format!("{what} is not finite in {}", place());
    if value.is_finite() { Ok(()) } else { Err(ModelError::Damaged { reason: reason() }) }
}
