//! Torque, regressor and derivatives agree with each other and balance the books.

use crate::prismatic::{ARMS, Drawn, drawn, numbers, torque_of};
use approx::assert_relative_eq;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use simba::simd::SimdValue;
use torquewise_rigid::coupling::Coupled;
use torquewise_rigid::recursion::{Lanes, MOST_JOINTS};
use torquewise_rigid::{Coupling, Geometry, Kinematics, MotionState, Moved, PER_BODY};

/// Joints of which one turns with two coordinates before it, another with one.
fn coupling() -> Coupling {
    let coupled = [(1, 0, 1), (2, 0, -2), (2, 1, -1)].into_iter();
    let coupled = coupled.map(|(joint, driver, ratio)| Coupled { joint, driver, ratio });
    coupled.fold(Coupling::default(), |all, own| all.with(own))
}

/// A random chain of joints that turn; one with an odd number of joints is coupled.
fn turning(n: usize, random: &mut ChaCha8Rng) -> Drawn {
    let (geometry, inertial, state) = drawn(&"r".repeat(n), random);
    let coupled = n > 2 && n % 2 == 1;
    let geometry = if coupled { geometry.coupled(coupling()) } else { geometry };
    (geometry, inertial, state)
}

#[test]
fn regressor_times_parameters_is_the_torque() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let turning: Vec<_> = (1..=7).chain([MOST_JOINTS]).map(|n| turning(n, &mut random)).collect();
    let sliding = ARMS.map(|kinds| drawn(kinds, &mut random));
    for (geometry, inertial, state) in turning.into_iter().chain(sliding) {
        let [q, dq, ddq] = &state;
        let mut moved = Moved::default();
        Kinematics::new(&geometry).move_into(MotionState { q, dq, ddq }, &mut moved);

        let mut by_regressor = vec![0.0; q.len()];
        moved.regressor(|joint, parameter, value: f64| {
            assert!(parameter / PER_BODY >= joint, "a body loads no joint beyond it");
            by_regressor[joint] += inertial[parameter] * value;
        });

        let torque = torque_of(&geometry, &inertial, &state);
        // Thousands of roundings of terms that cancel.
        assert_relative_eq!(by_regressor[..], torque[..], max_relative = 1e-11, epsilon = 1e-9);
    }
}

#[test]
fn a_coupled_chain_is_the_chain_at_other_angles_and_loads_all_that_turn_it() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let (geometry, inertial, state) = turning(3, &mut random);
    assert!(geometry.coupling().is_sound(3) && !geometry.coupling().is_sound(2));
    // Γq and Γᵀτ, written out.
    let angles = state.clone().map(|x| vec![x[0], x[1] + x[0], x[2] - 2.0 * x[0] - x[1]]);
    let alone = torque_of(&geometry.clone().coupled(Coupling::default()), &inertial, &angles);
    let loads = [alone[0] + alone[1] - 2.0 * alone[2], alone[1] - alone[2], alone[2]];

    let [q, dq, ddq] = &state;
    let mut at_once = vec![0.0; 3];
    Kinematics::new(&geometry).torque(MotionState { q, dq, ddq }, &inertial, &mut at_once);

    for torque in [torque_of(&geometry, &inertial, &state), at_once] {
        assert_relative_eq!(torque[..], loads[..], max_relative = 1e-12, epsilon = 1e-11);
    }
}

#[test]
fn derivatives_by_the_geometry_are_those_of_central_differences_and_so_where_axes_are_parallel() {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let turning: Vec<_> = (1..=6).map(|n| turning(n, &mut random)).collect();
    let sliding = ARMS.map(|kinds| drawn(kinds, &mut random));
    let state = [vec![0.3, -0.4], vec![1.0, 0.5], vec![0.2, -0.7]];
    let inertial = (0..20).map(|k| 1.0 + 0.1 * f64::from(k)).collect();
    let parallel = (Geometry::straight(2), inertial, state);
    for (geometry, inertial, state) in turning.into_iter().chain(sliding).chain([parallel]) {
        let n = geometry.n_joints();
        let [q, dq, ddq] = &state;
        let (mut moved, mut change) = (Moved::default(), vec![0.0; n]);
        let kinematics = Kinematics::new(&geometry);
        kinematics.move_into(MotionState { q, dq, ddq }, &mut moved);
        moved.torque(&inertial, &mut change);

        for (parameter, derivative) in geometry.derivatives().iter().enumerate() {
            moved.geometry_derivative(derivative, &mut change);

            let at = |step: f64| {
                let mut parameters = geometry.parameters().to_vec();
                parameters[parameter] += step;
                let moved = Geometry::new(&parameters).unwrap();
                let moved = moved.coupled(geometry.coupling().clone());
                torque_of(&moved.of_kinds(geometry.kinds().clone()), &inertial, &state)
            };
            let (ahead, behind) = (at(1e-5), at(-1e-5));
            // The third derivative times h², and rounding over h.
            let size = ahead.iter().fold(1.0_f64, |most, tau| most.max(tau.abs()));
            let bound = if geometry == Geometry::straight(2) { 1e-7 } else { 1e-6 * size };
            for joint in 0..n {
                let difference = (ahead[joint] - behind[joint]) / 2e-5;
                assert_relative_eq!(change[joint], difference, epsilon = bound);
            }
        }
    }
}

#[test]
fn four_states_at_once_are_four_states() {
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let (geometry, inertial, _) = turning(5, &mut random);
    let states: [[Vec<f64>; 3]; 4] =
        std::array::from_fn(|_| std::array::from_fn(|_| numbers(&mut random, 5)));
    let lanes: [Vec<Lanes>; 3] = std::array::from_fn(|signal| {
        let lane = |joint: usize| Lanes::from(std::array::from_fn(|k| states[k][signal][joint]));
        (0..5).map(lane).collect()
    });
    let [q, dq, ddq] = &lanes;
    let (mut moved, mut torque) = (Moved::default(), [Lanes::splat(0.0); 5]);
    let kinematics = Kinematics::new(&geometry);
    kinematics.move_into(MotionState { q, dq, ddq }, &mut moved);
    moved.torque(&inertial, &mut torque);

    for (k, state) in states.iter().enumerate() {
        let expected = torque_of(&geometry, &inertial, state);
        for joint in 0..5 {
            // Sines of several at once are rounded otherwise than those of one.
            assert_relative_eq!(torque[joint].extract(k), expected[joint], max_relative = 1e-12);
        }
    }
}
