//! Columns against closed forms: energies differentiated by hand, virtual work.

use super::{DriveTerm, columns};
use approx::assert_relative_eq;
use faer::Mat;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use torquewise_model::JointKind;
use torquewise_motion::{Motion, Signals};
use torquewise_stepwise::friction::FrictionLibrary;

const N: usize = 3;

/// Random states, in no order.
fn states() -> Motion {
    let (m, mut random) = (30, ChaCha8Rng::seed_from_u64(4));
    let mut signal = |most: f64| Mat::from_fn(m, N, |_, _| random.random_range(-most..most));
    let (q, dq, ddq) = (signal(3.0), signal(2.0), signal(5.0));
    let t = (0..m).map(|row| row as f64).collect();
    let joints = (1..=N).map(|joint| format!("joint{joint}")).collect();
    Motion::new(Signals { joints, t, q, dq, ddq, tau: None }).unwrap()
}

#[test]
fn a_rotor_loads_joints_as_its_energy_says() {
    let motion = states();
    for shaft in [vec![0.0, 1.0, 0.0], vec![0.0, 1.0, -1.0], vec![0.5, 0.0, 2.0]] {
        let columns = columns(&[DriveTerm::Rotor(shaft.clone())], &motion, None);

        for row in 0..motion.n_rows() {
            for joint in 0..N {
                let found = columns[(joint * motion.n_rows() + row, 0)];
                // T = ½ v², so that d/dt ∂T/∂q̇ⱼ = sⱼ v̇.
                let turning = (0..N).map(|k| shaft[k] * motion.ddq()[(row, k)]).sum::<f64>();
                assert_relative_eq!(found, shaft[joint] * turning, epsilon = 1e-13);
            }
        }
    }
}

#[test]
fn a_counterbalance_loads_its_joint_with_the_slope_of_its_energy() {
    let motion = states();

    let columns = columns(&DriveTerm::counterbalance(N, 1, JointKind::Revolute), &motion, None);

    for row in 0..motion.n_rows() {
        let q = motion.q()[(row, 1)];
        // d/dq of cos q, sin q, cos 2q, sin 2q.
        let slopes = [-q.sin(), q.cos(), -2.0 * (2.0 * q).sin(), 2.0 * (2.0 * q).cos()];
        for (spring, slope) in slopes.into_iter().enumerate() {
            let of_joint = |joint: usize| columns[(joint * motion.n_rows() + row, spring)];
            assert_relative_eq!(of_joint(1), slope, epsilon = 1e-14);
            assert_relative_eq!(of_joint(0), 0.0);
            assert_relative_eq!(of_joint(2), 0.0);
        }
    }
}

#[test]
fn the_stribeck_dictionary_tells_directions_apart() {
    let width = 0.01;
    let laws = FrictionLibrary { width: vec![width; N], peak: vec![2.0; N] }.stribeck();
    let all: Vec<DriveTerm> = DriveTerm::friction(laws).collect();
    let motion = states();

    let columns = columns(&all, &motion, None);

    let is_one_way = |drive: &DriveTerm| drive.law().is_some_and(|term| !term.direction.is_both());
    let one_way: Vec<usize> = (0..all.len()).filter(|&k| is_one_way(&all[k])).collect();
    assert_eq!((all.len(), one_way.len()), (14 * N, 8 * N));
    for row in 0..motion.n_rows() {
        for &k in &one_way {
            let joint = k / 14;
            let dq = motion.dq()[(row, joint)];
            // An exponential of a small speed is nothing at a large one.
            let far = dq < -20.0 * width;
            let value = columns[(joint * motion.n_rows() + row, k)];
            assert!(value == 0.0 || dq < 0.0, "row {row}, column {k}");
            assert!(value < 0.0 || !far || value.abs() < 1e-100, "row {row}, column {k}");
        }
    }
}
