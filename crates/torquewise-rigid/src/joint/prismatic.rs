use super::{Functions, JointType};

/// Slides along z: a linear axis or a lift.
pub(super) const PRISMATIC: JointType = JointType {
    name: "prismatic",
    mjcf: "slide",
    letter: 'p',
    unit: "m",
    effort_unit: "N",
    twist: [0.0, 1.0],
    functions: Functions::Powers,
};
