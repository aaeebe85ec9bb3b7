//! Patterns: which parts of the torque a row activates.

/// The three patterns of motion, in the order in which they activate parts of the torque.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Pattern {
    /// No joint moves: G alone acts.
    Standstill,
    /// Joints move, none accelerates: C and G act.
    UniformVelocity,
    /// Some joint accelerates: M, C and G act.
    VariableVelocity,
}

impl Pattern {
    /// All patterns, least active first.
    pub const ALL: [Self; 3] = [Self::Standstill, Self::UniformVelocity, Self::VariableVelocity];

    /// The pattern of a row whose dq \[rad/s\] and ddq \[rad/s²\] are known without noise.
    pub fn of(dq: &[f64], ddq: &[f64]) -> Self {
        let active = |rates: &[f64]| rates.iter().any(|&rate| rate != 0.0);
        Self::when(active(dq), active(ddq))
    }

    /// The pattern of a row in which joints move or stand still, and accelerate or do not.
    pub fn when(moves: bool, accelerates: bool) -> Self {
        match (moves, accelerates) {
            (_, true) => Self::VariableVelocity,
            (true, false) => Self::UniformVelocity,
            (false, false) => Self::Standstill,
        }
    }

    /// Its name in reports and files.
    pub fn name(self) -> &'static str {
        ["standstill", "uniform velocity", "variable velocity"][self as usize]
    }
}
