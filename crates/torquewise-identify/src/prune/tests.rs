//! Loads of terms against the model's own torque; what may be left out and what may not.

use super::{STATES, TOLERANCE, prune};
use crate::States;
use approx::assert_relative_eq;
use faer::Mat;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use torquewise_model::{EnergyTerm, Form, Model, Place, RigidChain, Torque, Weighted};
use torquewise_motion::{Motion, Signals};

const N: usize = 3;

/// Terms of a chain whose axes are nearly at right angles: few that matter and many that do not.
fn terms() -> Vec<(EnergyTerm, f64)> {
    let quarter = std::f64::consts::FRAC_PI_2;
    let geometry = vec![0.01, -0.02, quarter + 0.01, 0.02, 0.0, 0.001, -0.01, 0.005, 0.4, -0.002];
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let links = (0..N).map(|_| std::array::from_fn(|_| random.random_range(0.1..2.0))).collect();
    RigidChain { geometry, links, ..RigidChain::default() }.energy_terms().unwrap()
}

/// A smooth motion.
fn motion() -> Motion {
    let m = 500;
    let phase = |row: usize, joint: usize| {
        let rate = 1.0 + 0.37 * joint as f64;
        (rate, rate * 0.02 * row as f64 + joint as f64)
    };
    let signal = |of: fn(f64, f64) -> f64| {
        Mat::from_fn(m, N, |row, joint| {
            let (rate, x) = phase(row, joint);
            of(rate, x)
        })
    };
    Motion::new(Signals {
        joints: (1..=N).map(|joint| format!("joint{joint}")).collect(),
        t: (0..m).map(|row| 0.02 * row as f64).collect(),
        q: signal(|_, x| x.sin()),
        dq: signal(|rate, x| rate * x.cos()),
        ddq: signal(|rate, x| -rate * rate * x.sin()),
        tau: None,
    })
    .unwrap()
}

fn torque(terms: &[(EnergyTerm, f64)], motion: &Motion) -> Mat<f64> {
    let weighted = terms.iter().cloned().map(|(term, c)| Weighted::new(term, c));
    let (joints, form) = (motion.joints().to_vec(), Form::Energy(weighted.collect()));
    Torque::new(&Model { joints, form, ..Model::default() }).over(motion).unwrap()
}

#[test]
fn the_load_of_a_term_is_its_torque() {
    let motion = motion();
    let states = States::mixed(&motion, STATES, 1);
    // Even states are rows of the log.
    let own = |state: usize| (state / 2) * motion.n_rows() / states.len().div_ceil(2);
    for (term, coefficient) in terms() {
        let loads = states.loads(&term, coefficient);

        let expected = torque(&[(term, coefficient)], &motion);
        for state in (0..states.len()).step_by(20) {
            for joint in 0..N {
                let found = loads[(state, joint)];
                assert_relative_eq!(found, expected[(own(state), joint)], epsilon = 1e-12);
            }
        }
    }
}

#[test]
fn what_is_left_out_is_below_the_tolerance() {
    let (motion, all) = (motion(), terms());
    let whole = torque(&all, &motion);
    for part in [0.3, 0.03, 0.003] {
        let rms =
            |x: &Mat<f64>, joint: usize| x.col(joint).norm_l2() / (motion.n_rows() as f64).sqrt();
        let residual: Vec<f64> = (0..N).map(|joint| part * rms(&whole, joint)).collect();

        let kept = prune(all.clone(), &motion, &residual, 3);

        assert!(kept.len() < all.len(), "{part}: {} of {}", kept.len(), all.len());
        let left_out = &whole - &torque(&kept, &motion);
        for (joint, residual) in residual.iter().enumerate() {
            let found = rms(&left_out, joint);
            // The tolerance is kept on the states looked at together, a little more on half.
            assert!(found < 1.5 * TOLERANCE * residual, "joint {joint}, {part}: {found}");
        }
    }
}

#[test]
fn a_larger_residual_keeps_fewer_terms_and_none_all_that_load() {
    let kept = |terms, rms: f64| prune(terms, &motion(), &[rms; N], 3);

    let counts = [1e-6, 1e-3, 1e-1, 1e1].map(|rms| kept(terms(), rms).len());

    assert!(counts.is_sorted_by(|a, b| a > b), "{counts:?}");
    assert_eq!(kept(terms(), 0.0), terms());
    let still = EnergyTerm { place: Place::Potential, function: torquewise_model::Term::one(N) };
    assert_eq!(kept(vec![(still, 5.0)], 0.1), []);
}
