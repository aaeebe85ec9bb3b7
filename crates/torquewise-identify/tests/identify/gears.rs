//! From simulated log with gears that press harder under load to what was planted.

use crate::support::{chain, fit, motion, normals, reference_arm, with_torque};
use torquewise_identify::{FrictionKind, Reconstruction, score};
use torquewise_model::FrictionLaw;
use torquewise_motion::Motion;
use torquewise_sim::MotionKind;

/// Dry and viscous friction of each joint \[N·m\], \[N·m·s\].
const FRICTION: (f64, f64) = (1.5, 1.0);
/// Noise in the torque \[N·m\].
const NOISE: f64 = 0.1;

/// Motion of the arm with friction, and what a gear adds: joint, G \[N·m\], sign of motion.
fn log(seed: u64, gear: impl Fn(usize, f64, f64) -> f64) -> Motion {
    let arm = reference_arm();
    let mut normal = normals(seed);
    with_torque(motion(&arm, MotionKind::Sines, 60.0, 50.0, seed), |[q, dq, _], tau| {
        let gravity = arm.gravity_torque(q);
        for (joint, tau) in tau.iter_mut().enumerate() {
            let sign = (dq[joint] / 0.01).tanh();
            let gear = gear(joint, gravity[joint], sign);
            *tau += FRICTION.0 * sign + FRICTION.1 * dq[joint] + gear + NOISE * normal();
        }
    })
}

#[test]
fn friction_under_load_is_found_where_gravity_loads_a_gear() {
    let loaded = |seed| log(seed, |_, gravity, sign| 0.1 * gravity.abs() * sign);
    let (train, test) = (loaded(1), loaded(2));

    let found = fit(&train, &chain(FrictionKind::Auto));

    let load = |joint: usize| -> f64 {
        let own = found.model.friction.iter().filter(|w| w.term.load && w.term.acts_on(joint));
        own.filter(|w| w.term.law != FrictionLaw::Viscous).map(|w| w.coefficient).sum()
    };
    // The first axis is upright: gravity loads the others.
    for joint in [1, 2] {
        assert!((load(joint) - 0.1).abs() < 0.01, "joint {joint}: {}", load(joint));
    }
    let errors = |found: &Reconstruction| -> Vec<f64> {
        score(&found.model, &test).unwrap().joints.iter().map(|joint| joint.rmse).collect()
    };
    let (with, without) = (errors(&found), errors(&fit(&train, &chain(FrictionKind::Stribeck))));
    assert!(with[1] < 0.5 * without[1], "{with:?} with load, {without:?} without");
}
