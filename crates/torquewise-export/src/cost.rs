//! Cost of a call: counted operations, and about how long they take.

use crate::{Function, Graph, Id, Node, Program, Quantity, Result};
use std::fmt;
use torquewise_model::Model;

/// Time of an addition or multiplication of compiled code on the reference processor \[s\].
///
/// With that of a function it meets the medians of the table of `docs/export.md` within a quarter:
/// C by gcc 12 `-O2` on a shared x86-64 of 2 cores with AVX2.
const PER_OPERATION: f64 = 0.36e-9;
/// Time of a sine, cosine, exponential or hyperbolic tangent there \[s\].
const PER_FUNCTION: f64 = 5e-9;

/// How much a function computes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Additions, subtractions, multiplications, divisions and absolute values.
    pub operations: usize,
    /// Sines, cosines, exponentials and hyperbolic tangents.
    pub functions: usize,
}

impl Cost {
    pub(crate) fn of(graph: &Graph, roots: &[Id]) -> Self {
        let mut cost = Self::default();
        for id in graph.reachable(roots) {
            match graph.node(id) {
                Node::Constant(_) | Node::Input(_) => {}
                Node::Add(..) | Node::Sub(..) | Node::Mul(..) | Node::Neg(_) => {
                    cost.operations += 1;
                }
                Node::Call(Function::Abs | Function::Reciprocal, _) => cost.operations += 1,
                Node::Sin(_) | Node::Cos(_) | Node::Call(..) => cost.functions += 1,
            }
        }
        cost
    }

    /// A sine takes as long as some twenty multiplications.
    pub(crate) fn weight(self) -> usize {
        self.operations + 20 * self.functions
    }

    /// About how long a call of the exported C takes on the reference processor \[s\]: an estimate
    /// from the counts, right to a quarter or so.
    pub fn seconds(self) -> f64 {
        PER_OPERATION * self.operations as f64 + PER_FUNCTION * self.functions as f64
    }

    /// Part of the period of a control rate \[Hz\] that a call takes, in percent.
    pub fn percent_of_period(self, rate: f64) -> f64 {
        100.0 * self.seconds() * rate
    }
}

impl fmt::Display for Cost {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "{} + - * /, {} sin cos exp tanh", self.operations, self.functions)
    }
}

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
