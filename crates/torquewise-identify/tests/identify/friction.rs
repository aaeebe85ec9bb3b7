//! From three recordings of an arm with friction to its terms and its friction curve, stepwise.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

use crate::truth;
use faer::Mat;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use torquewise_identify::plan::{FrictionKind, LibraryOptions};
use torquewise_identify::{LibraryKind, Reconstruction, reconstruct, score};
use torquewise_model::{Form, Torque};
use torquewise_motion::{Motion, Pattern, Signals};
use torquewise_sim::{Arm, MotionKind, MotionPlan, simulate};

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
fn strokes(arm: &Arm, speeds: [f64; 2], count: usize, seed: u64) -> Vec<[Vec<f64>; 3]> {
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

fn sines(arm: &Arm, seconds: f64, seed: u64) -> Vec<[Vec<f64>; 3]> {
    let plan = MotionPlan { kind: MotionKind::Sines, seconds, rate: 100.0, seed };
    let sines = simulate(arm, &plan).unwrap().motion;
    let row_of = |x: faer::MatRef<'_, f64>, row: usize| x.row(row).iter().copied().collect();
    (0..sines.n_rows())
        .map(|row| [sines.q(), sines.dq(), sines.ddq()].map(|x| row_of(x, row)))
        .collect()
}

/// Slow strokes, strokes of many speeds, moves: their torque with friction and noise.
fn recordings(arm: &Arm) -> Motion {
    let mut states = strokes(arm, [0.01, 0.06], 120, 1);
    states.extend(strokes(arm, [0.1, 1.5], 160, 2));
    states.extend(sines(arm, 80.0, 3));
    rubbing(arm, &states, 0.02)
}

fn rubbing(arm: &Arm, states: &[[Vec<f64>; 3]], noise: f64) -> Motion {
    let (m, n) = (states.len(), arm.n_joints());
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let signal = |k: usize| Mat::from_fn(m, n, |row, joint| states[row][k][joint]);
    let tau = Mat::from_fn(m, n, |row, joint| {
        let [q, dq, ddq] = &states[row];
        let unit: f64 = StandardNormal.sample(&mut random);
        let rigid = arm.inverse_dynamics(q, dq, ddq)[joint];
        rigid + truth_of(&CURVES[joint], dq[joint]) + noise * unit
    });
    let t = (0..m).map(|row| 0.01 * row as f64).collect();
    let joints = arm.joints().to_vec();
    let (q, dq, ddq) = (signal(0), signal(1), signal(2));
    Motion::new(Signals { joints, t, q, dq, ddq, tau: Some(tau) }).unwrap()
}

fn fit(library: LibraryKind, friction: FrictionKind) -> Reconstruction {
    let arm = Arm::builtin("puma560-3").unwrap();
    let plan = LibraryOptions { library, friction, ..LibraryOptions::default() }.into();
    reconstruct(&recordings(&arm), &plan, torquewise_identify::UNWATCHED).unwrap()
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
    let arm = Arm::builtin("puma560-3").unwrap();

    let found = fit(LibraryKind::Energy { interaction: None }, FrictionKind::Auto);

    let Form::Energy(terms) = &found.model.form else { panic!("an energy model was asked for") };
    let truth = truth::energies(&arm);
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
    let arm = Arm::builtin("puma560-3").unwrap();

    let library = LibraryKind::Product { gravity_order: 2, trig_order: 3 };
    let found = fit(library, FrictionKind::Stribeck);

    let states = sines(&arm, 10.0, 5);
    let scores = score(&found.model, &rubbing(&arm, &states, 0.0)).unwrap();
    let percent: Vec<f64> = scores.joints.iter().map(|joint| joint.nrmse_percent).collect();
    assert!(percent.iter().all(|&percent| percent < 2.0), "{percent:?}");
    assert!(
        found
            .model
            .friction
            .iter()
            .all(|w| { w.term.shaft.iter().filter(|share| **share != 0.0).count() == 1 })
    );
}

#[test]
fn an_empty_half_is_left_out() {
    let arm = Arm::builtin("puma560-3").unwrap();
    let log = recordings(&arm);
    let forward: Vec<usize> = (0..log.n_rows()).filter(|&row| log.dq()[(row, 2)] >= 0.0).collect();
    let plan =
        LibraryOptions { friction: FrictionKind::Stribeck, ..LibraryOptions::default() }.into();

    let found = reconstruct(&log.select(&forward), &plan, torquewise_identify::UNWATCHED).unwrap();

    assert!(found.model.friction.iter().all(|w| w.coefficient.is_finite()));
    let third = found.model.friction.iter().filter(|w| w.term.acts_on(2));
    assert!(third.clone().count() > 0);
    assert!(found.patterns.present.contains(&Pattern::Standstill));
}
