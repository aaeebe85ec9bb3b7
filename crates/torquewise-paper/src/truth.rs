//! From arm to true coefficients: M(q) and V(q) in the energy library, torque in products.

use faer::prelude::SolveLstsq;
use faer::{Col, Mat};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;
use torquewise_model::library::energy_library;
use torquewise_model::{EnergyTerm, Place, Term};
use torquewise_sim::Arm;

/// Weights below this are rounding, in the units of the coefficients.
const ROUNDING: f64 = 1e-10;
/// States per function that is fitted to them.
const STATES_PER_FUNCTION: usize = 4;
const LEAST_STATES: usize = 400;
/// Any seed will do: the functions are exact everywhere.
const SEED: u64 = 20;

/// The energies of an arm: each function of the energy library \[E4\] that M(q) or V(q) holds, with
/// its coefficient in SI units.
///
/// Exact up to rounding, since the library holds all that a serial arm of revolute joints can need.
/// Checked against: Pinocchio, by way of the arm, and the reference arm's known 23 terms.
pub(crate) fn true_energies(arm: &Arm) -> BTreeMap<EnergyTerm, f64> {
    let n = arm.n_joints();
    let mut places: BTreeMap<Place, Vec<EnergyTerm>> = BTreeMap::new();
    for term in energy_library(n, None) {
        places.entry(term.place).or_default().push(term);
    }
    let mut found = BTreeMap::new();
    for (place, terms) in places {
        let mut functions: Vec<Term> = terms.iter().map(|term| term.function.clone()).collect();
        let weights = match place {
            Place::Inertia(i, j) => project(&functions, |q| arm.mass_matrix(q)[(i, j)]),
            Place::Potential => {
                // The potential is known up to a constant, which no torque shows.
                functions.push(Term::one(n));
                project(&functions, |q| arm.potential_energy(q))
            }
        };
        let known = terms.into_iter().zip(weights.iter().copied());
        found.extend(known.filter(|(_, weight)| weight.abs() > ROUNDING));
    }
    found
}

/// The coefficients of the torque of all joints in the functions of the product library \[E2\]: what
/// a perfect regression over that library finds.
pub(crate) fn true_products(energies: &BTreeMap<EnergyTerm, f64>, n_joints: usize) -> Vec<f64> {
    let mut products = BTreeMap::new();
    for (energy, coefficient) in energies {
        for joint in 0..n_joints {
            for (weight, term) in energy.torque(joint) {
                *products.entry((joint, term)).or_insert(0.0) += coefficient * weight;
            }
        }
    }
    products.into_values().filter(|weight: &f64| weight.abs() > ROUNDING).collect()
}

/// Weights of functions of the angles in a value, by least squares at more random states than there
/// are functions.
fn project(functions: &[Term], value: impl Fn(&[f64]) -> f64) -> Col<f64> {
    let n = functions[0].n_joints();
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let count = LEAST_STATES.max(STATES_PER_FUNCTION * functions.len());
    let mut state = || (0..n).map(|_| random.random_range(-3.0..3.0)).collect();
    let states: Vec<Vec<f64>> = (0..count).map(|_| state()).collect();
    let rest = vec![0.0; n];
    let columns = Mat::from_fn(count, functions.len(), |row, j| {
        functions[j].value(&states[row], &rest, &rest)
    });
    columns.qr().solve_lstsq(&Col::from_fn(count, |row| value(&states[row])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reference_arm_has_23_energies_whose_torque_has_74_products() {
        let arm = Arm::builtin("puma560-3").unwrap();
        let energies = true_energies(&arm);
        let (q, dq, ddq) = ([0.3, -0.8, 1.1], [0.7, -0.4, 1.3], [-2.0, 0.5, 0.9]);

        let expected = arm.inverse_dynamics(&q, &dq, &ddq);

        assert_eq!((energies.len(), true_products(&energies, 3).len()), (23, 74));
        for (joint, expected) in expected.into_iter().enumerate() {
            let parts = energies.iter().flat_map(|(energy, coefficient)| {
                let torque = energy.torque(joint).into_iter();
                torque.map(move |(weight, term)| coefficient * weight * term.value(&q, &dq, &ddq))
            });
            let found: f64 = parts.sum();
            // Some hundred terms of up to a hundred N·m.
            assert!((found - expected).abs() < 1e-9, "joint {joint}: {found} {expected}");
        }
    }
}
