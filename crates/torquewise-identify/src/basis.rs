//! Harmonics of joint sums, of which parallel axes need fewer than products (E4).

use std::collections::BTreeMap;
use torquewise_model::harmonic::{factors_of, waves_of};
use torquewise_model::{EnergyTerm, Factor, ModelError, RigidChain, Term, Trig};
use torquewise_regression::atom::Wave;

/// Energy terms with their coefficients, equal terms added up.
pub(crate) type Energies = BTreeMap<EnergyTerm, f64>;

/// The same energies as harmonics cos(k·q), sin(k·q).
///
/// Links behind parallel axes turn by the sum of their angles: where the product basis needs
/// cos q₂·cos q₃ and sin q₂·sin q₃, cos(q₂ + q₃) says both.
pub(crate) fn joint_sums(energies: &Energies) -> Energies {
    let mut sums = Energies::new();
    for (term, coefficient) in energies {
        let (angles, positions) = without_positions(&term.function);
        for (weight, wave) in waves_of(*coefficient, &angles) {
            let mut function = harmonic(&wave);
            function.factors.extend(positions.iter().cloned());
            *sums.entry(EnergyTerm { place: term.place, function }).or_insert(0.0) += weight;
        }
    }
    sums
}

/// The products of sines and cosines that a harmonic of a joint sum is part of, each with the weight
/// it has there; a product is its own.
fn products_in(term: &EnergyTerm) -> Vec<(EnergyTerm, f64)> {
    let (angles, positions) = without_positions(&term.function);
    let [factor] = &angles.factors[..] else { return vec![(term.clone(), 1.0)] };
    let mut products = vec![Term::one(factor.multiples.len())];
    for (joint, multiple) in factor.multiples.iter().enumerate().filter(|(_, k)| **k != 0) {
        let with = |product: &Term| {
            [Trig::Cos, Trig::Sin].map(|trig| product.clone().times(trig, joint, multiple.abs(), 1))
        };
        products = products.iter().flat_map(with).collect();
    }
    let weighted = products.into_iter().filter_map(|mut function| {
        let mut own = waves_of(1.0, &function).into_iter();
        let (weight, _) = own.find(|(_, wave)| harmonic(wave) == angles)?;
        function.factors.extend(positions.iter().cloned());
        // In the order of the joints, as chains list them.
        function.factors.sort_by_key(|factor| factor.multiples.iter().position(|k| *k != 0));
        Some((EnergyTerm { place: term.place, function }, weight))
    });
    weighted.collect()
}

/// Energy terms of whichever basis, ready to be looked up in chains.
pub(crate) struct Wanted {
    /// Of each term, how many products it is a sum of, and all of these with their weights.
    counts: Vec<usize>,
    weights: Vec<f64>,
    products: Vec<EnergyTerm>,
}

impl Wanted {
    pub(crate) fn of<'a>(terms: impl Iterator<Item = &'a EnergyTerm>) -> Self {
        let parts: Vec<Vec<(EnergyTerm, f64)>> = terms.map(products_in).collect();
        let counts = parts.iter().map(Vec::len).collect();
        let (products, weights) = parts.into_iter().flatten().unzip();
        Self { counts, weights, products }
    }

    /// The coefficients that these terms have in a chain.
    pub(crate) fn coefficients_in(&self, chain: &RigidChain) -> Result<Vec<f64>, ModelError> {
        let found = chain.coefficients_of(&self.products)?;
        let mut shares = self.weights.iter().zip(found).map(|(weight, own)| weight * own);
        Ok(self.counts.iter().map(|count| shares.by_ref().take(*count).sum()).collect())
    }
}

/// A function of sliding joints without their positions, and these.
fn without_positions(function: &Term) -> (Term, Vec<Factor>) {
    let is_position = |factor: &Factor| factor.function == Trig::Position;
    let (positions, factors) = function.factors.iter().cloned().partition(is_position);
    (Term { factors, ..function.clone() }, positions)
}

fn harmonic(wave: &Wave) -> Term {
    Term { factors: factors_of(wave), ..Term::one(wave.multiples().len()) }
}

#[cfg(test)]
mod tests {
    use super::{Energies, joint_sums, products_in};
    use torquewise_model::{EnergyTerm, Place, Term, Trig};

    fn term(place: Place, trigs: [Trig; 2]) -> EnergyTerm {
        let one = Term::one(3);
        EnergyTerm { place, function: one.times(trigs[0], 1, 1, 1).times(trigs[1], 2, 2, 1) }
    }

    #[test]
    fn the_energy_is_the_same() {
        let slid = Term::one(3).times(Trig::Cos, 1, 1, 1).times(Trig::Position, 2, 1, 2);
        let energies = Energies::from([
            (term(Place::Inertia(0, 1), [Trig::Cos, Trig::Sin]), 1.5),
            (term(Place::Inertia(0, 1), [Trig::Sin, Trig::Cos]), 0.7),
            (EnergyTerm { place: Place::Inertia(0, 1), function: Term::one(3) }, 2.0),
            (EnergyTerm { place: Place::Inertia(0, 1), function: slid }, -0.4),
        ]);
        let sums = joint_sums(&energies);
        assert!(sums.keys().any(|sum| sum.name() == "M12: cos(q2)*q3^2"), "{sums:?}");
        for (sum, coefficient) in &sums {
            let part = |(own, by): (EnergyTerm, f64)| by * energies.get(&own).unwrap_or(&0.0);
            let found: f64 = products_in(sum).into_iter().map(part).sum();
            assert!((found - coefficient).abs() < 1e-15, "{}: {found}", sum.name());
        }
        for q in [[0.1, 0.7, -1.3], [2.0, -0.4, 0.9]] {
            let value = |energies: &Energies| -> f64 {
                energies
                    .iter()
                    .map(|(term, c)| c * term.function.value(&q, &[0.0; 3], &[0.0; 3]))
                    .sum()
            };
            assert!((value(&energies) - value(&sums)).abs() < 1e-14);
        }
    }

    #[test]
    fn parallel_axes_need_one_term_where_products_need_two() {
        let place = Place::Potential;
        let energies = Energies::from([
            (term(place, [Trig::Cos, Trig::Cos]), 1.0),
            (term(place, [Trig::Sin, Trig::Sin]), -1.0),
        ]);
        let sums: Vec<(String, f64)> = joint_sums(&energies)
            .into_iter()
            .filter(|(_, c)| *c != 0.0)
            .map(|(term, c)| (term.name(), c))
            .collect();
        assert_eq!(sums, [("V: cos(q2+2*q3)".to_owned(), 1.0)]);
    }
}
