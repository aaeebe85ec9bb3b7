//! Models beside closed forms.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod chain;
mod friction;
mod model;
mod physics;
mod rigid_chain;
mod rollout;
mod shaft_friction;

use torquewise_model::{Form, FrictionTerm, Model, Weighted};

/// Two joints with what moves them and what rubs.
fn two_joints(form: Form, friction: Vec<Weighted<FrictionTerm>>) -> Model {
    let joints = vec!["hip".into(), "knee".into()];
    Model { joints, form, friction, ..Model::default() }
}
