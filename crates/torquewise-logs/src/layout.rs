//! From signals to slots: where each signal of each joint stands in a row.

/// A signal with one column per joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Signal {
    Q,
    Dq,
    Ddq,
    Tau,
}

impl Signal {
    /// All signals, in the order of the slots of a [`Layout`].
    pub(crate) const ALL: [Self; 4] = [Self::Q, Self::Dq, Self::Ddq, Self::Tau];

    /// The name of its columns, before the number of the joint.
    pub(crate) fn name(self) -> &'static str {
        ["q", "dq", "ddq", "tau"][self as usize]
    }
}

/// Which signals a row has: t, then q1…qn, then dq, ddq and tau as far as they are known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Layout {
    n_joints: usize,
    present: Vec<Signal>,
}

impl Layout {
    /// Of n joints, with these signals in the order of [`Signal::ALL`].
    pub(crate) fn new(n_joints: usize, present: Vec<Signal>) -> Self {
        Self { n_joints, present }
    }

    /// Number of joints n.
    pub(crate) fn n_joints(&self) -> usize {
        self.n_joints
    }

    /// Number of slots.
    pub(crate) fn n_slots(&self) -> usize {
        1 + self.present.len() * self.n_joints
    }

    /// The slot of joint 1 of a signal; the other joints follow.
    pub(crate) fn slot(&self, signal: Signal) -> Option<usize> {
        let place = self.present.iter().position(|present| *present == signal)?;
        Some(1 + place * self.n_joints)
    }
}
