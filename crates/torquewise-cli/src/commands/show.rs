//! Model → equations to read, and whether they are physics.

use crate::call_costs::CallCosts;
use crate::conditioning;
use crate::files::read_model;
use crate::outcome::{Outcome, object};
use crate::table::Table;
use anyhow::Result;
use clap::{Args, ValueEnum};
use serde_json::{Value, json};
use std::path::PathBuf;
use torquewise::model::model::Choice;
use torquewise::model::shaft_friction::ShaftFriction;
use torquewise::model::{Form, FrictionTerm, Kind, Model, Weighted, print};
use torquewise::number::number;
use torquewise::physics::{PhysicsCheck, STATES};
use torquewise::summary::AllRepairs;

/// Print the equations of a model
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Model file
    model: PathBuf,
    /// How to print
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Check at random states that M(q) is symmetric and positive definite and dM/dt − 2C skew,
    /// and at all speeds up to the trained peak that friction takes power
    ///
    /// States are drawn from the training range, and again with each joint anywhere from −π to π.
    /// The constant offset of friction is left aside.
    #[arg(long)]
    check: bool,
    /// Random states of each range
    #[arg(long, value_name = "N", default_value_t = STATES, requires = "check")]
    #[arg(value_parser = states)]
    states: usize,
    /// Count what a call of the torque costs a controller, after each step and whole
    #[arg(long)]
    cost: bool,
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
    let physics =
        arguments.check.then(|| PhysicsCheck::of(&model, arguments.states)).transpose()?;
    let costs = arguments.cost.then(|| CallCosts::of(&model)).transpose()?;
    let mut json = json(&model, physics.as_ref());
    json["costs"] = costs.as_ref().map_or(Value::Null, CallCosts::json);
    let mut text = match arguments.format {
        Format::Text => friction_text(&model) + &print::text(&model),
        Format::Latex => print::latex(&model),
        Format::Json => json.to_string() + "\n",
    };
    if arguments.format == Format::Text {
        text.extend(model.choices.iter().map(choice_text));
        text.extend(model.training.overlooked.as_ref().map(|found| format!("\n{found}\n")));
        text.push_str(&conditioning::text(&model.training.conditioning));
        text.extend(physics.as_ref().map(|physics| format!("\n{physics}")));
        text.extend(costs.as_ref().map(CallCosts::text));
    }
    let warnings = physics.iter().filter_map(PhysicsCheck::warning).collect();
    Ok(Outcome { notes: Vec::new(), text, json, warnings })
}

/// How the friction is to be read.
const FRICTION: &str = "Friction, ± standard error, – where it is not resolved\n\
    F_c Coulomb, F_s static, v_s Stribeck speed, F_v viscous; stiffness, travel: of reversals\n\
    \n";

/// The friction that engineers look for; nothing for a model without.
fn friction_text(model: &Model) -> String {
    let tables = print::friction_tables(model);
    if tables.is_empty() {
        return String::new();
    }
    let tables = tables.into_iter().map(|table| Table::of(table).text() + "\n");
    FRICTION.to_owned() + &tables.collect::<String>()
}

fn states(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count @ 1..=10_000_000) => Ok(count),
        _ => Err("expected a number from 1 to 10000000".to_owned()),
    }
}

/// What there was to choose from, and what was taken.
fn choice_text(choice: &Choice) -> String {
    let Choice { what, chosen, rule, from } = choice;
    let mut table = Table::new(&["candidate", "error [%]", "± [%]", "coefficients", ""]);
    for candidate in from {
        let [error, std_error] = [candidate.error, candidate.std_error].map(|x| number(100.0 * x));
        let mark = if candidate.label == *chosen { "chosen" } else { "" };
        let coefficients = candidate.complexity.to_string();
        table.row(&candidate.label, [error, std_error, coefficients, mark.to_owned()]);
    }
    format!("\n{what}: {chosen}, chosen on held-out data ({rule})\n\n{}", table.text())
}

fn json(model: &Model, physics: Option<&PhysicsCheck>) -> Value {
    let equations = print::weighted_equations(model);
    let frictions = print::weighted_friction(model);
    let joints = model.joints.iter().zip(equations.iter().zip(&frictions));
    let joints = joints.map(|(name, (equation, friction))| {
        let terms = equation.iter().map(|w| term_json(w, &w.term.name(), w.term.kind()));
        let friction = friction.iter().map(|w| term_json(w, &w.term.formula(), Kind::Friction));
        json!({ "name": name, "terms": terms.chain(friction).collect::<Vec<_>>() })
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
        "friction_parameters": ShaftFriction::all(model).iter().map(shaft_json).collect::<Vec<_>>(),
        "friction": model.friction.iter().map(friction_json).collect::<Vec<_>>(),
        "choices": model.choices,
        "overlooked": model.training.overlooked,
        "conditioning": object(&AllRepairs::of(&model.training.conditioning)),
        "checks": physics.map(object),
    })
}

fn term_json<T>(weighted: &Weighted<T>, name: &str, kind: Kind) -> Value {
    json!({
        "term": name,
        "kind": kind.name(),
        "coefficient": weighted.coefficient,
        "std_error": weighted.std_error,
        "inclusion": weighted.inclusion,
    })
}

/// Friction of a shaft as engineers read it.
fn shaft_json(shaft: &ShaftFriction<'_>) -> Value {
    let mut json = json!(shaft.parameters());
    json["name"] = json!(shaft.name());
    json["shaft"] = json!(shaft.shaft());
    json
}

/// A law of friction of a shaft, before its joints share it.
fn friction_json(weighted: &Weighted<FrictionTerm>) -> Value {
    json!({
        "term": weighted.term.name(),
        "shaft": weighted.term.shaft,
        "coefficient": weighted.coefficient,
        "std_error": weighted.std_error,
        "inclusion": weighted.inclusion,
    })
}
