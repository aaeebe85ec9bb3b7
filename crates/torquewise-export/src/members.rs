//! Cost of the torque after each step of a stepwise model.

use crate::cost::Cost;
use crate::error::Result;
use crate::program::{Program, Quantity};
use torquewise_model::Model;

/// Cost of the torque of a model as it was after each step, and of the whole last.
///
/// A model that was not found stepwise has one entry. What friction that remembers the path takes
/// to follow it is not counted.
///
/// # Errors
/// Those of [`Program::of`].
pub fn torque_costs(model: &Model) -> Result<Vec<Cost>> {
    let whole = Model { stages: Vec::new(), ..model.clone() };
    let cost = |model: &Model| Ok(Program::of(model)?.cost(Quantity::Torque));
    let steps = (1..=model.stages.len()).map(|step| cost(&model.after_step(step)?));
    steps.chain(std::iter::once_with(|| cost(&whole))).collect()
}
