//! From arm to true coefficients: M(q) and V(q) in the energy library, torque in the product
//! library.

use faer::Mat;
use faer::prelude::SolveLstsq;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;
use torquewise_model::library::{angle_functions, energy_library};
use torquewise_model::{EnergyTerm, Place, Term};
use torquewise_sim::Arm;

/// Weights below this are rounding, in the units of the coefficients.
const ROUNDING: f64 = 1e-10;
/// Sines and cosines in a product of the torque of a serial arm.
const TRIG_ORDER: u8 = 4;
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
            Place::Inertia(i, j) => project(&functions, |q| vec![arm.mass_matrix(q)[(i, j)]]),
            Place::Potential => {
                // The potential is known up to a constant, which no torque shows.
                functions.push(Term::one(n));
                project(&functions, |q| vec![arm.potential_energy(q)])
            }
        };
        let known = terms.into_iter().enumerate().map(|(row, term)| (term, weights[(row, 0)]));
        found.extend(known.filter(|(_, weight)| weight.abs() > ROUNDING));
    }
    found
}

/// The coefficients of the torque of all joints in the functions of the product library \[E2\]: what
/// a perfect regression over that library finds.
pub(crate) fn true_products(arm: &Arm) -> Vec<f64> {
    let n = arm.n_joints();
    let rest = vec![0.0; n];
    let moving = |joints: &[usize]| -> Vec<f64> {
        (0..n).map(|joint| if joints.contains(&joint) { 1.0 } else { 0.0 }).collect()
    };
    let weights = project(&angle_functions(n, TRIG_ORDER), |q| {
        let gravity = arm.inverse_dynamics(q, &rest, &rest);
        let beyond = |dq: &[f64], ddq: &[f64]| -> Vec<f64> {
            let torque = arm.inverse_dynamics(q, dq, ddq);
            torque.iter().zip(&gravity).map(|(torque, gravity)| torque - gravity).collect()
        };
        let mut values = gravity.clone();
        for j in 0..n {
            values.extend(beyond(&rest, &moving(&[j])));
            let squared = beyond(&moving(&[j]), &rest);
            for k in 0..j {
                let both = beyond(&moving(&[j, k]), &rest);
                let other = beyond(&moving(&[k]), &rest);
                values.extend((0..n).map(|i| both[i] - squared[i] - other[i]));
            }
            values.extend(squared);
        }
        values
    });
    weights
        .col_iter()
        .flat_map(|column| column.iter().copied().collect::<Vec<_>>())
        .filter(|weight| weight.abs() > ROUNDING)
        .collect()
}

/// Weights of functions of the angles in some values, functions × values, by least squares at more
/// random states than there are functions.
fn project(functions: &[Term], values: impl Fn(&[f64]) -> Vec<f64>) -> Mat<f64> {
    let n = functions[0].n_joints();
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let count = LEAST_STATES.max(STATES_PER_FUNCTION * functions.len());
    let mut state = || (0..n).map(|_| random.random_range(-3.0..3.0)).collect();
    let states: Vec<Vec<f64>> = (0..count).map(|_| state()).collect();
    let rest = vec![0.0; n];
    let columns = Mat::from_fn(count, functions.len(), |row, j| {
        functions[j].value(&states[row], &rest, &rest)
    });
    let values: Vec<Vec<f64>> = states.iter().map(|q| values(q)).collect();
    let values = Mat::from_fn(count, values[0].len(), |row, k| values[row][k]);
    columns.qr().solve_lstsq(&values)
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

        assert_eq!((energies.len(), true_products(&arm).len()), (23, 74));
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
