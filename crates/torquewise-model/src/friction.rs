//! Laws of friction of a shaft: the parts of the Stribeck curve (17), each with its weight.

use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// A law of friction on a shaft that turns with v = Σ shaft\[j\]·q̇ⱼ \[rad/s\].
///
/// By virtual work it loads joint j with shaft\[j\]·f(v), so that its power is f(v)·v.
///
/// ```
/// use torquewise_model::FrictionTerm;
/// use torquewise_model::friction::FrictionLaw;
///
/// let dry = FrictionTerm::of_joint(2, 1, FrictionLaw::Coulomb { width: 0.0 });
/// assert_eq!(dry.name(), "sign(dq2)");
/// assert_eq!([dry.torque(0, &[3.0, -0.1]), dry.torque(1, &[3.0, -0.1])], [0.0, -1.0]);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrictionTerm {
    /// Speed of the shaft per speed of each joint, n: 1 at its own joint and 0 elsewhere, several
    /// entries for the coupled joints of a wrist.
    pub shaft: Vec<f64>,
    /// What the shaft feels at a speed.
    pub law: FrictionLaw,
    /// Where it acts; [`FrictionLaw::Offset`] acts in both directions.
    #[serde(default, skip_serializing_if = "Direction::is_both")]
    pub direction: Direction,
    /// Whether gears press harder under load: f(v) is multiplied by |Gⱼ(q)|, what gravity and
    /// springs load the one joint of the shaft with, and the coefficient is a number (E13).
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub load: bool,
}

/// f(v) of one part of the curve, per unit of its coefficient.
///
/// The exact sign of v, with sign(0) = 0, jumps at reversal, which no controller should follow. A
/// `width` \[rad/s\] above 0 smooths it to tanh(v/width): for |v| < width, the dead zone, the sign
/// is not yet ±1 (0.76 at its edge), and the dry friction of an arm at rest is not represented.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum FrictionLaw {
    /// 1: offset of the drive, load of cables.
    Offset,
    /// v
    Viscous,
    /// sign(v)
    Coulomb {
        /// Half width of the dead zone \[rad/s\]; 0 for the exact sign.
        width: f64,
    },
    /// exp(−(v/speed)²)·sign(v)
    Stribeck {
        /// The Stribeck speed v_s \[rad/s\], above 0.
        speed: f64,
        /// Half width of the dead zone \[rad/s\]; 0 for the exact sign.
        width: f64,
    },
    /// The state x of a Dahl element, dx = dq/δ − |dq|/δ·x: dry friction that turns over along the
    /// way and that a joint keeps at rest (E13). Where the way is not known: the sign of v.
    Dahl {
        /// The travel δ \[rad\] of the element, above 0.
        travel: f64,
    },
}

/// Directions of the shaft in which a law acts; it is zero in the other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// Both.
    #[default]
    Both,
    /// v < 0
    Backward,
}

impl Direction {
    /// Whether it is both, as for a drive with the same friction both ways.
    pub fn is_both(&self) -> bool {
        *self == Self::Both
    }

    /// Whether a law acts at this speed of the shaft.
    pub(crate) fn holds(self, speed: f64) -> bool {
        self == Self::Both || speed < 0.0
    }
}

impl FrictionLaw {
    /// The same law with another half width of the dead zone \[rad/s\], if it has one.
    pub fn with_width(self, width: f64) -> Self {
        match self {
            Self::Offset | Self::Viscous | Self::Dahl { .. } => self,
            Self::Coulomb { .. } => Self::Coulomb { width },
            Self::Stribeck { speed, .. } => Self::Stribeck { speed, width },
        }
    }

    /// Half width of the reversal of dry friction that does not fade \[rad/s\]; 0 of other laws.
    pub fn width(self) -> f64 {
        if let Self::Coulomb { width } = self { width } else { 0.0 }
    }

    /// Whether it is friction that holds a shaft at rest.
    pub(crate) fn is_dry(self) -> bool {
        matches!(self, Self::Coulomb { .. } | Self::Stribeck { .. } | Self::Dahl { .. })
    }

    /// f(v) at a speed \[rad/s\].
    ///
    /// Source: method.md (17). Checked against: the curve itself, `tests/friction.rs`.
    pub fn value(self, speed: f64) -> f64 {
        match self {
            Self::Offset => 1.0,
            Self::Viscous => speed,
            Self::Coulomb { width } => sign(speed, width),
            Self::Stribeck { speed: stribeck, width } => {
                (-(speed / stribeck).powi(2)).exp() * sign(speed, width)
            }
            Self::Dahl { .. } => sign(speed, 0.0),
        }
    }
}

/// sign(v), smoothed within the width; sign(0) = 0.
fn sign(speed: f64, width: f64) -> f64 {
    if width > 0.0 {
        (speed / width).tanh()
    } else if speed == 0.0 {
        0.0
    } else {
        speed.signum()
    }
}

impl FrictionTerm {
    /// A law on the shaft of one of n joints, counted from 0, in both directions.
    pub fn of_joint(n_joints: usize, joint: usize, law: FrictionLaw) -> Self {
        let shaft = (0..n_joints).map(|j| f64::from(u8::from(j == joint))).collect();
        Self { shaft, law, direction: Direction::Both, load: false }
    }

    /// The same law in proportion to the load of the gear.
    pub fn under_load(self) -> Self {
        Self { load: true, ..self }
    }

    /// The first joint that its shaft turns, counted from 0.
    pub fn joint(&self) -> Option<usize> {
        self.shaft.iter().position(|shaft| *shaft != 0.0)
    }

    /// |Gⱼ| \[N·m\] that it is multiplied by, 1 where load does not matter.
    ///
    /// - `gravity`: G(q) \[N·m\], n
    pub fn pressed(&self, gravity: &[f64]) -> f64 {
        let joint = if self.load { self.joint() } else { None };
        joint.and_then(|joint| gravity.get(joint)).map_or(1.0, |load| load.abs())
    }

    /// The travel \[rad\] of the element that it follows, and the joint, if it remembers the path.
    pub fn element(&self) -> Option<(usize, f64)> {
        let FrictionLaw::Dahl { travel } = self.law else { return None };
        Some((self.joint()?, travel))
    }

    /// Speed of the shaft \[rad/s\] at joint speeds dq \[rad/s\], n.
    pub fn speed(&self, dq: &[f64]) -> f64 {
        self.shaft.iter().zip(dq).map(|(shaft, dq)| shaft * dq).sum()
    }

    /// f(v) at joint speeds dq \[rad/s\], n, under a load of 1.
    pub fn value(&self, dq: &[f64]) -> f64 {
        self.at_speed(self.speed(dq))
    }

    /// f(v) at a speed v of the shaft \[rad/s\].
    pub fn at_speed(&self, speed: f64) -> f64 {
        if self.direction.holds(speed) { self.law.value(speed) } else { 0.0 }
    }

    /// What it adds to the torque of a joint, counted from 0, per unit of its coefficient and under
    /// a load of 1; dq \[rad/s\], n.
    pub fn torque(&self, joint: usize, dq: &[f64]) -> f64 {
        if self.acts_on(joint) { self.shaft[joint] * self.value(dq) } else { 0.0 }
    }

    /// Whether it loads a joint, counted from 0.
    pub fn acts_on(&self, joint: usize) -> bool {
        self.shaft.get(joint).is_some_and(|shaft| *shaft != 0.0)
    }

    /// Readable name, joints counted from 1: `sign(dq2)`, `dq5 + dq6 [dq5 + dq6 > 0]`,
    /// `exp(-(dq2/0.05)^2)*sign(dq2)`, `sign(dq2)*|G2|`; an offset names its joint, `1 [joint2]`.
    pub fn name(&self) -> String {
        match self.law {
            FrictionLaw::Offset => format!("1 [{}]", self.sum("joint", "*")),
            _ => self.formula(),
        }
    }

    /// f(v) as it stands in the torque equation of a joint: the name, but `1` for an offset.
    pub fn formula(&self) -> String {
        self.written(false)
    }

    /// The same in LaTeX; nothing for an offset.
    pub fn latex(&self) -> String {
        self.written(true)
    }

    fn written(&self, is_latex: bool) -> String {
        let [q, dq, times, space] =
            if is_latex { ["q_", r"\dot q_", r"\,", r"\,"] } else { ["q", "dq", "*", " "] };
        let [tanh, sign, g] =
            if is_latex { [r"\tanh", r"\operatorname{sign}", "G_"] } else { ["tanh", "sign", "G"] };
        let speed = self.sum(dq, times);
        let several = self.shaft.iter().filter(|shaft| **shaft != 0.0).count() > 1;
        let whole = if several { format!("({speed})") } else { speed.clone() };
        let dry = |width: f64| {
            if width > 0.0 {
                format!("{tanh}({whole}/{width})")
            } else {
                format!("{sign}({speed})")
            }
        };
        let law = match self.law {
            FrictionLaw::Offset => if is_latex { "" } else { "1" }.into(),
            FrictionLaw::Viscous => whole.clone(),
            FrictionLaw::Coulomb { width } => dry(width),
            FrictionLaw::Stribeck { speed, width } if is_latex => {
                format!(r"e^{{-({whole}/{speed})^{{2}}}}\,{}", dry(width))
            }
            FrictionLaw::Stribeck { speed, width } => {
                format!("exp(-({whole}/{speed})^2)*{}", dry(width))
            }
            FrictionLaw::Dahl { travel } if is_latex => {
                format!("x_{{{travel}}}({})", self.sum(q, times))
            }
            FrictionLaw::Dahl { travel } => format!("dahl({}, {travel})", self.sum(q, times)),
        };
        let load = self.joint().filter(|_| self.load).map(|own| indexed(g, own));
        let load = load.map_or_else(String::new, |load| format!("{times}|{load}|"));
        match self.direction {
            Direction::Both => law + &load,
            Direction::Backward => format!("{law}{load}{space}[{speed} < 0]"),
        }
    }

    /// Whether it is dry or viscous friction or an offset, alike in both directions: what a robot file can
    /// hold, but for a load.
    pub fn is_straight(&self) -> bool {
        let is_bent = matches!(self.law, FrictionLaw::Stribeck { .. } | FrictionLaw::Dahl { .. });
        !is_bent && self.direction.is_both()
    }

    /// Whether it knows the direction of the shaft at most, neither its speed nor a load.
    pub fn is_speedless(&self) -> bool {
        let has_speed = matches!(self.law, FrictionLaw::Viscous | FrictionLaw::Stribeck { .. });
        !has_speed && !self.load
    }

    /// The shaft as a sum over its joints: `dq5 + dq6`, `dq5 - 0.5*dq6`.
    pub(crate) fn sum(&self, letter: &str, times: &str) -> String {
        sum_of(self.shaft.iter().copied(), [" + ", " - "], letter, times)
    }
}

/// Σ kⱼ·letterⱼ over the joints whose k is not zero, joints counted from 1.
pub(crate) fn sum_of(
    multiples: impl Iterator<Item = f64>,
    [plus, minus]: [&str; 2],
    letter: &str,
    times: &str,
) -> String {
    let mut text = String::new();
    for (joint, k) in multiples.enumerate().filter(|(_, k)| *k != 0.0) {
        text.push_str(match (k < 0.0, text.is_empty()) {
            (true, true) => "-",
            (true, false) => minus,
            (false, true) => "",
            (false, false) => plus,
        });
        if (k.abs() - 1.0).abs() > f64::EPSILON {
            // Writing to a String cannot fail.
            let _ = write!(text, "{}{times}", k.abs());
        }
        text += &indexed(letter, joint);
    }
    text
}

/// A letter with its joint, counted from 1: `q2`, in LaTeX `q_{2}`.
pub(crate) fn indexed(letter: &str, joint: usize) -> String {
    let [open, close] = if letter.ends_with('_') { ["{", "}"] } else { ["", ""] };
    format!("{letter}{open}{}{close}", joint + 1)
}

/// What the symbols of formulas mean that occur in lines of text.
pub(crate) fn legend(lines: &[String]) -> Option<String> {
    let known = [
        (" < 0]", "[dq < 0]: 1 in that direction, else 0"),
        ("dahl(", "dahl(q, d): state of a Dahl element of travel d, ±1 after a long way"),
        ("*|G", "|G1|: size of the load of gravity and springs on joint 1 [N·m]"),
    ];
    let occurs = |symbol: &str| lines.iter().any(|line| line.contains(symbol));
    let words: Vec<_> = known.into_iter().filter(|own| occurs(own.0)).map(|own| own.1).collect();
    (!words.is_empty()).then(|| words.join("; "))
}
