//! The energy terms of a chain are the chain.

use crate::twins::drawn;
use faer::Mat;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use torquewise_model::expansion::energy_terms;
use torquewise_model::library::energy_library;
use torquewise_model::{EnergyTerm, Form, Model, Torque, Weighted};
use torquewise_rigid::{Chain, Geometry, Rows};

fn model(n: usize, terms: Vec<(EnergyTerm, f64)>) -> Model {
    let weighted = terms.into_iter().map(|(term, weight)| Weighted::new(term, weight));
    Model {
        joints: (1..=n).map(|joint| format!("joint{joint}")).collect(),
        form: Form::Energy(weighted.collect()),
        ..Model::default()
    }
}

fn terms_of(chain: &Chain) -> Vec<(EnergyTerm, f64)> {
    energy_terms(&chain.geometry, &chain.inertial).unwrap()
}

/// The largest difference between the torque of a chain and that of its terms, relative to the
/// largest torque, at random states.
fn apart(chain: &Chain) -> f64 {
    let (m, n) = (40, chain.geometry.n_joints());
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let [q, dq, ddq] =
        [3.0, 2.0, 5.0].map(|most| Mat::from_fn(m, n, |_, _| random.random_range(-most..most)));
    let none = vec![Mat::zeros(m, 0); n];
    let rows = Rows::new([q.as_ref(), dq.as_ref(), ddq.as_ref(), q.as_ref()], &none).unwrap();
    let expected = chain.torque(&rows);
    let torque = Torque::new(&model(n, terms_of(chain)));
    let mut apart = 0.0_f64;
    for row in 0..m {
        let [q, dq, ddq] = [&q, &dq, &ddq].map(|x| x.row(row).iter().copied().collect::<Vec<_>>());
        let tau = torque.at(&q, &dq, &ddq).unwrap();
        for (joint, tau) in tau.into_iter().enumerate() {
            apart = apart.max((tau - expected[joint * m + row]).abs());
        }
    }
    apart / expected.iter().fold(0.0_f64, |most, tau| most.max(tau.abs()))
}

#[test]
fn the_terms_of_a_chain_have_its_torque() {
    for (n, seed) in [(1, 0), (2, 1), (3, 2), (3, 3), (4, 4), (5, 5)] {
        let apart = apart(&drawn(n, seed));

        assert!(apart < 1e-11, "{n} joints: {apart}");
    }
}

#[test]
fn masses_that_no_body_has_are_listed_as_well() {
    // The ridge may pick them: all that counts is the torque.
    let mut random = ChaCha8Rng::seed_from_u64(8);
    let mut numbers = |count| (0..count).map(|_| random.random_range(-2.0..2.0)).collect();
    let parameters: Vec<f64> = numbers(2 + 4 * 3);
    let geometry = Geometry::new(&parameters).unwrap();
    let inertial = numbers(40);

    let chain = Chain { geometry, inertial, drive: vec![], residual_rms: vec![], cost: 0.0 };

    assert!(apart(&chain) < 1e-11);
}

#[test]
fn the_terms_of_a_chain_are_of_the_energy_library() {
    // Σ 3^(j−i) 5^(n−j) + Σ 5^(n−i) + 3ⁿ − 1 of method.md.
    for (n, size) in [(3, 84), (4, 410)] {
        let terms = terms_of(&drawn(n, 6));

        let model = model(n, terms.clone());
        let library =
            self::model(n, energy_library(n, None).into_iter().map(|t| (t, 1.0)).collect());
        assert!(terms.len() <= size, "{} terms of {n} joints", terms.len());
        assert_eq!(library.form.n_coefficients(), size);
        // The library has powers of sines and cosines where a chain has harmonics.
        let places = |model: &Model| {
            let Form::Energy(terms) = &model.form else { unreachable!() };
            terms.iter().map(|w| w.term.place).collect::<std::collections::BTreeSet<_>>()
        };
        assert!(places(&model).is_subset(&places(&library)));
    }
}
