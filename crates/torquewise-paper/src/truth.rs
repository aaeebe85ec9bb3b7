//! From arm to true coefficients: M(q) and V(q) in the energy library, torque in the product
//! library.

use faer::Mat;
use faer::prelude::SolveLstsq;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;
use torquewise_model::library::energy_library;
use torquewise_model::term::Sum;
use torquewise_model::{EnergyTerm, Place, Term, Trig};
use torquewise_sim::Arm;

/// Weights below this are rounding, in the units of the coefficients.
const ROUNDING: f64 = 1e-12;
/// States per function that is fitted to them.
const STATES_PER_FUNCTION: usize = 4;
const LEAST_STATES: usize = 400;
/// Any seed will do: the functions are exact everywhere.
const SEED: u64 = 20;

/// The energies of an arm: each function of the energy library \[E4\] that M(q) or V(q) holds, with
/// its coefficient in SI units.
///
/// Least squares at more random states than there are functions; exact up to rounding, since the
/// library holds all that a serial arm of revolute joints can need. Checked against: Pinocchio, by
/// way of the arm, and the reference arm's known 23 terms.
pub(crate) fn true_energies(arm: &Arm) -> BTreeMap<EnergyTerm, f64> {
    let n = arm.n_joints();
    let mut places: BTreeMap<Place, Vec<EnergyTerm>> = BTreeMap::new();
    for term in energy_library(n, None) {
        places.entry(term.place).or_default().push(term);
    }
    let most = places.values().map(Vec::len).max().unwrap_or(0);
    let states = random_states(n, LEAST_STATES.max(STATES_PER_FUNCTION * most));
    let mut found = BTreeMap::new();
    for (place, terms) in places {
        let weights = project(arm, place, &terms, &states);
        let known = terms.into_iter().zip(weights);
        found.extend(known.filter(|(_, weight)| weight.abs() > ROUNDING));
    }
    found
}

fn random_states(n: usize, count: usize) -> Vec<Vec<f64>> {
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    (0..count).map(|_| (0..n).map(|_| random.random_range(-3.0..3.0)).collect()).collect()
}

fn project(arm: &Arm, place: Place, terms: &[EnergyTerm], states: &[Vec<f64>]) -> Vec<f64> {
    let rest = vec![0.0; arm.n_joints()];
    // The potential is known up to a constant, which no torque shows.
    let datum = usize::from(place == Place::Potential);
    let columns = Mat::from_fn(states.len(), terms.len() + datum, |row, j| {
        terms.get(j).map_or(1.0, |term| term.function.value(&states[row], &rest, &rest))
    });
    let values = Mat::from_fn(states.len(), 1, |row, _| match place {
        Place::Potential => arm.potential_energy(&states[row]),
        Place::Inertia(i, j) => arm.mass_matrix(&states[row])[(i, j)],
    });
    let weights = columns.qr().solve_lstsq(&values);
    (0..terms.len()).map(|j| weights[(j, 0)]).collect()
}

/// The torque of each joint in the functions of the product library \[E2\], n sums: what a perfect
/// regression over that library finds.
pub(crate) fn true_torques(energies: &BTreeMap<EnergyTerm, f64>, n_joints: usize) -> Vec<Sum> {
    (0..n_joints)
        .map(|joint| {
            let mut products: BTreeMap<Product, f64> = BTreeMap::new();
            for (energy, coefficient) in energies {
                for (weight, term) in energy.torque(joint) {
                    for (share, product) in expanded(&term) {
                        *products.entry(product).or_default() += coefficient * weight * share;
                    }
                }
            }
            let kept = products.into_iter().filter(|(_, weight)| weight.abs() > ROUNDING);
            kept.map(|(product, weight)| (weight, product.term())).collect()
        })
        .collect()
}

/// Powers of sin qⱼ and cos qⱼ of each joint, with the motion they multiply.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Product {
    angles: Vec<[u8; 2]>,
    dq: Vec<u8>,
    ddq: Vec<u8>,
}

impl Product {
    fn term(self) -> Term {
        let n = self.angles.len();
        let mut term = Term { dq: self.dq, ddq: self.ddq, ..Term::one(n) };
        for (joint, [sines, cosines]) in self.angles.into_iter().enumerate() {
            term = term.times(Trig::Sin, joint, 1, sines).times(Trig::Cos, joint, 1, cosines);
        }
        term
    }
}

/// A term of sines and cosines of q and 2q as products of sines and cosines of q, no sine squared.
fn expanded(term: &Term) -> Vec<(f64, Product)> {
    let one = Product {
        angles: vec![[0, 0]; term.n_joints()],
        dq: term.dq.clone(),
        ddq: term.ddq.clone(),
    };
    let mut sum = vec![(1.0, one)];
    for factor in &term.factors {
        let joint = factor.multiples.iter().position(|&multiple| multiple != 0).unwrap_or(0);
        let parts = parts(factor.multiples[joint], factor.function);
        for _ in 0..factor.power {
            sum = sum
                .iter()
                .flat_map(|(weight, product)| times(*weight, product, joint, parts))
                .collect();
        }
    }
    sum
}

/// sin or cos of q or 2q as (weight, power of the sine, power of the cosine).
fn parts(multiple: i8, function: Trig) -> &'static [(f64, u8, u8)] {
    match (multiple.abs(), function) {
        (1, Trig::Sin) => &[(1.0, 1, 0)],
        (1, Trig::Cos) => &[(1.0, 0, 1)],
        (2, Trig::Sin) => &[(2.0, 1, 1)],
        (2, Trig::Cos) => &[(2.0, 0, 2), (-1.0, 0, 0)],
        _ => &[(1.0, 0, 0)],
    }
}

fn times(
    weight: f64,
    product: &Product,
    joint: usize,
    parts: &[(f64, u8, u8)],
) -> Vec<(f64, Product)> {
    let mut sum = Vec::with_capacity(2 * parts.len());
    for &(share, sines, cosines) in parts {
        let mut grown = product.clone();
        let [own_sines, own_cosines] = &mut grown.angles[joint];
        *own_sines += sines;
        *own_cosines += cosines;
        if *own_sines < 2 {
            sum.push((weight * share, grown));
            continue;
        }
        // sin² = 1 − cos²
        *own_sines -= 2;
        let mut squared = grown.clone();
        squared.angles[joint][1] += 2;
        sum.push((weight * share, grown));
        sum.push((-weight * share, squared));
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use torquewise_model::library::{Degree, product_library};

    #[test]
    fn the_reference_arm_has_23_true_energies() {
        assert_eq!(true_energies(&Arm::builtin("puma560-3").unwrap()).len(), 23);
    }

    #[test]
    fn the_true_torques_are_the_torque_of_the_arm() {
        for name in ["planar-2", "puma560-3", "generic-4"] {
            let arm = Arm::builtin(name).unwrap();
            let n = arm.n_joints();
            let torques = true_torques(&true_energies(&arm), n);
            let state: Vec<f64> = (0..3 * n).map(|k| (1.7 * k as f64 + 0.3).sin()).collect();
            let (q, dq, ddq) = (&state[..n], &state[n..2 * n], &state[2 * n..]);

            let expected = arm.inverse_dynamics(q, dq, ddq);

            for (sum, expected) in torques.iter().zip(expected) {
                let found: f64 = sum.iter().map(|(w, term)| w * term.value(q, dq, ddq)).sum();
                // Some hundred terms of up to a hundred N·m.
                assert!((found - expected).abs() < 1e-9, "{name}: {found} {expected}");
            }
        }
    }

    #[test]
    fn the_true_torques_lie_in_the_product_library() {
        let arm = Arm::builtin("puma560-3").unwrap();
        let library: BTreeSet<Term> =
            product_library(3, 4, &Degree::up_to(2)).into_iter().collect();

        let torques = true_torques(&true_energies(&arm), 3);

        assert!(torques.iter().flatten().all(|(_, term)| library.contains(term)));
        assert_eq!(torques.iter().map(Vec::len).collect::<Vec<_>>(), [37, 23, 14]);
    }
}
