//! From arm to true coefficients of M(q) and V(q) in functions that hold them.

use faer::Mat;
use faer::prelude::SolveLstsq;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;
use torquewise_model::library::energy_library;
use torquewise_model::{EnergyTerm, Place};
use torquewise_sim::Arm;

/// Weights below this are rounding.
const ROUNDING: f64 = 1e-9;

/// The energies of an arm in the functions of the energy library.
pub(crate) fn energies(arm: &Arm) -> BTreeMap<EnergyTerm, f64> {
    projected(arm, energy_library(arm.n_joints(), None))
}

/// The energies of an arm in functions that hold them, by least squares at more random states than
/// there are functions.
pub(crate) fn projected(
    arm: &Arm,
    functions: impl IntoIterator<Item = EnergyTerm>,
) -> BTreeMap<EnergyTerm, f64> {
    let n = arm.n_joints();
    let mut places: BTreeMap<Place, Vec<EnergyTerm>> = BTreeMap::new();
    for term in functions {
        places.entry(term.place).or_default().push(term);
    }
    let mut random = ChaCha8Rng::seed_from_u64(20);
    let states: Vec<Vec<f64>> =
        (0..400).map(|_| (0..n).map(|_| random.random_range(-3.0..3.0)).collect()).collect();
    let rest = vec![0.0; n];
    let mut found = BTreeMap::new();
    for (place, terms) in places {
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
        for (j, term) in terms.into_iter().enumerate() {
            if weights[(j, 0)].abs() > ROUNDING {
                found.insert(term, weights[(j, 0)]);
            }
        }
    }
    found
}
