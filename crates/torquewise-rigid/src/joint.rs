//! Kinds of joints: each is one `JointType`, in a file of its own, and a variant of [`JointKind`].

mod prismatic;
mod revolute;

use serde::{Deserialize, Serialize};
use std::fmt::{Display, Formatter};
use std::ops::Deref;

/// How a joint lets a body move; z of its frame is the axis.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
#[serde(rename_all = "lowercase")]
pub enum JointKind {
    /// Turns about z: coordinate in rad, motor in N·m.
    #[default]
    Revolute,
    /// Slides along z: coordinate in m, motor in N.
    Prismatic,
}

/// All that is asked of a kind of joint.
#[derive(Debug)]
pub struct JointType {
    /// `revolute` or `prismatic`, as a URDF has it too.
    pub name: &'static str,
    /// `hinge` or `slide`, as an MJCF has it.
    pub mjcf: &'static str,
    /// `r` or `p`, as kinds of an arm are written in a row.
    pub letter: char,
    /// Unit of the coordinate.
    pub unit: &'static str,
    /// Unit of what the motor gives.
    pub effort_unit: &'static str,
    /// How far the body behind it turns about z \[rad\] and slides along z \[m\], per unit of its
    /// coordinate.
    pub twist: [f64; 2],
    /// The functions of its coordinate that the energy of an arm may hold.
    pub functions: Functions,
}

/// The functions of the coordinate of a joint that the energy of an arm may hold (E4, E26).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Functions {
    /// Cosines and sines of its multiples.
    Harmonics,
    /// Its powers.
    Powers,
}

impl Deref for JointKind {
    type Target = JointType;

    #[inline]
    fn deref(&self) -> &JointType {
        match self {
            Self::Revolute => &revolute::REVOLUTE,
            Self::Prismatic => &prismatic::PRISMATIC,
        }
    }
}

impl JointKind {
    /// All kinds, the usual first.
    pub const ALL: [Self; 2] = [Self::Revolute, Self::Prismatic];

    /// Whether it turns what is behind it.
    pub fn turns(self) -> bool {
        self.twist[0] != 0.0
    }

    /// Whether it slides what is behind it.
    #[inline]
    pub fn slides(self) -> bool {
        self.twist[1] != 0.0
    }

    /// The kind of a name, as a URDF has it.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name == name)
    }

    /// Reads `rrpr`, `RRPR` or `r,r,p,r`; `None` where a letter is of no kind.
    pub fn read_all(text: &str) -> Option<Vec<Self>> {
        let kind = |letter: char| {
            Self::ALL.into_iter().find(|kind| kind.letter == letter.to_ascii_lowercase())
        };
        let letters = text.chars().filter(|letter| !matches!(letter, ',' | ' '));
        letters.map(kind).collect()
    }
}

/// The kinds of the joints of a chain.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "Vec<JointKind>", into = "Vec<JointKind>")]
pub struct JointKinds {
    /// Of each joint, n; empty where all are revolute, however many they are.
    kinds: Vec<JointKind>,
}

impl From<Vec<JointKind>> for JointKinds {
    fn from(kinds: Vec<JointKind>) -> Self {
        let is_usual = kinds.iter().all(|kind| *kind == JointKind::default());
        Self { kinds: if is_usual { Vec::new() } else { kinds } }
    }
}

impl From<JointKinds> for Vec<JointKind> {
    fn from(kinds: JointKinds) -> Self {
        kinds.kinds
    }
}

/// `rrpr`; nothing where all are revolute.
impl Display for JointKinds {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        self.kinds.iter().try_for_each(|kind| write!(f, "{}", kind.letter))
    }
}

impl JointKinds {
    /// Whether all joints are revolute.
    pub fn all_turn(&self) -> bool {
        self.kinds.is_empty()
    }

    /// The kind of a joint, counted from 0.
    #[inline]
    pub fn of(&self, joint: usize) -> JointKind {
        self.kinds.get(joint).copied().unwrap_or_default()
    }

    /// Whether a joint, counted from 0, slides.
    #[inline]
    pub fn slides(&self, joint: usize) -> bool {
        self.of(joint).slides()
    }

    /// Whether they are those of n joints.
    pub fn fit(&self, n: usize) -> bool {
        self.kinds.is_empty() || self.kinds.len() == n
    }

    /// The same of n joints with another kind of one of them, counted from 0.
    #[must_use]
    pub fn with(&self, joint: usize, kind: JointKind, n: usize) -> Self {
        let own = |other| if other == joint { kind } else { self.of(other) };
        (0..n).map(own).collect::<Vec<_>>().into()
    }

    /// Those of n joints, each.
    pub fn all(&self, n: usize) -> Vec<JointKind> {
        (0..n).map(|joint| self.of(joint)).collect()
    }

    /// `rrpr`: the letters of n joints.
    pub fn letters(&self, n: usize) -> String {
        self.all(n).into_iter().map(|kind| kind.letter).collect()
    }

    /// Those that [`JointKind::read_all`] reads.
    pub fn read(text: &str) -> Option<Self> {
        JointKind::read_all(text).map(Self::from)
    }
}
