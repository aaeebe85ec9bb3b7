//! Simulated log with friction → the arm and the friction it was simulated with, by a chain.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use torquewise_dynamics::{Arm, MotionKind, MotionPlan, simulate};
use torquewise_identify::{FrictionKind, Method, Plan, Reconstruction, reconstruct, score};
use torquewise_model::friction::FrictionLaw;
use torquewise_model::{FrictionTerm, Torque, check, from_json, to_json};
use torquewise_motion::Motion;

/// White noise in the torque, as a part of its spread.
const NOISE: f64 = 0.01;

fn moving(arm: &Arm, seconds: f64, seed: u64) -> Motion {
    let plan = MotionPlan { kind: MotionKind::Sines, seconds, rate: 50.0, seed };
    simulate(arm, &plan).unwrap().motion
}

/// The motion with friction and noise in its torque.
fn rubbing(motion: &Motion, friction: &[(FrictionTerm, f64)], noise: f64) -> Motion {
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let mut signals = motion.clone().into_signals();
    let (dq, tau) = (&signals.dq, signals.tau.as_mut().unwrap());
    for joint in 0..tau.ncols() {
        let m = tau.nrows() as f64;
        let mean = tau.col(joint).sum() / m;
        let spread = (tau.col(joint).squared_norm_l2() / m - mean * mean).sqrt();
        for row in 0..tau.nrows() {
            let dq: Vec<f64> = dq.row(row).iter().copied().collect();
            let rubs: f64 = friction.iter().map(|(f, c)| c * f.torque(joint, &dq)).sum();
            let unit: f64 = StandardNormal.sample(&mut random);
            tau[(row, joint)] += rubs + noise * spread * unit;
        }
    }
    Motion::new(signals).unwrap()
}

fn fit(motion: &Motion, friction: FrictionKind) -> Reconstruction {
    let t0 = std::time::Instant::now();
    let plan = Plan { method: Method::Chain, friction, ..Plan::default() };
    let found = reconstruct(motion, &plan, &mut |_| {}).unwrap();
    eprintln!("{:?} {} terms of {}", t0.elapsed(), found.model.n_coefficients(), found.candidates);
    for c in &found.model.choices {
        let from: Vec<String> = c.from.iter().map(|f| format!("{} {:.5}", f.label, f.error)).collect();
        eprintln!("  {} -> {}: {}", c.what, c.chosen, from.join(", "));
    }
    for f in &found.model.friction {
        eprintln!("  {} {:.4} ± {:.4}", f.term.name(), f.coefficient, f.std_error);
    }
    found
}

/// Exact dry friction: the learner smooths the sign.
const DRY: FrictionLaw = FrictionLaw::Coulomb { width: 0.0 };

fn linear(n: usize, joint: usize, [offset, viscous, dry]: [f64; 3]) -> Vec<(FrictionTerm, f64)> {
    let laws = [(FrictionLaw::Offset, offset), (FrictionLaw::Viscous, viscous), (DRY, dry)];
    laws.map(|(law, c)| (FrictionTerm::of_joint(n, joint, law), c)).to_vec()
}

/// The coefficient of a law on a shaft, whatever its width.
fn coefficient(found: &Reconstruction, shaft: &[f64], name: &str) -> f64 {
    let like = |term: &FrictionTerm| {
        let law = match term.law {
            FrictionLaw::Offset => "offset",
            FrictionLaw::Viscous => "viscous",
            FrictionLaw::Coulomb { .. } => "dry",
            FrictionLaw::Stribeck { .. } => "stribeck",
        };
        term.shaft == shaft && law == name
    };
    found.model.friction.iter().find(|w| like(&w.term)).unwrap().coefficient
}

fn choice<'a>(found: &'a Reconstruction, what: &str) -> &'a str {
    &found.model.choices.iter().find(|choice| choice.what == what).unwrap().chosen
}

#[test]
fn linear_friction_is_recovered() {
    let arm = Arm::builtin("puma560-3").unwrap();
    let truth = [[1.0, 6.0, 8.0], [-2.0, 9.0, 7.0], [0.5, 2.0, 3.0]];
    let friction: Vec<_> = (0..3).flat_map(|joint| linear(3, joint, truth[joint])).collect();
    let log = rubbing(&moving(&arm, 60.0, 1), &friction, NOISE);

    let found = fit(&log, FrictionKind::Auto);

    for (joint, truth) in truth.into_iter().enumerate() {
        let mut shaft = [0.0; 3];
        shaft[joint] = 1.0;
        for (law, truth) in ["offset", "viscous", "dry"].into_iter().zip(truth) {
            let found = coefficient(&found, &shaft, law);
            eprintln!("{joint} {law} {truth} {found}");
        }
    }
    let test = rubbing(&moving(&arm, 10.0, 2), &friction, 0.0);
    eprintln!("{:?}", score(&found.model, &test).unwrap());
    assert_eq!(choice(&found, "friction"), "linear");
    let json = to_json(&found.model).unwrap();
    assert_eq!(from_json(&json).unwrap(), found.model);
    let _ = (Torque::new(&found.model), check(&found.model, &[]));
}

#[test]
fn shared() {
    let arm = Arm::builtin("puma560-3").unwrap();
    let mut friction: Vec<_> = (0..3).flat_map(|joint| linear(3, joint, [0.0, 2.0, 2.0])).collect();
    let on = |law| FrictionTerm { shaft: vec![0.0, 1.0, 1.0], ..FrictionTerm::of_joint(3, 0, law) };
    friction.extend([(on(FrictionLaw::Viscous), 4.0), (on(DRY), 5.0)]);
    let log = rubbing(&moving(&arm, 60.0, 1), &friction, NOISE);

    let found = fit(&log, FrictionKind::Linear);
    assert_eq!(choice(&found, "shared shaft"), "dq2 + dq3");
}

#[test]
fn stribeck() {
    let arm = Arm::builtin("planar-2").unwrap();
    let mut friction: Vec<_> = (0..2).flat_map(|joint| linear(2, joint, [0.0, 2.0, 2.0])).collect();
    for joint in 0..2 {
        let law = FrictionLaw::Stribeck { speed: 0.1, width: 0.0 };
        friction.push((FrictionTerm::of_joint(2, joint, law), 2.0));
    }
    let log = rubbing(&moving(&arm, 60.0, 1), &friction, NOISE);

    let found = fit(&log, FrictionKind::Auto);
    assert!(choice(&found, "friction").starts_with("stribeck"));
}
