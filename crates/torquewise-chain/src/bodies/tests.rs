//! The two ways to the torque of moving bodies agree, and both balance the books.

use super::{Bodies, MOST_JOINTS, PER_BODY, State};
use crate::geometry::{Geometry, PER_BASE, PER_JOINT};
use approx::assert_relative_eq;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn numbers(random: &mut ChaCha8Rng, count: usize) -> Vec<f64> {
    (0..count).map(|_| random.random_range(-2.0..2.0)).collect()
}

/// Bodies of a random chain, their inertial parameters, and a state of it.
fn drawn(n: usize, random: &mut ChaCha8Rng) -> (Bodies, Vec<f64>, [Vec<f64>; 3]) {
    let geometry = Geometry::new(&numbers(random, PER_BASE + PER_JOINT * (n - 1))).unwrap();
    let state = std::array::from_fn(|_| numbers(random, n));
    (Bodies::new(&geometry), numbers(random, PER_BODY * n), state)
}

#[test]
fn columns_times_parameters_are_the_torque() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    for n in (1..=7).chain([MOST_JOINTS]) {
        let (bodies, inertial, [q, dq, ddq]) = drawn(n, &mut random);
        let state = State { q: &q, dq: &dq, ddq: &ddq };

        let mut by_columns = vec![0.0; n];
        bodies.columns(state, |joint, parameter, value| {
            by_columns[joint] += inertial[parameter] * value;
        });

        let mut torque = vec![0.0; n];
        bodies.torque(state, &inertial, &mut torque);
        for (columns, torque) in by_columns.iter().zip(&torque) {
            // Thousands of roundings of terms that cancel.
            assert_relative_eq!(columns, torque, max_relative = 1e-11, epsilon = 1e-9);
        }
    }
}

#[test]
fn a_body_loads_no_joint_beyond_it() {
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let (bodies, _, [q, dq, ddq]) = drawn(4, &mut random);

    bodies.columns(State { q: &q, dq: &dq, ddq: &ddq }, |joint, parameter, _| {
        assert!(parameter / PER_BODY >= joint, "joint {joint}, parameter {parameter}");
    });
}

#[test]
fn without_gravity_bodies_at_rest_take_no_torque() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let (bodies, inertial, [q, ..]) = drawn(5, &mut random);
    let rest = [0.0; 5];
    let mut torque = [1.0; 5];

    bodies.without_gravity().torque(State { q: &q, dq: &rest, ddq: &rest }, &inertial, &mut torque);

    assert!(torque.iter().all(|tau| *tau == 0.0), "{torque:?}");
}
