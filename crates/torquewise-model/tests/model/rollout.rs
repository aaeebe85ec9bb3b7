//! Rollouts against closed forms of one joint with friction, and whole windows.

use crate::friction::{EXACT, model, weighted};
use faer::{Mat, MatRef};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use torquewise_model::rollout::{Moving, Others, drifts};
use torquewise_model::{FrictionLaw, FrictionTerm, Model, Torque};
use torquewise_motion::{Motion, Signals};

/// The second joint of the arm, of 0.5 kg·m², with some friction.
fn knee(law: FrictionLaw, coefficient: f64) -> Model {
    model(vec![weighted(FrictionTerm::of_joint(2, 1, law), coefficient)])
}

/// Where it is after some time without torque, from 1 rad/s at 0: position and speed.
fn coasted(model: &Model, milliseconds: usize) -> [f64; 2] {
    let torque = Torque::new(model);
    let mut arm = Moving { path: torque.path(), dq: vec![0.0, 1.0], ddq: vec![0.0; 2] };
    arm.path.step(&[0.0, 0.0]);
    for _ in 0..milliseconds {
        torque.step(&mut arm, &[0.0, 0.0], 1e-3).expect("an arm with inertia");
    }
    [arm.path.q()[1], arm.dq[1]]
}

#[test]
fn a_viscous_joint_coasts_along_an_exponential() {
    let [q, dq] = coasted(&knee(FrictionLaw::Viscous, 0.4), 1_000);

    // v = e^(−0.8 t)
    assert!((dq - (-0.8_f64).exp()).abs() < 1e-3, "{dq}");
    assert!((q - (1.0 - (-0.8_f64).exp()) / 0.8).abs() < 1e-3, "{q}");
}

#[test]
fn dry_friction_stops_a_joint_and_holds_it() {
    for law in [EXACT, FrictionLaw::Coulomb { width: 1e-3 }, FrictionLaw::Dahl { travel: 1e-3 }] {
        // v = 1 − t until it stands at 0.5 rad, but for what the element gives way.
        let [q, dq] = coasted(&knee(law, 0.5), 3_000);

        assert!((q - 0.5).abs() < 3e-3, "{law:?}: {q}");
        assert!(dq.abs() < 1e-2, "{law:?}: {dq}");
    }
}

/// A motion of two joints that obeys a model, of all times \[s\] at which torque is recorded.
fn obeying(model: &Model, rows: usize, seconds: f64, way: &dyn Fn(f64) -> [f64; 3]) -> Motion {
    let of = |row: usize| seconds * row as f64;
    let signal = |k: usize| Mat::from_fn(rows, 2, |row, _| way(of(row))[k]);
    let [q, dq, ddq] = [0, 1, 2].map(signal);
    let t = (0..rows).map(of).collect();
    let signals = Signals { joints: model.joints.clone(), t, q, dq, ddq, tau: None };
    let motion = Motion::new(signals.clone()).expect("a sound motion");
    let tau = Some(Torque::new(model).over(&motion).expect("the same joints"));
    Motion::new(Signals { tau, ..signals }).expect("a sound motion")
}

/// Share of the windows of some length \[s\] in which the second joint ends in the band of some arms.
fn covered(motion: &Motion, long: f64, viscous: &[f64], noise: [Vec<f64>; 2]) -> f64 {
    let arm = |viscous: &f64| knee(FrictionLaw::Viscous, *viscous);
    let others = Others { models: viscous.iter().map(arm).collect(), noise, seed: 1 };
    let found = drifts(&arm(&0.4), Some(&others), motion, &[long]).unwrap();
    found[0].covered.clone().unwrap()[1]
}

fn no_noise() -> [Vec<f64>; 2] {
    [vec![0.0; 2], vec![0.0; 2]]
}

fn wave(t: f64) -> [f64; 3] {
    let (sin, cos) = (3.0 * t).sin_cos();
    [sin, 3.0 * cos, -9.0 * sin]
}

#[test]
fn measured_ends_lie_in_the_band_of_arms_around_the_true_one_alone() {
    let motion = obeying(&knee(FrictionLaw::Viscous, 0.4), 2_000, 1e-3, &wave);

    assert!(covered(&motion, 0.5, &[0.2, 0.3, 0.4, 0.5, 0.6], no_noise()) > 0.99);
    assert!(covered(&motion, 0.5, &[0.6, 0.7, 0.8, 0.9, 1.0], no_noise()) < 0.01);
}

#[test]
fn the_band_knows_the_noise_of_measured_states() {
    let clean = obeying(&knee(FrictionLaw::Viscous, 0.4), 5_000, 1e-3, &wave);
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut noisy = |x: MatRef<'_, f64>, deviation: f64| {
        Mat::from_fn(x.nrows(), 2, |row, joint| {
            let unit: f64 = StandardNormal.sample(&mut random);
            x[(row, joint)] + deviation * unit
        })
    };
    let (q, dq) = (noisy(clean.q(), 1e-3), noisy(clean.dq(), 2e-2));
    let motion = Motion::new(Signals { q, dq, ..clean.into_signals() }).unwrap();

    // What noise in q̇ leaves of the torque makes a band a hundredth as wide.
    assert!(covered(&motion, 0.1, &[0.4; 50], no_noise()) < 0.03);
    let share = covered(&motion, 0.1, &[0.4; 50], [vec![1e-3; 2], vec![2e-2; 2]]);
    assert!((0.8..0.98).contains(&share), "{share}");
}

#[test]
fn the_band_knows_the_noise_of_the_torque_white_or_not() {
    let clean = obeying(&knee(FrictionLaw::Viscous, 0.4), 5_000, 1e-3, &wave);
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for kept in [0.0, 0.98] {
        let mut noise = 0.0;
        let tau = Mat::from_fn(5_000, 2, |row, joint| {
            let unit: f64 = StandardNormal.sample(&mut random);
            noise = if joint == 0 { noise } else { kept * noise + 0.5 * unit };
            clean.tau().unwrap()[(row, joint)] + if joint == 0 { 0.0 } else { noise }
        });
        let noisy =
            Motion::new(Signals { tau: Some(tau), ..clean.clone().into_signals() }).unwrap();

        let share = covered(&noisy, 0.2, &[0.4; 50], no_noise());

        assert!((0.8..0.98).contains(&share), "{kept}: {share}");
    }
}

#[test]
fn the_band_knows_that_torques_jump_between_rows() {
    // 4 rad/s² for a time, then as much the other way, that rows do not fall on.
    let turn = 0.173_205;
    let way = |t: f64| {
        let (count, since) = ((t / turn).floor(), t % turn);
        let sign = if count % 2.0 == 0.0 { 4.0 } else { -4.0 };
        let speed = if sign > 0.0 { sign * since } else { 4.0 * turn + sign * since };
        let gone = if sign > 0.0 { 0.0 } else { 4.0 * turn * since };
        [2.0 * turn * turn * count + gone + 0.5 * sign * since * since, speed, sign]
    };
    let motion = obeying(&knee(FrictionLaw::Viscous, 0.4), 2_000, 1e-2, &way);

    let share = covered(&motion, 0.5, &[0.4; 50], no_noise());

    assert!((0.8..0.98).contains(&share), "{share}");
}
