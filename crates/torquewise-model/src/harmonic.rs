//! Products of sines and cosines as sums of sines and cosines of summed angles.

use crate::{Factor, Term, Trig};
use std::ops::Range;
use torquewise_regression::atom::{Phase, Wave};

/// The trigonometric part of a term, times a weight, as a sum of harmonics of joint sums.
pub fn waves_of(weight: f64, term: &Term) -> Vec<(f64, Wave)> {
    few_waves_of(weight, term, usize::MAX).unwrap_or_default()
}

/// The same; `None` where that takes more than `most` on the way.
fn few_waves_of(weight: f64, term: &Term, most: usize) -> Option<Vec<(f64, Wave)>> {
    let mut waves = vec![(weight, Wave::one(term.n_joints()))];
    for factor in &term.factors {
        let phase = if factor.function == Trig::Sin { Phase::Sin } else { Phase::Cos };
        let Some((sign, wave)) = Wave::canonical(factor.multiples.clone(), phase) else {
            return Some(Vec::new());
        };
        for _ in 0..factor.power {
            let mut out: Vec<(f64, Wave)> = Vec::new();
            let products = waves.iter().flat_map(|(weight, left)| {
                let all = left.product(&wave).into_iter().flatten();
                all.map(move |(flip, product)| (0.5 * weight * sign * flip, product))
            });
            for (share, product) in products {
                match out.iter_mut().find(|(_, known)| *known == product) {
                    Some((known, _)) => *known += share,
                    None => out.push((share, product)),
                }
            }
            out.retain(|(weight, _)| *weight != 0.0);
            if out.len() > most {
                return None;
            }
            waves = out;
        }
    }
    Some(waves)
}

/// A harmonic as factors of a term: one, or none for the constant 1.
pub fn factors_of(wave: &Wave) -> Vec<Factor> {
    let multiples = wave.multiples().to_vec();
    if multiples.iter().all(|&k| k == 0) {
        return Vec::new();
    }
    let function = if wave.phase() == Phase::Sin { Trig::Sin } else { Trig::Cos };
    vec![Factor { multiples, function, power: 1 }]
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
    let multiple = |factor: &Factor, joint: usize| {
        u32::from(factor.multiples[joint].unsigned_abs()) * u32::from(factor.power)
    };
    let largest = |joint| inside.iter().map(|factor| multiple(factor, joint)).sum::<u32>();
    if joints.clone().any(|joint| i8::try_from(largest(joint)).is_err()) {
        return None;
    }
    let whole = |(share, wave): (f64, Wave)| {
        let mut factors = [&outside[..], &factors_of(&wave)].concat();
        factors.sort();
        (share, Term { factors, ..term.clone() })
    };
    let waves = few_waves_of(1.0, &Term { factors: inside, ..term.clone() }, most)?;
    Some(waves.into_iter().map(whole).collect())
}
