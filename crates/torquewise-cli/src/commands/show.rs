//! Model → equations to read, and whether they are physics.

use crate::files::read_model;
use crate::outcome::Outcome;
use crate::physics::Physics;
use anyhow::Result;
use clap::{Args, ValueEnum};
use serde_json::{Value, json};
use std::path::PathBuf;
use torquewise::model::{Form, Kind, Model, Term, Weighted, print};

/// Print the equations of a model
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Model file
    model: PathBuf,
    /// How to print
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Check at random states that M(q) is symmetric and positive definite and dM/dt − 2C skew
    #[arg(long)]
    check: bool,
}

/// How equations are printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Plain text, ± standard error
    #[default]
    Text,
    /// A LaTeX align* environment
    Latex,
    /// One JSON object, as with --json
    Json,
}

/// Prints, and checks if asked to.
pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let model = read_model(&arguments.model)?;
    let physics = arguments.check.then(|| Physics::of(&model)).transpose()?;
    let json = json(&model, physics.as_ref());
    let mut text = match arguments.format {
        Format::Text => print::text(&model),
        Format::Latex => print::latex(&model),
        Format::Json => json.to_string() + "\n",
    };
    if let Some(physics) = physics.as_ref().filter(|_| arguments.format == Format::Text) {
        text.push_str(&physics.text());
    }
    let warnings = physics.iter().filter_map(Physics::warning).collect();
    Ok(Outcome { text, json, warnings })
}

fn json(model: &Model, physics: Option<&Physics>) -> Value {
    let equations = print::weighted_equations(model);
    let joints = model.joints.iter().zip(&equations).map(|(name, equation)| {
        json!({ "name": name, "terms": equation.iter().map(term_json).collect::<Vec<_>>() })
    });
    let energies = match &model.form {
        Form::Torque(_) => Value::Null,
        Form::Energy(terms) => terms
            .iter()
            .map(|weighted| {
                json!({
                    "place": weighted.term.place.name(),
                    "term": weighted.term.function.name(),
                    "coefficient": weighted.coefficient,
                    "std_error": weighted.std_error,
                    "inclusion": weighted.inclusion,
                })
            })
            .collect(),
    };
    json!({
        "joints": joints.collect::<Vec<_>>(),
        "energies": energies,
        "checks": physics.map(Physics::json),
    })
}

fn term_json(weighted: &Weighted<Term>) -> Value {
    let kind = match weighted.term.kind() {
        Kind::Gravity => "gravity",
        Kind::Coriolis => "coriolis",
        Kind::Inertia => "inertia",
    };
    json!({
        "term": weighted.term.name(),
        "kind": kind,
        "coefficient": weighted.coefficient,
        "std_error": weighted.std_error,
        "inclusion": weighted.inclusion,
    })
}
