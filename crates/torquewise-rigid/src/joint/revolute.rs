use super::{Functions, JointType};

/// Turns about z: a hinge.
pub(super) const REVOLUTE: JointType = JointType {
    name: "revolute",
    mjcf: "hinge",
    letter: 'r',
    unit: "rad",
    effort_unit: "N·m",
    twist: [1.0, 0.0],
    functions: Functions::Harmonics,
};
