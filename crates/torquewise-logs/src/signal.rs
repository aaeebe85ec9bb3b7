//! The signals of an arm.

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Signal {
    Q,
    Dq,
    Ddq,
    Tau,
}

impl Signal {
    /// All signals, in the order of their slots.
    pub(crate) const ALL: [Self; 4] = [Self::Q, Self::Dq, Self::Ddq, Self::Tau];

    /// The name of its columns, before the number of the joint.
    pub(crate) fn name(self) -> &'static str {
        ["q", "dq", "ddq", "tau"][self as usize]
    }
}
