//! What must hold for every arm, on random ones: energy, symmetry, and ways there and back.
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::fmt::Write;
use torquewise_sim::{Arm, SimError, arms};

fn random_arm(n: usize, rng: &mut ChaCha8Rng) -> Arm {
    let mut text = format!("name = 'random-{n}'\nbase_rpy = {:?}\n", numbers(rng, 3, 3.0));
    for joint in 1..=n {
        let [a, alpha, d, offset] = numbers(rng, 4, 1.0)[..] else { unreachable!() };
        let [mass, ixx, iyy, izz, rotor] = numbers(rng, 5, 1.0)[..] else { unreachable!() };
        // Principal moments of at least 0.3 outweigh products of inertia of at most 0.1.
        let inertia = [0.3 + ixx.abs(), 0.3 + iyy.abs(), 0.3 + izz.abs()];
        let products = numbers(rng, 3, 0.1);
        write!(
            text,
            "[[joints]]\nname = 'joint{joint}'\na = {a:?}\nalpha = {:?}\nd = {d:?}\n\
             offset = {offset:?}\nmass = {:?}\ncom = {:?}\nrotor = {:?}\ninertia = {:?}\n",
            3.0 * alpha,
            5.0 * mass.abs(),
            numbers(rng, 3, 0.3),
            rotor.abs(),
            [&inertia[..], &products].concat(),
        )
        .unwrap();
    }
    Arm::from_dh_toml(&text).unwrap()
}

/// Numbers evenly drawn from −most to most.
fn numbers(rng: &mut ChaCha8Rng, n: usize, most: f64) -> Vec<f64> {
    (0..n).map(|_| rng.random_range(-most..most)).collect()
}

/// Arms of one to seven joints with random geometry and masses, then the reference arms, each in ten
/// random states q, dq, ddq.
fn for_states(check: impl Fn(&Arm, &[f64], &[f64], &[f64])) {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut all: Vec<Arm> = (0..21).map(|k| random_arm(1 + k % 7, &mut rng)).collect();
    all.extend(arms().iter().map(|summary| Arm::builtin(summary.name).unwrap()));
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    for arm in all {
        let n = arm.n_joints();
        for _ in 0..10 {
            let [q, dq, ddq] = [3.0, 2.0, 5.0].map(|most| numbers(&mut rng, n, most));
            check(&arm, &q, &dq, &ddq);
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// a + h·b.
fn step(a: &[f64], h: f64, b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + h * b).collect()
}

/// Derivative at 0 by a central difference of fourth order.
fn slope(of: &dyn Fn(f64) -> f64) -> f64 {
    let h = 1e-3;
    (8.0 * (of(h) - of(-h)) - (of(2.0 * h) - of(-2.0 * h))) / (12.0 * h)
}

#[test]
fn mass_matrix_is_symmetric_positive_definite() {
    for_states(|arm, q, _, _| {
        let mass = arm.mass_matrix(q);

        assert_eq!(mass, mass.transpose().to_owned());
        assert!(mass.llt(faer::Side::Lower).is_ok(), "{}", arm.name());
    });
}

#[test]
fn power_in_is_change_of_energy() {
    // d/dt (T + V) along q(t) = q + t dq + t² ddq / 2.
    for_states(|arm, q, dq, ddq| {
        let energy = |t: f64| {
            let q = step(&step(q, t, dq), t * t / 2.0, ddq);
            let dq = step(dq, t, ddq);
            arm.kinetic_energy(&q, &dq) + arm.potential_energy(&q)
        };
        let change = slope(&energy);

        let power = dot(dq, &arm.inverse_dynamics(q, dq, ddq));

        // h⁴ times the fifth derivative (rates of about ten per second), against the energy.
        let scale = energy(0.0).abs() + norm(dq) * norm(&arm.inverse_dynamics(q, dq, ddq));
        assert!((power - change).abs() < 1e-6 * scale, "{}: {power} {change}", arm.name());
    });
}

#[test]
fn forward_dynamics_undoes_inverse_dynamics() {
    for_states(|arm, q, dq, ddq| {
        let tau = arm.inverse_dynamics(q, dq, ddq);

        let found = arm.forward_dynamics(q, dq, &tau).unwrap();

        let error = norm(&step(&found, -1.0, ddq));
        // Rounding of τ, magnified by the condition of M (up to about 1e5 for the wrists).
        assert!(error < 1e-9 * norm(ddq), "{}: {error:e}", arm.name());
    });
}

#[test]
fn gravity_torque_is_the_gradient_of_potential_energy() {
    for_states(|arm, q, _, _| {
        let gravity = arm.gravity_torque(q);

        for i in 0..arm.n_joints() {
            let mut direction = vec![0.0; arm.n_joints()];
            direction[i] = 1.0;
            let energy = |t: f64| arm.potential_energy(&step(q, t, &direction));
            let gradient = slope(&energy);
            // h⁴ / 30 times the fifth derivative, as large as the torque itself, plus rounding.
            let scale = 1.0 + norm(&gravity);
            assert!((gravity[i] - gradient).abs() < 1e-8 * scale, "{}", arm.name());
        }
    });
}

#[test]
fn a_massless_last_link_is_named_when_it_should_accelerate_and_another_joint_count_is_refused() {
    let arm = Arm::from_dh_toml(include_str!("bare.toml")).unwrap();

    let error = arm.forward_dynamics(&[0.1, 0.2], &[0.0, 0.0], &[1.0, 1.0]).unwrap_err();

    assert!(matches!(error, SimError::Massless { joint: 1 }), "{error:?}");
    let error = arm.forward_dynamics(&[0.1, 0.2], &[0.0, 0.0], &[1.0]).unwrap_err();

    let wanted = SimError::JointCount { what: "tau", found: 1, expected: 2 };
    assert_eq!(error.to_string(), wanted.to_string());
}
