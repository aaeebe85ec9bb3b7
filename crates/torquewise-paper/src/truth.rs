//! True coefficients of an arm in the energy and the product library.

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
const STATES_PER_FUNCTION: usize = 4;
/// Any seed will do: the functions are exact everywhere.
const SEED: u64 = 20;

/// The energies of an arm: each function of the energy library \[E4\] that M(q) or V(q) holds, with
/// its coefficient in SI units.
///
/// Exact up to rounding, since the library holds all that a serial arm can need.
/// Checked against: Pinocchio, by way of the arm, and the reference arm's known 23 terms.
pub(crate) fn true_energies(arm: &Arm) -> BTreeMap<EnergyTerm, f64> {
    energies_in(arm, energy_library(&arm.kinds().all(arm.n_joints()), None))
}

/// The energies of an arm in a library that holds them.
pub(crate) fn energies_in(arm: &Arm, library: Vec<EnergyTerm>) -> BTreeMap<EnergyTerm, f64> {
    let n = arm.n_joints();
    // The potential is known up to a constant, which no torque shows.
    let mut functions = vec![Term::one(n)];
    functions.extend(library.iter().map(|term| term.function.clone()));
    functions.sort();
    functions.dedup();
    let weights = project(&functions, |q| {
        let mass = arm.mass_matrix(q);
        let inertia = (0..n * n).map(|place| mass[(place / n, place % n)]);
        inertia.chain([arm.potential_energy(q)]).collect()
    });
    let known = library.into_iter().map(|term| {
        let (Ok(row) | Err(row)) = functions.binary_search(&term.function);
        let column = match term.place {
            Place::Inertia(i, j) => n * i + j,
            Place::Potential => n * n,
        };
        (term, weights[(row, column)])
    });
    known.filter(|(_, weight)| weight.abs() > ROUNDING).collect()
}

/// The coefficients of the torque of all joints in the functions of the product library \[E2\]: what
/// a perfect regression over that library finds.
pub(crate) fn true_products(arm: &Arm) -> Vec<f64> {
    let n = arm.n_joints();
    let rest = vec![0.0; n];
    let weights = project(&angle_functions(&arm.kinds().all(n), TRIG_ORDER), |q| {
        let (mut values, mass) = (arm.gravity_torque(q), arm.mass_matrix(q));
        values.extend((0..n * n).map(|place| mass[(place / n, place % n)]));
        // What grows with the speeds of two joints, or of one: it is quadratic in them.
        for (j, k) in (0..n).flat_map(|j| (0..=j).map(move |k| (j, k))) {
            let [sum, difference] = [1.0, -1.0].map(|speed| {
                let mut dq = rest.clone();
                dq[j] = 1.0;
                dq[k] += speed;
                arm.inverse_dynamics(q, &dq, &rest)
            });
            let share = if j == k { 0.25 } else { 0.5 };
            values.extend(sum.iter().zip(difference).map(|(sum, other)| share * (sum - other)));
        }
        values
    });
    let all = weights.col_iter().flat_map(|column| column.iter().copied().collect::<Vec<_>>());
    all.filter(|weight| weight.abs() > ROUNDING).collect()
}

/// Weights of functions of the angles in some values, functions × values, by least squares at more
/// random states than there are functions.
fn project(functions: &[Term], values: impl Fn(&[f64]) -> Vec<f64>) -> Mat<f64> {
    let n = functions[0].n_joints();
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let count = STATES_PER_FUNCTION * functions.len();
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
