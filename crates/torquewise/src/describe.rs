//! A model as an object that other programs read.

use crate::summary::all_repairs;
use serde_json::{Value, json};
use torquewise_model::selection::Selection;
use torquewise_model::shaft_friction::ShaftFriction;
use torquewise_model::{Form, Kind, Model, ModelError, Weighted, learned, print};

/// What is in a model, or in a part of it, for programs: axes, terms by joint, energies, friction,
/// what was chosen and repaired.
///
/// # Errors
/// [`ModelError`] if the geometry of the chain is none.
pub fn description(model: &Model, selection: &Selection) -> Result<Value, ModelError> {
    let equations = print::weighted_equations(model);
    let frictions = print::weighted_friction(model);
    let joints = model.joints.iter().zip(equations.iter().zip(&frictions)).enumerate();
    let joints = joints.filter(|(joint, _)| selection.has_joint(*joint));
    let joints = joints.map(|(_, (name, (equation, friction)))| {
        let terms = equation.iter().filter(|w| selection.has_part(w.term.kind()));
        let terms = terms.map(|w| term_json(w, &w.term.name(), ("kind", json!(w.term.kind()))));
        let friction = friction.iter().filter(|_| selection.has_part(Kind::Friction));
        let friction =
            friction.map(|w| term_json(w, &w.term.formula(), ("kind", json!(Kind::Friction))));
        let mut terms: Vec<Value> = terms.chain(friction).collect();
        if let Some(top) = selection.top {
            let size = |term: &Value| term["coefficient"].as_f64().unwrap_or_default().abs();
            terms.sort_by(|a, b| size(b).total_cmp(&size(a)));
            terms.truncate(top);
        }
        json!({ "name": name, "terms": terms })
    });
    let energies = match &model.form {
        Form::Torque(_) => Value::Null,
        Form::Energy(terms) => terms
            .iter()
            .filter(|weighted| selection.has_energy(weighted.term.place))
            .map(|weighted| {
                let place = ("place", json!(weighted.term.place.name()));
                term_json(weighted, &weighted.term.function.name(), place)
            })
            .collect(),
    };
    let turns = |shaft: &[f64]| {
        let mut joints = shaft.iter().enumerate().filter(|(_, share)| **share != 0.0);
        selection.has_part(Kind::Friction) && joints.any(|(joint, _)| selection.has_joint(joint))
    };
    let shafts = ShaftFriction::all(model).into_iter().filter(|shaft| turns(shaft.shaft()));
    let shafts = shafts.map(|shaft| {
        let mut json = json!(shaft.parameters());
        json["name"] = json!(shaft.name());
        json["shaft"] = json!(shaft.shaft());
        json
    });
    // Laws of a shaft, before its joints share it.
    let laws = model.friction.iter().filter(|law| turns(&law.term.shaft));
    let laws = laws.map(|law| term_json(law, &law.term.name(), ("shaft", json!(law.term.shaft))));
    Ok(json!({
        "geometry": learned::joint_geometry(model)?,
        "parameters": learned::parameters(model)?,
        "joints": joints.collect::<Vec<_>>(),
        "energies": energies,
        "friction_parameters": shafts.collect::<Vec<_>>(),
        "friction": laws.collect::<Vec<_>>(),
        "choices": model.choices,
        "conditioning": all_repairs(&model.training.conditioning),
    }))
}

/// A weighted term, and what else is said of it.
fn term_json<T>(weighted: &Weighted<T>, name: &str, (key, more): (&str, Value)) -> Value {
    json!({
        "term": name,
        key: more,
        "coefficient": weighted.coefficient,
        "std_error": weighted.std_error,
        "inclusion": weighted.inclusion,
    })
}
