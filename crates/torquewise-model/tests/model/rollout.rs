//! Rollouts against closed forms of one joint with friction, and whole windows.

use crate::friction::{EXACT, model, weighted};
use faer::Mat;
use torquewise_model::friction::FrictionLaw;
use torquewise_model::rollout::{Moving, drifts};
use torquewise_model::{FrictionTerm, Model, Torque};
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

/// A motion of two joints that obeys a model.
fn obeying(model: &Model) -> Result<Motion, Box<dyn std::error::Error>> {
    let (rows, of) = (2_000, |row: usize| 1e-3 * row as f64);
    let signal = |f: &dyn Fn(f64) -> f64| Mat::from_fn(rows, 2, |row, _| f(of(row)));
    let signals = Signals {
        joints: model.joints.clone(),
        t: (0..rows).map(of).collect(),
        q: signal(&|t| (3.0 * t).sin()),
        dq: signal(&|t| 3.0 * (3.0 * t).cos()),
        ddq: signal(&|t| -9.0 * (3.0 * t).sin()),
        tau: None,
    };
    let motion = Motion::new(signals.clone())?;
    let tau = Some(Torque::new(model).over(&motion)?);
    Ok(Motion::new(Signals { tau, ..signals })?)
}

#[test]
fn measured_ends_lie_in_the_band_of_arms_around_the_true_one_alone() {
    let arm = |viscous| knee(FrictionLaw::Viscous, viscous);
    let motion = obeying(&arm(0.4)).unwrap();
    let share = |around: [f64; 5]| {
        let found = drifts(&arm(0.4), &around.map(arm), &motion, &[0.5]).unwrap();
        found[0].covered.clone().unwrap()
    };

    // Friction of the second joint alone.
    assert!(share([0.2, 0.3, 0.4, 0.5, 0.6])[1] > 0.99);
    assert!(share([0.6, 0.7, 0.8, 0.9, 1.0])[1] < 0.01);
}
