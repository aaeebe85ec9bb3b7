//! From three recordings of an arm with friction to its terms and its friction curve, stepwise.

use crate::support::{
    State, assert_predicts, executed, fit, motion, normals, reference_arm, states_of, with_torque,
};
use crate::truth;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use torquewise_identify::{FrictionKind, LibraryKind, LibraryOptions, Reconstruction};
use torquewise_model::{Form, Torque};
use torquewise_motion::{Motion, Pattern};
use torquewise_sim::{Arm, MotionKind};

/// Dry friction, what Stribeck adds at rest \[N·m\], Stribeck speed \[rad/s\], viscous friction
/// \[N·m·s/rad\]; forward, then backward.
type Curve = [[f64; 4]; 2];

const CURVES: [Curve; 3] = [
    [[4.0, 2.0, 0.10, 3.0], [5.0, 2.5, 0.10, 3.5]],
    [[6.0, 3.0, 0.12, 4.0], [6.0, 3.0, 0.12, 4.0]],
    [[2.0, 1.5, 0.08, 1.0], [1.5, 1.0, 0.08, 1.2]],
];

/// F of (17).
fn truth_of(curve: &Curve, speed: f64) -> f64 {
    let [dry, extra, stribeck, viscous] = curve[usize::from(speed < 0.0)];
    if speed == 0.0 {
        return 0.0;
    }
    let bump = extra * (-(speed / stribeck).powi(2)).exp();
    speed.signum() * (dry + bump) + viscous * speed
}

/// Strokes of constant speed, all joints at once, forward and backward, gaps between them.
fn strokes(arm: &Arm, speeds: [f64; 2], count: usize, seed: u64) -> Vec<State> {
    let n = arm.n_joints();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut states = Vec::new();
    for _ in 0..count {
        let start: Vec<f64> = (0..n).map(|_| random.random_range(-2.5..2.5)).collect();
        let dq: Vec<f64> = (0..n)
            .map(|_| {
                let sign = if random.random_bool(0.5) { 1.0 } else { -1.0 };
                sign * random.random_range(speeds[0]..speeds[1])
            })
            .collect();
        for row in 0..50 {
            let t = 0.01 * f64::from(row);
            let q = start.iter().zip(&dq).map(|(q, v)| q + v * t).collect();
            states.push([q, dq.clone(), vec![0.0; n]]);
        }
    }
    states
}

fn sines(arm: &Arm, seconds: f64, seed: u64) -> Vec<State> {
    states_of(&motion(arm, MotionKind::Sines, seconds, 100.0, seed))
}

/// Slow strokes, strokes of many speeds, moves: their torque with friction and noise.
fn recordings(arm: &Arm) -> Motion {
    let mut states = strokes(arm, [0.01, 0.06], 120, 1);
    states.extend(strokes(arm, [0.1, 1.5], 160, 2));
    states.extend(sines(arm, 80.0, 3));
    rubbing(arm, &states, 0.02)
}

fn rubbing(arm: &Arm, states: &[State], noise: f64) -> Motion {
    let mut normal = normals(7);
    let t = (0..states.len()).map(|row| 0.01 * row as f64).collect();
    with_torque(executed(arm, t, states), |[_, dq, _], tau| {
        for ((tau, curve), &dq) in tau.iter_mut().zip(&CURVES).zip(dq) {
            *tau += truth_of(curve, dq) + noise * normal();
        }
    })
}

fn learned(library: LibraryKind, friction: FrictionKind) -> Reconstruction {
    let plan = LibraryOptions { library, friction, ..LibraryOptions::default() }.into();
    fit(&recordings(&reference_arm()), &plan)
}

/// Largest error of the friction of each joint over its true size, between two speeds.
fn worst(found: &Reconstruction, speeds: [f64; 2]) -> Vec<f64> {
    let n = found.model.n_joints();
    let torque = Torque::new(&found.model);
    let mut worst = vec![0.0_f64; n];
    for step in 0..=200 {
        let speed = speeds[0] + (speeds[1] - speeds[0]) * f64::from(step) / 200.0;
        for speed in [speed, -speed] {
            let friction = torque.friction(&vec![0.0; n], &vec![speed; n]).unwrap();
            // A gravity torque of the base joint that is constant is an offset of its friction.
            for (joint, worst) in worst.iter_mut().enumerate() {
                let truth = truth_of(&CURVES[joint], speed);
                *worst = worst.max(((friction[joint] - truth) / truth).abs());
            }
        }
    }
    worst
}

#[test]
fn three_recordings_give_the_terms_and_the_friction_curve() {
    let arm = reference_arm();

    let found = learned(LibraryKind::Energy { interaction: None }, FrictionKind::Auto);

    let Form::Energy(terms) = &found.model.form else { panic!("an energy model was asked for") };
    let truth = truth::true_energies(&arm);
    let missing: Vec<String> = (truth.keys())
        .filter(|term| !terms.iter().any(|w| w.term == **term))
        .map(torquewise_model::EnergyTerm::name)
        .collect();
    // sin(2 q2) of M11 has a hundredth of the size of the others: noise may hide it.
    assert!(missing.len() <= 1 && terms.len() <= truth.len() + 4, "{missing:?}, {}", terms.len());
    assert_eq!(found.steps.len(), 3, "slow strokes stand for standstill");
    let errors = worst(&found, [0.05, 1.5]);
    assert!(errors.iter().all(|&error| error < 0.05), "{errors:?}");
}

#[test]
fn the_product_library_finds_friction_of_its_own_joint_only() {
    let arm = reference_arm();

    let library = LibraryKind::Product { gravity_order: 2, trig_order: 3 };
    let found = learned(library, FrictionKind::Stribeck);

    assert_predicts(&found.model, &rubbing(&arm, &sines(&arm, 10.0, 5), 0.0), 2.0);
    let is_alone = |shaft: &[f64]| shaft.iter().filter(|share| **share != 0.0).count() == 1;
    assert!(found.model.friction.iter().all(|w| is_alone(&w.term.shaft)));
}

#[test]
fn an_empty_half_is_left_out() {
    let arm = reference_arm();
    let log = recordings(&arm);
    let forward: Vec<usize> = (0..log.n_rows()).filter(|&row| log.dq()[(row, 2)] >= 0.0).collect();
    let plan =
        LibraryOptions { friction: FrictionKind::Stribeck, ..LibraryOptions::default() }.into();

    let found = fit(&log.select(&forward), &plan);

    assert!(found.model.friction.iter().all(|w| w.coefficient.is_finite()));
    let third = found.model.friction.iter().filter(|w| w.term.acts_on(2));
    assert!(third.clone().count() > 0);
    assert!(found.patterns.present.contains(&Pattern::Standstill));
}
