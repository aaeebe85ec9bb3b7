//! Atoms: one harmonic times one monomial, the letters of every library.

use std::collections::BTreeMap;

/// Which of the two real functions of a harmonic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Phase {
    /// cos(k·θ)
    Cos,
    /// sin(k·θ)
    Sin,
}

/// cos(k·θ) or sin(k·θ); the first non-zero entry of k is positive, so that no function
/// has two names.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Wave {
    multiples: Vec<i8>,
    phase: Phase,
}

impl Wave {
    /// The constant 1 = cos(0·θ).
    pub fn one(n_angles: usize) -> Self {
        Self { multiples: vec![0; n_angles], phase: Phase::Cos }
    }

    /// ±cos(k·θ) or ±sin(k·θ) with its sign, for any k; `None` for sin(0), which is zero.
    pub fn canonical(mut multiples: Vec<i8>, phase: Phase) -> Option<(f64, Self)> {
        let lead = multiples.iter().copied().find(|&k| k != 0).unwrap_or(0);
        if lead < 0 {
            multiples = multiples.into_iter().map(|k| -k).collect();
        }
        let sign = if phase == Phase::Sin { f64::from(lead.signum()) } else { 1.0 };
        (sign != 0.0).then_some((sign, Self { multiples, phase }))
    }

    /// The integer multiples k of the angles.
    pub fn multiples(&self) -> &[i8] {
        &self.multiples
    }

    /// Cosine or sine.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// The product of two waves as a sum of at most two: ½ times the signed waves returned.
    pub fn product(&self, other: &Self) -> [Option<(f64, Self)>; 2] {
        let combine = |sign: i8| -> Vec<i8> {
            self.multiples.iter().zip(&other.multiples).map(|(a, b)| a + sign * b).collect()
        };
        let signed = |sign: f64, k: Vec<i8>, phase| {
            Self::canonical(k, phase).map(|(flip, wave)| (sign * flip, wave))
        };
        let (phase, signs) = match (self.phase, other.phase) {
            (Phase::Cos, Phase::Cos) => (Phase::Cos, [1.0, 1.0]),
            (Phase::Sin, Phase::Sin) => (Phase::Cos, [1.0, -1.0]),
            (Phase::Sin, Phase::Cos) => (Phase::Sin, [1.0, 1.0]),
            (Phase::Cos, Phase::Sin) => (Phase::Sin, [-1.0, 1.0]),
        };
        [signed(signs[0], combine(-1), phase), signed(signs[1], combine(1), phase)]
    }
}

/// x^α = Π xⱼ^αⱼ.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Monomial {
    /// α
    pub powers: Vec<u8>,
}

/// A weighted harmonic × monomial.
#[derive(Clone, Debug, PartialEq)]
pub struct Atom {
    /// Its weight in a column.
    pub weight: f64,
    /// Its harmonic.
    pub wave: Wave,
    /// Its monomial.
    pub monomial: Monomial,
}

/// Numbers distinct values in the order they come.
#[derive(Debug)]
pub struct Numbering<T>(BTreeMap<T, usize>);

impl<T> Default for Numbering<T> {
    fn default() -> Self {
        Self(BTreeMap::new())
    }
}

impl<T: Ord> Numbering<T> {
    /// The number of a value, the next one if it is new.
    pub fn place(&mut self, value: T) -> usize {
        let next = self.0.len();
        *self.0.entry(value).or_insert(next)
    }

    /// The values in the order of their numbers.
    pub fn into_values(self) -> Vec<T> {
        let mut values = Vec::from_iter(self.0);
        values.sort_unstable_by_key(|(_, place)| *place);
        values.into_iter().map(|(value, _)| value).collect()
    }
}
