//! All energy terms of a chain → the few that its torque needs, on states like those of the log.

use faer::Mat;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use torquewise_model::{EnergyTerm, Place, Trig};
use torquewise_motion::Motion;

/// States that terms are judged on: half of them of the log, half with its parts mixed anew.
const STATES: usize = 400;
/// Part of the residual that the terms left out may add, RMS.
const TOLERANCE: f64 = 0.1;
/// Part of the tolerance spent on terms so small that a bound on their torque suffices.
const GLANCE: f64 = 0.05;

/// Sines and cosines of states: `[state][joint]` → cos q, sin q, cos 2q, sin 2q.
struct States {
    n: usize,
    waves: Vec<[f64; 4]>,
    dq: Vec<f64>,
    ddq: Vec<f64>,
}

/// Keeps the terms without which the torque of some joint would be off by more than a tenth of the
/// residual.
///
/// - `terms`: energy terms with their coefficients
/// - `residual_rms`: what the chain leaves of the torque of each joint \[N·m\], n
pub(crate) fn prune(
    terms: Vec<(EnergyTerm, f64)>,
    motion: &Motion,
    residual_rms: &[f64],
    seed: u64,
) -> Vec<(EnergyTerm, f64)> {
    let states = States::new(motion, seed);
    let tolerance: Vec<f64> = residual_rms.iter().map(|rms| TOLERANCE * rms).collect();
    let terms = glance(terms, &states, &tolerance);
    let size = |loads: &Mat<f64>| -> f64 {
        let parts = loads.col_iter().zip(&tolerance).map(|(x, limit)| x.norm_l2() / limit);
        parts.fold(0.0, f64::max)
    };
    let mut order: Vec<usize> = (0..terms.len()).collect();
    let loads = |place: usize| states.loads(&terms[place].0, terms[place].1);
    let sizes: Vec<f64> = (0..terms.len()).into_par_iter().map(|k| size(&loads(k))).collect();
    order.sort_by(|&a, &b| sizes[a].total_cmp(&sizes[b]).then(a.cmp(&b)));
    let limit = (states.len() as f64).sqrt() * (1.0 - GLANCE);
    let mut left_out = Mat::<f64>::zeros(states.len(), states.n);
    let mut kept = vec![true; terms.len()];
    for place in order {
        let more = &left_out + &loads(place);
        if size(&more) > limit {
            break;
        }
        (left_out, kept[place]) = (more, false);
    }
    let mut kept = kept.into_iter();
    terms.into_iter().filter(|_| kept.next().unwrap_or(true)).collect()
}

/// Drops the terms that no state can make matter.
fn glance(
    terms: Vec<(EnergyTerm, f64)>,
    states: &States,
    tolerance: &[f64],
) -> Vec<(EnergyTerm, f64)> {
    let [dq, ddq] =
        [&states.dq, &states.ddq].map(|x| x.iter().fold(0.0_f64, |most, x| most.max(x.abs())));
    let inertial = 2.0 * ddq + 6.0 * states.n as f64 * dq * dq;
    let bound = |(term, coefficient): &(EnergyTerm, f64)| {
        coefficient.abs() * if term.place == Place::Potential { 1.0 } else { inertial }
    };
    let least = tolerance.iter().copied().fold(f64::INFINITY, f64::min);
    let budget = (GLANCE * least).powi(2);
    let mut bounds: Vec<f64> = terms.iter().map(bound).collect();
    bounds.sort_by(f64::total_cmp);
    let mut spent = 0.0;
    let mut floor = 0.0;
    for bound in bounds {
        spent += bound * bound;
        if spent > budget {
            break;
        }
        floor = bound;
    }
    terms.into_iter().filter(|term| bound(term) > floor).collect()
}

impl States {
    fn new(motion: &Motion, seed: u64) -> Self {
        let (m, n) = (motion.n_rows(), motion.n_joints());
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut states = Self { n, waves: Vec::new(), dq: Vec::new(), ddq: Vec::new() };
        for state in 0..STATES.min(2 * m) {
            let own = (state / 2) * m / STATES.min(2 * m).div_ceil(2);
            let mut row = || if state % 2 == 0 { own } else { random.random_range(0..m) };
            let rows = [row(), row(), row()];
            for joint in 0..n {
                let q = motion.q()[(rows[0], joint)];
                let (sin, cos) = q.sin_cos();
                let (sin2, cos2) = (2.0 * q).sin_cos();
                states.waves.push([cos, sin, cos2, sin2]);
                states.dq.push(motion.dq()[(rows[1], joint)]);
                states.ddq.push(motion.ddq()[(rows[2], joint)]);
            }
        }
        states
    }

    fn len(&self) -> usize {
        self.waves.len() / self.n
    }

    /// Torque of a term on all states, states×n: d/dt ∂T/∂q̇ − ∂T/∂q + ∂V/∂q (E4).
    fn loads(&self, term: &EnergyTerm, coefficient: f64) -> Mat<f64> {
        let mut loads = Mat::zeros(self.len(), self.n);
        let mut slope = vec![0.0; self.n];
        for state in 0..self.len() {
            let own = state * self.n..(state + 1) * self.n;
            let (dq, ddq) = (&self.dq[own.clone()], &self.ddq[own.clone()]);
            let value = coefficient * value(term, &self.waves[own], &mut slope);
            for slope in &mut slope {
                *slope *= coefficient;
            }
            let Place::Inertia(i, j) = term.place else {
                slope.iter().enumerate().for_each(|(joint, s)| loads[(state, joint)] = *s);
                continue;
            };
            let change: f64 = slope.iter().zip(dq).map(|(s, v)| s * v).sum();
            let share = if i == j { 0.5 } else { 1.0 };
            for (joint, s) in slope.iter().enumerate() {
                loads[(state, joint)] -= share * s * dq[i] * dq[j];
            }
            for (own, other) in [(i, j), (j, i)] {
                loads[(state, own)] += share * (change * dq[other] + value * ddq[other]);
            }
        }
        loads
    }
}

/// Value of the function of a term and its slope along each joint.
fn value(term: &EnergyTerm, waves: &[[f64; 4]], slope: &mut [f64]) -> f64 {
    slope.fill(0.0);
    let factors = &term.function.factors;
    let parts: Vec<[f64; 2]> = factors
        .iter()
        .map(|factor| {
            let (sin, cos) = turn(&factor.multiples, waves);
            match factor.function {
                Trig::Cos => [cos, -sin],
                Trig::Sin => [sin, cos],
            }
        })
        .collect();
    for (place, factor) in factors.iter().enumerate() {
        let others = parts.iter().enumerate().filter(|(other, _)| *other != place);
        let rest = parts[place][1] * others.map(|(_, part)| part[0]).product::<f64>();
        for (slope, &k) in slope.iter_mut().zip(&factor.multiples) {
            *slope += f64::from(k) * rest;
        }
    }
    parts.iter().map(|part| part[0]).product()
}

/// Sine and cosine of a sum of joint angles.
fn turn(multiples: &[i8], waves: &[[f64; 4]]) -> (f64, f64) {
    let (mut sin, mut cos) = (0.0, 1.0);
    for (&k, &[c1, s1, c2, s2]) in multiples.iter().zip(waves).filter(|(k, _)| **k != 0) {
        let (c, s) = match k.unsigned_abs() {
            1 => (c1, s1),
            2 => (c2, s2),
            // Springs alone hold higher harmonics.
            k => {
                let (sin, cos) = (f64::from(k) * s1.atan2(c1)).sin_cos();
                (cos, sin)
            }
        };
        let s = f64::from(k.signum()) * s;
        (sin, cos) = (sin * c + cos * s, cos * c - sin * s);
    }
    (sin, cos)
}

#[cfg(test)]
mod tests;
