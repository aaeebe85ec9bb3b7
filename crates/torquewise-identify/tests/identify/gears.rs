//! From simulated log with gears that press harder under load to what was planted.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use torquewise_identify::plan::{ChainOptions, FrictionKind};
use torquewise_identify::{Plan, Reconstruction, reconstruct, score};
use torquewise_model::friction::FrictionLaw;
use torquewise_motion::Motion;
use torquewise_sim::{Arm, MotionKind, MotionPlan, simulate};

/// Dry and viscous friction of each joint \[N·m\], \[N·m·s\].
const FRICTION: (f64, f64) = (1.5, 1.0);
/// Noise in the torque \[N·m\].
const NOISE: f64 = 0.1;

/// Motion of the arm with friction, and what a gear adds: joint, G \[N·m\], sign of motion.
fn log(seed: u64, gear: impl Fn(usize, f64, f64) -> f64) -> Motion {
    let arm = Arm::builtin("puma560-3").unwrap();
    let plan = MotionPlan { kind: MotionKind::Sines, seconds: 60.0, rate: 50.0, seed };
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut signals = simulate(&arm, &plan).unwrap().motion.into_signals();
    let tau = signals.tau.as_mut().unwrap();
    for row in 0..tau.nrows() {
        let q: Vec<f64> = signals.q.row(row).iter().copied().collect();
        let gravity = arm.gravity_torque(&q);
        for joint in 0..tau.ncols() {
            let dq = signals.dq[(row, joint)];
            let sign = (dq / 0.01).tanh();
            let unit: f64 = StandardNormal.sample(&mut random);
            tau[(row, joint)] += FRICTION.0 * sign
                + FRICTION.1 * dq
                + gear(joint, gravity[joint], sign)
                + NOISE * unit;
        }
    }
    Motion::new(signals).unwrap()
}

fn fit(motion: &Motion, friction: FrictionKind) -> Reconstruction {
    let plan = Plan::from(ChainOptions { friction, ..ChainOptions::default() });
    reconstruct(motion, &plan, torquewise_identify::UNWATCHED).unwrap()
}

#[test]
fn friction_under_load_is_found_where_gravity_loads_a_gear() {
    let loaded = |seed| log(seed, |_, gravity, sign| 0.1 * gravity.abs() * sign);
    let (train, test) = (loaded(1), loaded(2));

    let found = fit(&train, FrictionKind::Auto);

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
    let (with, without) = (errors(&found), errors(&fit(&train, FrictionKind::Stribeck)));
    assert!(with[1] < 0.5 * without[1], "{with:?} with load, {without:?} without");
}
