//! From simulated logs with and without something no chain of rigid bodies does to what is said of
//! it.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use torquewise_identify::plan::{ChainOptions, FrictionKind};
use torquewise_identify::{Plan, Reconstruction, Warning, reconstruct};
use torquewise_model::model::OmittedTerms;
use torquewise_model::{
    EnergyTerm, Form, Model, Place, Term, Torque, Training, Trig, Weighted, from_json, to_json,
};
use torquewise_motion::Motion;
use torquewise_sim::{Arm, MotionKind, MotionPlan, simulate};

fn simulated(kind: MotionKind, seed: u64) -> Motion {
    let arm = Arm::builtin("puma560-3").unwrap();
    let plan = MotionPlan { kind, seconds: 40.0, rate: 50.0, seed };
    simulate(&arm, &plan).unwrap().motion
}

/// The reference arm in motion, with further terms in its energy and white noise in its torque.
fn motion(more: &[(EnergyTerm, f64)], noise: f64) -> Motion {
    let motion = simulated(MotionKind::Sines, 1);
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

fn torque_of(motion: &Motion, more: &[(EnergyTerm, f64)]) -> faer::Mat<f64> {
    let weighted =
        |(term, coefficient)| Weighted { term, coefficient, std_error: 0.0, inclusion: None };
    let model = Model {
        joints: motion.joints().to_vec(),
        form: Form::Energy(more.iter().cloned().map(weighted).collect()),
        friction: vec![],
        chain: None,
        stages: vec![],
        training: Training::default(),
        choices: vec![],
    };
    Torque::new(&model).over(motion).unwrap()
}

fn fit(motion: &Motion) -> Reconstruction {
    let plan = Plan::from(ChainOptions { friction: FrictionKind::None, ..ChainOptions::default() });
    reconstruct(motion, &plan, &mut |_| {}).unwrap()
}

fn test_omitted_terms(found: &Reconstruction) -> &OmittedTerms {
    found.model.training.omitted.as_ref().unwrap()
}

fn warned(found: &Reconstruction) -> Option<&Warning> {
    found.warnings.iter().find(|warning| matches!(warning, Warning::OmittedTerm { .. }))
}

/// A spring between the base and the third link: what no mass does.
fn spring() -> EnergyTerm {
    let function = Term::one(3).times(Trig::Cos, 0, 1, 1).times(Trig::Cos, 2, 1, 1);
    EnergyTerm { place: Place::Potential, function }
}

/// A coupling that the masses of the reference arm, which has others, do not make.
fn gear() -> EnergyTerm {
    let function = Term::one(3).times(Trig::Cos, 1, 1, 1).times(Trig::Cos, 2, 2, 1);
    EnergyTerm { place: Place::Inertia(0, 1), function }
}

#[test]
fn planted_terms_are_found_one_by_one_and_taken_in() {
    let both = [(spring(), 5.0), (gear(), 0.8)];
    let found = fit(&motion(&both, 0.2));

    let joined = found.model.choices.iter().filter(|c| c.what == "term beyond the chain");
    let mut names: Vec<&str> = joined.map(|choice| choice.chosen.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["M12: cos(q2)*cos(2*q3)", "V: cos(q1)*cos(q3)"]);
    let tried = test_omitted_terms(&found);
    assert_eq!(warned(&found), None, "{tried}");
    // Nothing is left but the noise, on a motion it has not seen either.
    for rms in &found.model.training.residual_rms {
        assert!((rms / 0.2 - 1.0).abs() < 0.05, "{rms}");
    }
    let other = simulated(MotionKind::Sines, 7);
    let expected = other.tau().unwrap() + torque_of(&other, &both);
    let torque = Torque::new(&found.model).over(&other).unwrap();
    for joint in 0..3 {
        let error = (torque.col(joint) - expected.col(joint)).norm_l2();
        let part = error / expected.col(joint).norm_l2();
        assert!(part < 0.02, "joint {joint}: {part}");
    }
    // What was tried goes into the model file and comes back.
    let kept = from_json(&to_json(&found.model).unwrap()).unwrap();
    assert_eq!(kept.training.omitted, found.model.training.omitted);
}

#[test]
fn without_it_nothing_is_said() {
    for noise in [0.0, 0.2, 2.0] {
        let found = fit(&motion(&[], noise));

        let tried = test_omitted_terms(&found);
        assert_eq!(warned(&found), None, "{noise}: {tried}");
        // Library, springs, and the friction that was not asked for.
        assert_eq!(tried.candidates, 84 + 42 + 51, "{tried}");
        assert!(noise == 0.0 || tried.best[0].of_residual() < 0.01, "{noise}: {tried}");
    }
}

#[test]
fn a_fit_that_grows_gives_the_same_bits_at_any_number_of_threads() {
    let motion = motion(&[(spring(), 5.0)], 0.2);
    let fit_with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        to_json(&pool.install(|| fit(&motion)).model).unwrap()
    };

    let alone = fit_with(1);

    assert!(alone.contains("term beyond the chain"));
    assert!(alone == fit_with(3), "two models");
}
