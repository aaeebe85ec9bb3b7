//! Products of sines and cosines as sums of sines and cosines of summed angles.

use crate::term::{Factor, Term, Trig};
use std::collections::BTreeMap;
use std::ops::Range;

/// sin(k·q) or cos(k·q).
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Harmonic {
    function: Trig,
    /// Integer multiple k of each joint angle, n.
    multiples: Vec<i32>,
}

impl Harmonic {
    /// As factors of a term: one, or none for cos 0; no answer where a term cannot hold it.
    fn factors(self) -> Option<Vec<Factor>> {
        if self.multiples.iter().all(|&k| k == 0) {
            return Some(Vec::new());
        }
        let multiples: Result<Vec<i8>, _> =
            self.multiples.iter().map(|&k| i8::try_from(k)).collect();
        let multiples = multiples.ok()?;
        Some(vec![Factor { multiples, function: self.function, power: 1 }])
    }

    /// With the first multiple positive, and the sign that takes; 0 for sin 0.
    fn signed(mut self) -> (f64, Self) {
        let first = self.multiples.iter().find(|k| **k != 0).copied();
        let sign = match (first, self.function) {
            (None, Trig::Sin) => 0.0,
            (Some(k), Trig::Sin) if k < 0 => -1.0,
            _ => 1.0,
        };
        if first.is_some_and(|k| k < 0) {
            self.multiples.iter_mut().for_each(|k| *k = -*k);
        }
        (sign, self)
    }
}

/// A term with its functions of some joints alone as sines and cosines of summed angles, each with
/// its share; `None` where that takes more than `most`, or a multiple is too large for a term.
pub fn summed_angles(term: &Term, joints: &Range<usize>, most: usize) -> Option<Vec<(f64, Term)>> {
    // Positions of what slides stay as they are, as does what other joints turn.
    let is_inside = |factor: &Factor| {
        let mut turned = factor.multiples.iter().enumerate().filter(|(_, k)| **k != 0);
        factor.function != Trig::Position && turned.all(|(joint, _)| joints.contains(&joint))
    };
    let (inside, outside): (Vec<_>, Vec<_>) = term.factors.iter().cloned().partition(is_inside);
    let whole = |(harmonic, share): (Harmonic, f64)| {
        let mut factors = outside.clone();
        factors.extend(harmonic.factors()?);
        factors.sort();
        Some((share, Term { factors, ..term.clone() }))
    };
    let one = Harmonic { function: Trig::Cos, multiples: vec![0; term.n_joints()] };
    let mut sum = BTreeMap::from([(one, 1.0)]);
    for factor in inside.iter().flat_map(|own| std::iter::repeat_n(own, own.power.into())) {
        let mut longer: BTreeMap<Harmonic, f64> = BTreeMap::new();
        for (share, harmonic) in sum.iter().flat_map(|(left, &s)| times(s, left, factor)) {
            *longer.entry(harmonic).or_insert(0.0) += share;
        }
        longer.retain(|_, share| *share != 0.0);
        if longer.len() > most {
            return None;
        }
        sum = longer;
    }
    sum.into_iter().map(whole).collect()
}

/// 2 cos a cos b = cos(a − b) + cos(a + b), and so on.
fn times(share: f64, left: &Harmonic, right: &Factor) -> [(f64, Harmonic); 2] {
    let with = |sign: i32| -> Vec<i32> {
        let right = right.multiples.iter().map(|&k| sign * i32::from(k));
        left.multiples.iter().zip(right).map(|(a, b)| a + b).collect()
    };
    let are_sines = (left.function == Trig::Sin, right.function == Trig::Sin);
    let (function, sign_of_difference, sign_of_sum) = match are_sines {
        (false, false) => (Trig::Cos, 1.0, 1.0),
        (true, true) => (Trig::Cos, 1.0, -1.0),
        (true, false) => (Trig::Sin, 1.0, 1.0),
        (false, true) => (Trig::Sin, -1.0, 1.0),
    };
    [(-1, sign_of_difference), (1, sign_of_sum)].map(|(direction, sign)| {
        let (own, harmonic) = Harmonic { function, multiples: with(direction) }.signed();
        (0.5 * share * sign * own, harmonic)
    })
}
