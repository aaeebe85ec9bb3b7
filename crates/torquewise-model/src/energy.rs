//! Torque of kinetic and potential energy: the terms of M(q) and V(q), differentiated (E4).

use crate::term::collect;
use crate::{Sum, Term};
use serde::{Deserialize, Serialize};

/// Where in the energy a function stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Place {
    /// In V(q).
    Potential,
    /// In Mᵢⱼ(q) = Mⱼᵢ(q), joints counted from 0, i ≤ j.
    Inertia(usize, usize),
}

/// One function of the joint angles in M(q) or V(q).
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EnergyTerm {
    /// Where it stands.
    pub place: Place,
    /// The function φ(q); without velocities or accelerations.
    pub function: Term,
}

impl EnergyTerm {
    /// What it adds to the torque of a joint, per unit of its coefficient:
    /// d/dt ∂T/∂q̇ᵢ − ∂T/∂qᵢ + ∂V/∂qᵢ with T = ½ q̇ᵀ M q̇.
    ///
    /// Source: method.md, \[E4\]. Checked against: Pinocchio, `torquewise-identify/tests`.
    pub fn torque(&self, joint: usize) -> Sum {
        match self.place {
            Place::Potential => self.function.derivative(joint),
            // T = s φ q̇ᵢ q̇ⱼ, with s = ½ on the diagonal, which M holds once and 1 beside it, held twice.
            Place::Inertia(i, j) => {
                let share = if i == j { 0.5 } else { 1.0 };
                let mut sum = Sum::new();
                for (_, other) in [(i, j), (j, i)].into_iter().filter(|(own, _)| *own == joint) {
                    sum.push((share, self.function.clone().times_ddq(other)));
                    for rate in 0..self.function.n_joints() {
                        for (weight, slope) in self.function.derivative(rate) {
                            sum.push((share * weight, slope.times_dq(rate).times_dq(other)));
                        }
                    }
                }
                for (weight, slope) in self.function.derivative(joint) {
                    sum.push((-share * weight, slope.times_dq(i).times_dq(j)));
                }
                collect(sum)
            }
        }
    }

    /// Readable name, joints counted from 1: `M12: sin(q2)` or `V: cos(q2)`.
    pub fn name(&self) -> String {
        format!("{}: {}", self.place.name(), self.function.name())
    }
}

impl Place {
    /// `V` or `M12`; joints beyond nine are set apart, `M1,10`.
    pub fn name(self) -> String {
        match self {
            Self::Potential => "V".into(),
            Self::Inertia(i, j) if i < 9 && j < 9 => format!("M{}{}", i + 1, j + 1),
            Self::Inertia(i, j) => format!("M{},{}", i + 1, j + 1),
        }
    }

    /// The same in LaTeX: `V` or `M_{1,2}`.
    pub fn latex(self) -> String {
        match self {
            Self::Potential => "V".into(),
            Self::Inertia(i, j) => format!("M_{{{},{}}}", i + 1, j + 1),
        }
    }
}
