//! Columns against closed forms: energies differentiated by hand, virtual work.

use super::{DriveTerm, columns};
use approx::assert_relative_eq;
use faer::Mat;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use torquewise_model::{
    Drive, EnergyTerm, Form, FrictionTerm, JointKind, Model, Place, Term, Torque, Training, Trig,
    Weighted,
};
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

fn dot(shaft: &[f64], x: faer::MatRef<'_, f64>, row: usize) -> f64 {
    shaft.iter().enumerate().map(|(joint, s)| s * x[(row, joint)]).sum()
}

/// Power of each column in a row: Σ τⱼ q̇ⱼ.
fn power(columns: &[Mat<f64>], motion: &Motion, row: usize, column: usize) -> f64 {
    (0..N).map(|joint| columns[joint][(row, column)] * motion.dq()[(row, joint)]).sum()
}

#[test]
fn a_rotor_loads_joints_as_its_energy_says() {
    let motion = states();
    let coefficient = 0.7;
    for shaft in [vec![0.0, 1.0, 0.0], vec![0.0, 1.0, -1.0], vec![0.5, 0.0, 2.0]] {
        let rotor = DriveTerm::Rotor(shaft.clone());
        let weighted =
            |(term, coefficient)| Weighted { term, coefficient, std_error: 0.0, inclusion: None };
        let drive = Drive::Rotor { shaft: shaft.clone(), inertia: coefficient };
        let terms = drive.energy_terms().into_iter().map(weighted).collect();
        let expected = Torque::new(&model(terms)).over(&motion).unwrap();

        let columns = columns(&[rotor], &motion, None);

        for row in 0..motion.n_rows() {
            for (joint, column) in columns.iter().enumerate() {
                let found = coefficient * column[(row, 0)];
                // T = ½ v², so that d/dt ∂T/∂q̇ⱼ = sⱼ v̇.
                let by_hand = coefficient * shaft[joint] * dot(&shaft, motion.ddq(), row);
                assert_relative_eq!(found, by_hand, epsilon = 1e-13);
                assert_relative_eq!(found, expected[(row, joint)], epsilon = 1e-13);
            }
        }
    }
}

#[test]
fn each_joint_has_its_own_rotor() {
    let motion = states();

    let columns = columns(&DriveTerm::rotors(N), &motion, None);

    for (joint, column) in columns.iter().enumerate() {
        for rotor in 0..N {
            let expected = if rotor == joint { motion.ddq()[(5, joint)] } else { 0.0 };
            assert_relative_eq!(column[(5, rotor)], expected);
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
            assert_relative_eq!(columns[1][(row, spring)], slope, epsilon = 1e-14);
            assert_relative_eq!(columns[0][(row, spring)], 0.0);
            assert_relative_eq!(columns[2][(row, spring)], 0.0);
        }
    }
}

#[test]
fn a_term_of_the_inertia_loads_joints_as_a_model_predicts() {
    let motion = states();
    let function = Term::one(N).times(Trig::Sin, 1, 1, 1).times(Trig::Cos, 2, 2, 1);
    for place in [Place::Inertia(0, 1), Place::Inertia(0, 0), Place::Potential] {
        let term = EnergyTerm { place, function: function.clone() };
        let weighted =
            Weighted { term: term.clone(), coefficient: 1.0, std_error: 0.0, inclusion: None };
        let expected = Torque::new(&model(vec![weighted])).over(&motion).unwrap();

        let columns = columns(&[DriveTerm::Energy(term)], &motion, None);

        for row in 0..motion.n_rows() {
            for (joint, column) in columns.iter().enumerate() {
                assert_relative_eq!(column[(row, 0)], expected[(row, joint)], epsilon = 1e-12);
            }
        }
    }
}

fn model(terms: Vec<Weighted<EnergyTerm>>) -> Model {
    Model {
        joints: (1..=N).map(|joint| format!("joint{joint}")).collect(),
        form: Form::Energy(terms),
        friction: vec![],
        chain: None,
        stages: vec![],
        training: Training::default(),
        choices: vec![],
    }
}

#[test]
fn a_shared_shaft_does_the_work_of_its_friction_and_its_rotor() {
    let motion = states();
    let (shaft, width) = ([0.0, 1.0, -1.0], 0.1);

    let columns = columns(&DriveTerm::shared_shaft(&shaft, width), &motion, None);

    for row in 0..motion.n_rows() {
        let (v, a) = (dot(&shaft, motion.dq(), row), dot(&shaft, motion.ddq(), row));
        // f(v)·v for viscous and dry friction, dT/dt = v·v̇ for the rotor.
        for (column, work) in [v * v, (v / width).tanh() * v, a * v].into_iter().enumerate() {
            let found = power(&columns, &motion, row, column);
            assert_relative_eq!(found, work, epsilon = 1e-13);
        }
    }
}

fn friction(terms: Vec<FrictionTerm>) -> Vec<DriveTerm> {
    DriveTerm::friction(terms).collect()
}

#[test]
fn linear_friction_is_offset_viscous_and_dry() {
    let motion = states();
    let width = [0.1, 0.2, 0.3];

    let columns = columns(
        &friction(FrictionLibrary { width: width.to_vec(), peak: vec![1.0; N] }.linear()),
        &motion,
        None,
    );

    for (joint, column) in columns.iter().enumerate() {
        let dq = motion.dq()[(3, joint)];
        let own = [1.0, dq, (dq / width[joint]).tanh()];
        let all: Vec<f64> = column.row(3).iter().copied().collect();
        let mut expected = vec![0.0; 3 * N];
        expected[3 * joint..3 * joint + 3].copy_from_slice(&own);
        assert_eq!(all, expected);
    }
}

#[test]
fn the_stribeck_dictionary_tells_directions_apart() {
    let width = 0.01;
    let all = friction(FrictionLibrary { width: vec![width; N], peak: vec![2.0; N] }.stribeck());
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
            let value = columns[joint][(row, k)];
            assert!(value == 0.0 || dq < 0.0, "row {row}, column {k}");
            assert!(value < 0.0 || !far || value.abs() < 1e-100, "row {row}, column {k}");
        }
    }
}

#[test]
fn a_joint_that_never_moves_has_columns_all_the_same() {
    let drive = friction(FrictionLibrary::new(vec![0.0; N]).stribeck());

    let columns = columns(&drive, &states(), None);

    assert!(columns.iter().all(Mat::is_all_finite));
}
