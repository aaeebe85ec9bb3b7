//! Models beside closed forms.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod chain;
mod friction;
mod model;
mod physics;
mod rigid_chain;
mod rollout;
mod shaft_friction;
#[path = "../../../torquewise-paper/src/truth.rs"]
mod truth;

use torquewise_model::{Form, FrictionTerm, Model, Term, Weighted};

/// Two joints with what moves them and what rubs.
fn two_joints(form: Form, friction: Vec<Weighted<FrictionTerm>>) -> Model {
    let joints = vec!["hip".into(), "knee".into()];
    Model { joints, form, friction, ..Model::default() }
}

/// The equations of a model as such, the coefficients of their terms changed.
fn as_torques(model: &Model, change: impl Fn(f64, &Term) -> f64) -> Form {
    let one = |(c, term): (f64, Term)| Weighted::new(term.clone(), change(c, &term));
    let sums = model.equations().into_iter();
    Form::Torque(sums.map(|sum| sum.into_iter().map(one).collect()).collect())
}
