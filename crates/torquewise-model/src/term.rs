//! Terms: products of sines and cosines, or slide positions, with velocities, accelerations.

use crate::friction::{indexed, sum_of};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Sine or cosine; of a sliding joint, the position itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Trig {
    /// sin
    Sin,
    /// cos
    Cos,
    /// The position \[m\] of a joint that slides.
    Position,
}

/// sin(k·q)^power or cos(k·q)^power, or (k·q)^power of a joint that slides.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Factor {
    /// Integer multiple k of each joint angle, n.
    pub multiples: Vec<i8>,
    /// Sine, cosine or position.
    pub function: Trig,
    /// Its power, at least 1.
    pub power: u8,
}

/// Which part of the torque a term belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// F(q̇); a [`Term`] is never of this kind, a [`FrictionTerm`](crate::FrictionTerm) always.
    Friction,
    /// G(q)
    Gravity,
    /// C(q, q̇)q̇
    Coriolis,
    /// M(q)q̈
    Inertia,
}

/// A function of the state: a product of sines and cosines, velocities and accelerations.
///
/// Reads as `sin(q2)*cos(q3)*dq1*dq2`; no factor at all is the constant 1.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Term {
    /// Functions of the joint angles.
    pub factors: Vec<Factor>,
    /// Power of each joint velocity, n.
    pub dq: Vec<u8>,
    /// Power of each joint acceleration, n.
    pub ddq: Vec<u8>,
}

/// A sum of terms, each with its weight.
pub type Sum = Vec<(f64, Term)>;

impl Term {
    /// The constant 1 of n joints.
    pub fn one(n_joints: usize) -> Self {
        Self { factors: Vec::new(), dq: vec![0; n_joints], ddq: vec![0; n_joints] }
    }

    /// Number of joints n.
    pub fn n_joints(&self) -> usize {
        self.dq.len()
    }

    /// The same term times sin(multiple·q_joint) or cos(multiple·q_joint) to a power; power 0
    /// leaves it as it is.
    pub fn times(mut self, function: Trig, joint: usize, multiple: i8, power: u8) -> Self {
        if power > 0 {
            let mut multiples = vec![0; self.n_joints()];
            multiples[joint] = multiple;
            self.factors.push(Factor { multiples, function, power });
        }
        self
    }

    /// The same term times q̇_joint.
    pub fn times_dq(mut self, joint: usize) -> Self {
        self.dq[joint] += 1;
        self
    }

    /// The same term times q̈_joint.
    pub fn times_ddq(mut self, joint: usize) -> Self {
        self.ddq[joint] += 1;
        self
    }

    /// The part of the torque it belongs to: inertia if it holds an acceleration, Coriolis if only
    /// velocities, gravity if neither.
    pub fn kind(&self) -> Kind {
        if self.ddq.iter().any(|&power| power > 0) {
            Kind::Inertia
        } else if self.dq.iter().any(|&power| power > 0) {
            Kind::Coriolis
        } else {
            Kind::Gravity
        }
    }

    /// Number of joints whose angle it depends on.
    pub fn interaction(&self) -> usize {
        (0..self.n_joints()).filter(|&joint| self.depends_on(joint)).count()
    }

    /// Whether it depends on the angle of a joint.
    pub fn depends_on(&self, joint: usize) -> bool {
        self.factors.iter().any(|factor| factor.multiples[joint] != 0)
    }

    /// ∂/∂q_joint as a sum of terms; empty where it is zero.
    pub fn derivative(&self, joint: usize) -> Sum {
        let mut sum = Sum::new();
        for (place, factor) in self.factors.iter().enumerate() {
            let inner = f64::from(factor.multiples[joint]) * f64::from(factor.power);
            if inner == 0.0 {
                continue;
            }
            let (sign, other) = match factor.function {
                Trig::Sin => (1.0, Some(Trig::Cos)),
                Trig::Cos => (-1.0, Some(Trig::Sin)),
                Trig::Position => (1.0, None),
            };
            let mut term = self.clone();
            if factor.power == 1 {
                term.factors.remove(place);
            } else {
                term.factors[place].power -= 1;
            }
            let inner_slope = other.map(|function| Factor { function, power: 1, ..factor.clone() });
            term.factors.extend(inner_slope);
            sum.push((sign * inner, term.tidied()));
        }
        collect(sum)
    }

    /// Factors in order, equal ones joined, so that equal terms compare equal.
    fn tidied(mut self) -> Self {
        self.factors.sort();
        self.factors.dedup_by(|next, kept| {
            let same = next.multiples == kept.multiples && next.function == kept.function;
            if same {
                kept.power += next.power;
            }
            same
        });
        self
    }

    /// Value at a state: q \[rad\], dq \[rad/s\], ddq \[rad/s²\], n each.
    pub fn value(&self, q: &[f64], dq: &[f64], ddq: &[f64]) -> f64 {
        let angles: f64 = self.factors.iter().map(|factor| factor.value(q)).product();
        angles * powers(&self.dq, dq) * powers(&self.ddq, ddq)
    }

    /// Readable name, joints counted from 1: `sin(q2)*cos(q3)*dq1*dq2`.
    pub fn name(&self) -> String {
        let name = self.written(false);
        if name.is_empty() { "1".into() } else { name }
    }

    /// The same in LaTeX: `\sin q_{2} \cos q_{3}\, \dot q_{1} \dot q_{2}`.
    pub fn latex(&self) -> String {
        self.written(true)
    }

    fn written(&self, is_latex: bool) -> String {
        let [dq, ddq, times] =
            if is_latex { [r"\dot q_", r"\ddot q_", r"\,"] } else { ["dq", "ddq", "*"] };
        let mut parts: Vec<_> = self.factors.iter().map(|own| own.written(is_latex)).collect();
        for (letter, all) in [(dq, &self.dq), (ddq, &self.ddq)] {
            for (joint, &power) in all.iter().enumerate().filter(|&(_, &power)| power > 0) {
                parts.push(indexed(letter, joint) + &exponent(power, is_latex));
            }
        }
        parts.join(times)
    }
}

impl Factor {
    /// Value at joint positions q \[rad, m\], n.
    pub fn value(&self, q: &[f64]) -> f64 {
        let angle: f64 = self.multiples.iter().zip(q).map(|(&k, q)| f64::from(k) * q).sum();
        let base = match self.function {
            Trig::Sin => angle.sin(),
            Trig::Cos => angle.cos(),
            Trig::Position => angle,
        };
        base.powi(i32::from(self.power))
    }

    fn written(&self, is_latex: bool) -> String {
        let [sin, cos, q, times] =
            if is_latex { [r"\sin", r"\cos", "q_", r"\,"] } else { ["sin", "cos", "q", "*"] };
        let multiples = self.multiples.iter().map(|&k| f64::from(k));
        let angle = sum_of(multiples, ["+", "-"], q, times);
        let power = exponent(self.power, is_latex);
        let function = match self.function {
            Trig::Sin => sin,
            Trig::Cos => cos,
            Trig::Position if self.is_plain() => return angle + &power,
            Trig::Position => return format!("({angle}){power}"),
        };
        match (is_latex, self.is_plain()) {
            (false, _) => format!("{function}({angle}){power}"),
            (true, true) => format!("{function}{power} {angle}"),
            (true, false) => format!("{function}{power}({angle})"),
        }
    }

    /// Whether it is a function of one angle, once.
    fn is_plain(&self) -> bool {
        self.multiples.iter().filter(|&&k| k != 0).count() == 1 && self.multiples.contains(&1)
    }
}

fn exponent(power: u8, is_latex: bool) -> String {
    let [open, close] = if is_latex { ["{", "}"] } else { ["", ""] };
    if power > 1 { format!("^{open}{power}{close}") } else { String::new() }
}

fn powers(powers: &[u8], x: &[f64]) -> f64 {
    powers.iter().zip(x).map(|(&power, x)| x.powi(i32::from(power))).product()
}

/// The same sum with equal terms joined, in the order of the terms, and zeros left out.
pub fn collect(sum: Sum) -> Sum {
    let mut terms: BTreeMap<Term, f64> = BTreeMap::new();
    for (weight, term) in sum {
        *terms.entry(term.tidied()).or_insert(0.0) += weight;
    }
    terms.into_iter().filter(|&(_, weight)| weight != 0.0).map(|(t, w)| (w, t)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Term {
        Term::one(3).times(Trig::Sin, 1, 1, 1).times(Trig::Cos, 2, 1, 2).times_dq(0).times_dq(1)
    }

    #[test]
    fn a_term_reads_as_its_formula() {
        assert_eq!(sample().name(), "sin(q2)*cos(q3)^2*dq1*dq2");
        assert_eq!(Term::one(2).name(), "1");
        assert_eq!(sample().latex(), r"\sin q_{2}\,\cos^{2} q_{3}\,\dot q_{1}\,\dot q_{2}");
    }

    #[test]
    fn the_derivative_is_the_slope_of_the_value() {
        let (q, dq, ddq) = ([0.3, -0.8, 1.1], [0.5, 0.7, -0.2], [0.0; 3]);
        let h = 1e-6;

        for joint in 0..3 {
            let mut ahead = q;
            let mut behind = q;
            ahead[joint] += h;
            behind[joint] -= h;
            let slope = (sample().value(&ahead, &dq, &ddq) - sample().value(&behind, &dq, &ddq))
                / (2.0 * h);
            let exact: f64 = sample()
                .derivative(joint)
                .iter()
                .map(|(weight, term)| weight * term.value(&q, &dq, &ddq))
                .sum();
            // Central difference: h² truncation, ε/h rounding.
            assert!((slope - exact).abs() < 1e-9, "{joint}: {slope} {exact}");
        }
    }
}
