//! Torque, regressor and derivatives agree with each other and balance the books.

use super::{Kinematics, Lanes, MOST_JOINTS, Moved, PER_BODY, State};
use crate::coupling::{Coupled, Coupling};
use crate::geometry::{Geometry, PER_BASE, PER_JOINT};
use crate::joint::JointKinds;
use approx::assert_relative_eq;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use simba::simd::SimdValue;

fn numbers(random: &mut ChaCha8Rng, count: usize) -> Vec<f64> {
    (0..count).map(|_| random.random_range(-2.0..2.0)).collect()
}

/// Joints of which one turns with two coordinates before it, another with one.
fn coupling() -> Coupling {
    [(1, 0, 1), (2, 0, -2), (2, 1, -1)]
        .into_iter()
        .fold(Coupling::default(), |all, (joint, driver, ratio)| {
            all.with(Coupled { joint, driver, ratio })
        })
}

/// A random chain, the inertial parameters of its bodies, and a state of it; one with an odd number
/// of joints is coupled.
fn drawn(n: usize, random: &mut ChaCha8Rng) -> (Geometry, Vec<f64>, [Vec<f64>; 3]) {
    let geometry = Geometry::new(&numbers(random, PER_BASE + PER_JOINT * (n - 1))).unwrap();
    let coupled = n > 2 && n % 2 == 1;
    let geometry = if coupled { geometry.coupled(coupling()) } else { geometry };
    let state = std::array::from_fn(|_| numbers(random, n));
    (geometry, numbers(random, PER_BODY * n), state)
}

fn torque_of(geometry: &Geometry, inertial: &[f64], [q, dq, ddq]: &[Vec<f64>; 3]) -> Vec<f64> {
    let mut torque = vec![0.0; q.len()];
    let state = State { q, dq, ddq };
    let mut moved = Moved::default();
    Kinematics::new(geometry).inverse_dynamics(state, inertial, &mut moved, &mut torque);
    torque
}

#[test]
fn regressor_times_parameters_is_the_torque() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    for n in (1..=7).chain([MOST_JOINTS]) {
        let (geometry, inertial, state) = drawn(n, &mut random);
        let [q, dq, ddq] = &state;
        let mut moved = Moved::default();
        Kinematics::new(&geometry).move_into(State { q, dq, ddq }, &mut moved);

        let mut by_regressor = vec![0.0; n];
        moved.regressor(|joint, parameter, value: f64| {
            assert!(parameter / PER_BODY >= joint, "a body loads no joint beyond it");
            by_regressor[joint] += inertial[parameter] * value;
        });

        for (a, b) in by_regressor.iter().zip(&torque_of(&geometry, &inertial, &state)) {
            // Thousands of roundings of terms that cancel.
            assert_relative_eq!(a, b, max_relative = 1e-11, epsilon = 1e-9);
        }
    }
}

#[test]
fn a_coupled_chain_is_the_chain_at_other_angles_and_loads_all_that_turn_it() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let (geometry, inertial, state) = drawn(3, &mut random);
    assert!(geometry.coupling().is_sound(3) && !geometry.coupling().is_sound(2));
    // Γq and Γᵀτ, written out.
    let angles = state.clone().map(|x| vec![x[0], x[1] + x[0], x[2] - 2.0 * x[0] - x[1]]);
    let alone = torque_of(&geometry.clone().coupled(Coupling::default()), &inertial, &angles);
    let loads = [alone[0] + alone[1] - 2.0 * alone[2], alone[1] - alone[2], alone[2]];

    let [q, dq, ddq] = &state;
    let mut at_once = [0.0; 3];
    Kinematics::new(&geometry).torque(State { q, dq, ddq }, &inertial, &mut at_once);

    for (joint, torque) in torque_of(&geometry, &inertial, &state).into_iter().enumerate() {
        assert_relative_eq!(torque, loads[joint], max_relative = 1e-12, epsilon = 1e-11);
        assert_relative_eq!(at_once[joint], loads[joint], max_relative = 1e-12, epsilon = 1e-11);
    }
}

#[test]
fn derivatives_by_the_geometry_are_those_of_central_differences() {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let coupled = (1..=6).map(|n| drawn(n, &mut random)).collect::<Vec<_>>();
    let sliding = ["p", "rp", "pr", "ppp", "rrpr", "rrprrr"].map(|kinds| {
        let (geometry, inertial, state) = drawn(kinds.len(), &mut random);
        let kinds = JointKinds::read(kinds).unwrap();
        (geometry.coupled(Coupling::default()).of_kinds(kinds), inertial, state)
    });
    for (geometry, inertial, state) in coupled.into_iter().chain(sliding) {
        let n = geometry.n_joints();
        let [q, dq, ddq] = &state;
        let (mut moved, mut change) = (Moved::default(), vec![0.0; n]);
        let kinematics = Kinematics::new(&geometry);
        kinematics.inverse_dynamics(State { q, dq, ddq }, &inertial, &mut moved, &mut change);

        for (parameter, derivative) in geometry.derivatives().iter().enumerate() {
            moved.geometry_derivative(derivative, &inertial, &mut change);

            let at = |step: f64| {
                let mut parameters = geometry.parameters().to_vec();
                parameters[parameter] += step;
                let moved = Geometry::new(&parameters).unwrap();
                let moved = moved.coupled(geometry.coupling().clone());
                torque_of(&moved.of_kinds(geometry.kinds().clone()), &inertial, &state)
            };
            let (ahead, behind) = (at(1e-5), at(-1e-5));
            let size = ahead.iter().fold(1.0_f64, |most, tau| most.max(tau.abs()));
            for joint in 0..n {
                let difference = (ahead[joint] - behind[joint]) / 2e-5;
                // The third derivative times h², and rounding over h.
                assert_relative_eq!(change[joint], difference, epsilon = 1e-6 * size);
            }
        }
    }
}

#[test]
fn derivatives_hold_where_an_axis_is_parallel_to_the_one_before() {
    let geometry = Geometry::straight(2);
    let inertial: Vec<f64> = (0..20).map(|k| 1.0 + 0.1 * f64::from(k)).collect();
    let state = [vec![0.3, -0.4], vec![1.0, 0.5], vec![0.2, -0.7]];
    let [q, dq, ddq] = &state;
    let (mut moved, mut change) = (Moved::default(), vec![0.0; 2]);
    let kinematics = Kinematics::new(&geometry);
    kinematics.inverse_dynamics(State { q, dq, ddq }, &inertial, &mut moved, &mut change);
    let derivatives = geometry.derivatives();
    moved.geometry_derivative(&derivatives[2], &inertial, &mut change);

    let at = |w: f64| {
        torque_of(&Geometry::new(&[0.0, 0.0, w, 0.0, 0.0, 0.0]).unwrap(), &inertial, &state)
    };
    for (change, (ahead, behind)) in change.iter().zip(at(1e-5).into_iter().zip(at(-1e-5))) {
        assert_relative_eq!(*change, (ahead - behind) / 2e-5, epsilon = 1e-7);
    }
}

#[test]
fn four_states_at_once_are_four_states() {
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let (geometry, inertial, _) = drawn(5, &mut random);
    let states: [[Vec<f64>; 3]; 4] =
        std::array::from_fn(|_| std::array::from_fn(|_| numbers(&mut random, 5)));
    let lanes: [Vec<Lanes>; 3] = std::array::from_fn(|signal| {
        let lane = |joint: usize| Lanes::from(std::array::from_fn(|k| states[k][signal][joint]));
        (0..5).map(lane).collect()
    });
    let [q, dq, ddq] = &lanes;
    let (mut moved, mut torque) = (Moved::default(), [Lanes::splat(0.0); 5]);
    let kinematics = Kinematics::new(&geometry);
    kinematics.inverse_dynamics(State { q, dq, ddq }, &inertial, &mut moved, &mut torque);

    for (k, state) in states.iter().enumerate() {
        let expected = torque_of(&geometry, &inertial, state);
        for joint in 0..5 {
            // Sines of several at once are rounded otherwise than those of one.
            assert_relative_eq!(torque[joint].extract(k), expected[joint], max_relative = 1e-12);
        }
    }
}

#[test]
fn the_mass_matrix_is_the_torque_of_unit_accelerations_without_gravity() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let (geometry, inertial, [q, ..]) = drawn(4, &mut random);
    let kinematics = Kinematics::new(&geometry);
    let weightless = kinematics.clone().without_gravity();
    let (rest, mut unit) = (vec![0.0; 4], vec![0.0; 4]);
    let mut moved = Moved::default();
    let mut mass = [[0.0; 4]; 4];
    kinematics.mass_matrix(&q, &inertial, &mut moved, |i, j, value| mass[i][j] = value);

    for j in 0..4 {
        unit[j] = 1.0;
        let mut torque = [0.0; 4];
        let state = State { q: &q[..], dq: &rest[..], ddq: &unit[..] };
        weightless.inverse_dynamics(state, &inertial, &mut moved, &mut torque);
        for i in 0..=j {
            assert_relative_eq!(mass[i][j], torque[i], epsilon = 1e-11);
        }
        unit[j] = 0.0;
    }
}
