//! Simulated logs with and without something no chain of rigid bodies does → what is said of it.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use torquewise_dynamics::{Arm, MotionKind, MotionPlan, simulate};
use torquewise_identify::{Method, Plan, Reconstruction, Warning, reconstruct};
use torquewise_model::model::Overlooked;
use torquewise_model::{
    EnergyTerm, Form, Model, Place, Term, Torque, Training, Trig, Weighted, from_json, to_json,
};
use torquewise_motion::Motion;

/// The reference arm in motion, with a further term in its energy and white noise in its torque.
fn motion(more: Option<(EnergyTerm, f64)>, noise: f64) -> Motion {
    let arm = Arm::builtin("puma560-3").unwrap();
    let plan = MotionPlan { kind: MotionKind::Sines, seconds: 40.0, rate: 50.0, seed: 1 };
    let motion = simulate(&arm, &plan).unwrap().motion;
    let extra = torque_of(&motion, more);
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let mut signals = motion.into_signals();
    let tau = signals.tau.as_mut().unwrap();
    *tau += extra;
    for joint in 0..tau.ncols() {
        for tau in tau.col_as_slice_mut(joint) {
            let unit: f64 = StandardNormal.sample(&mut random);
            *tau += noise * unit;
        }
    }
    Motion::new(signals).unwrap()
}

fn torque_of(motion: &Motion, more: Option<(EnergyTerm, f64)>) -> faer::Mat<f64> {
    let weighted =
        |(term, coefficient)| Weighted { term, coefficient, std_error: 0.0, inclusion: None };
    let model = Model {
        joints: motion.joints().to_vec(),
        form: Form::Energy(more.into_iter().map(weighted).collect()),
        friction: vec![],
        stages: vec![],
        training: Training::default(),
        choices: vec![],
    };
    Torque::new(&model).over(motion).unwrap()
}

fn fit(motion: &Motion) -> Reconstruction {
    let plan = Plan { method: Method::Chain, ..Plan::default() };
    reconstruct(motion, &plan, &mut |_| {}).unwrap()
}

fn overlooked(found: &Reconstruction) -> &Overlooked {
    found.model.training.overlooked.as_ref().unwrap()
}

fn warned(found: &Reconstruction) -> Option<&Warning> {
    found.warnings.iter().find(|warning| matches!(warning, Warning::Overlooked { .. }))
}

/// A spring between the base and the third link: what no mass does.
fn spring() -> EnergyTerm {
    let function = Term::one(3).times(Trig::Cos, 0, 1, 1).times(Trig::Cos, 2, 1, 1);
    EnergyTerm { place: Place::Potential, function }
}

#[test]
fn a_planted_term_is_the_best_of_those_overlooked() {
    let found = fit(&motion(Some((spring(), 5.0)), 0.2));

    let text = overlooked(&found).to_string();
    assert_eq!(overlooked(&found).best[0].term, "V: cos(q1)*cos(q3)", "{text}");
    let warning = warned(&found).unwrap().to_string();
    assert!(warning.starts_with("V: cos(q1)*cos(q3) would lower the residual of joint"), "{text}");
    // It goes into the model file and comes back.
    let kept = from_json(&to_json(&found.model).unwrap()).unwrap();
    assert_eq!(kept.training.overlooked, found.model.training.overlooked);
}

#[test]
fn without_it_nothing_is_said() {
    for noise in [0.0, 0.2, 2.0] {
        let found = fit(&motion(None, noise));

        let tried = overlooked(&found);
        assert_eq!(warned(&found), None, "{noise}: {tried}");
        // Library, cos and sin of 2q in V, and the friction that was not asked for.
        assert_eq!(tried.candidates, 84 + 6 + 51, "{tried}");
        assert!(noise == 0.0 || tried.best[0].of_residual() < 0.01, "{noise}: {tried}");
    }
}
