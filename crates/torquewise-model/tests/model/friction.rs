//! Friction as torque and as text: the Stribeck curve, coupled shafts, hostile files.

#![expect(clippy::float_cmp, reason = "the same bits are meant")]

use crate::two_joints;
use torquewise_model::checks::driving_friction;
use torquewise_model::model::Candidate;
use torquewise_model::{
    Choice, Direction, Form, FrictionLaw, FrictionTerm, Model, ModelError, Stage, Term, Torque,
    Trig, Weighted, check, from_json, to_json,
};

pub(crate) fn weighted<T>(term: T, coefficient: f64) -> Weighted<T> {
    Weighted { term, coefficient, std_error: 0.01, inclusion: Some(0.98) }
}

/// Two joints with an inertia, a Coriolis and a gravity term, and this friction.
pub(crate) fn model(friction: Vec<Weighted<FrictionTerm>>) -> Model {
    let one = Term::one(2);
    let gravity = one.clone().times(Trig::Sin, 0, 1, 1);
    let coriolis = one.clone().times(Trig::Sin, 1, 1, 1).times_dq(0).times_dq(1);
    let first = vec![
        weighted(one.clone().times_ddq(0), 2.0),
        weighted(coriolis, -0.4),
        weighted(gravity, 3.3),
    ];
    two_joints(Form::Torque(vec![first, vec![weighted(one.times_ddq(1), 0.5)]]), friction)
}

/// The model with a step before that found the same but for this friction.
fn after_a_step(mut model: Model, friction: Vec<Weighted<FrictionTerm>>) -> Model {
    let (name, form) = ("uniform".into(), model.form.clone());
    model.stages = vec![Stage { name, rows: 7, candidates: 9, form, friction }];
    model
}

pub(crate) const EXACT: FrictionLaw = FrictionLaw::Coulomb { width: 0.0 };

pub(crate) fn directed(law: FrictionLaw, direction: Direction) -> FrictionTerm {
    FrictionTerm { direction, ..FrictionTerm::of_joint(2, 1, law) }
}

/// One of each law, the offset on a coupled shaft.
fn all_laws() -> Vec<Weighted<FrictionTerm>> {
    let coupled =
        |law| FrictionTerm { shaft: vec![1.0, -0.5], law, direction: Direction::Both, load: false };
    vec![
        weighted(coupled(FrictionLaw::Offset), 0.3),
        weighted(coupled(FrictionLaw::Viscous), 1.2),
        weighted(directed(FrictionLaw::Coulomb { width: 0.01 }, Direction::Backward), 0.7),
        weighted(directed(FrictionLaw::Viscous, Direction::Backward), 0.2),
        weighted(directed(FrictionLaw::Stribeck { speed: 0.05, width: 0.0 }, Direction::Both), 0.4),
    ]
}

#[test]
fn three_terms_are_the_stribeck_curve() {
    let (f_c, f_s, v_s, f_v): (f64, f64, f64, f64) = (1.5, 2.3, 0.08, 0.6);
    let stribeck = FrictionLaw::Stribeck { speed: v_s, width: 0.0 };
    let part = |law, coefficient| weighted(FrictionTerm::of_joint(2, 1, law), coefficient);
    let friction =
        vec![part(EXACT, f_c), part(stribeck, f_s - f_c), part(FrictionLaw::Viscous, f_v)];
    let torque = Torque::new(&model(friction));

    for v in [1e-6_f64, 0.01, 0.08, 0.2, 1.0, 5.0] {
        // (17) as the paper prints it, forward; it is odd.
        let forward = f_c + (f_s - f_c) * (-v * v / (v_s * v_s)).exp() + f_v * v;
        for (dq, expected) in [(v, forward), (-v, -forward)] {
            let found = torque.friction(&[0.0; 2], &[9.0, dq]).unwrap();
            assert_eq!(found[0], 0.0);
            assert!((found[1] - expected).abs() < 1e-12 * expected.abs(), "{v}: {found:?}");
        }
    }
    assert_eq!(torque.friction(&[0.0; 2], &[1.0, 0.0]).unwrap(), [0.0, 0.0], "sign(0) is 0");
}

#[test]
fn a_width_smooths_the_reversal_and_nothing_else() {
    let width = 0.01;
    let smooth = FrictionLaw::Coulomb { width };

    assert!((smooth.value(width) - 1.0_f64.tanh()).abs() < 1e-15);
    assert!((smooth.value(1e-9) - 1e-7).abs() < 1e-15, "slope 1/width at 0");
    for v in [0.2, 3.0] {
        assert_eq!([smooth.value(v), smooth.value(-v)], [EXACT.value(v), EXACT.value(-v)]);
    }
    let stribeck = FrictionLaw::Stribeck { speed: 0.05, width }.value(0.005);
    let expected = (-0.01_f64).exp() * 0.5_f64.tanh();
    assert!((stribeck - expected).abs() < 1e-15);
}

#[test]
fn a_directed_law_acts_in_its_direction_only() {
    for law in [EXACT, FrictionLaw::Viscous, FrictionLaw::Stribeck { speed: 1.0, width: 0.1 }] {
        let [both, backward] = [Direction::Both, Direction::Backward].map(|d| directed(law, d));
        for v in [0.3, -0.3] {
            let dq = [7.0, v];
            assert_eq!(backward.value(&dq), if v < 0.0 { law.value(v) } else { 0.0 }, "{law:?}");
            assert_eq!(both.value(&dq), law.value(v));
        }
        assert_eq!(backward.value(&[1.0, 0.0]), 0.0);
    }
}

#[test]
fn a_coupled_shaft_does_the_work_of_its_friction() {
    let shaft = vec![1.0, -0.5];
    for law in [EXACT, FrictionLaw::Viscous, FrictionLaw::Stribeck { speed: 0.4, width: 0.02 }] {
        let term =
            FrictionTerm { shaft: shaft.clone(), law, direction: Direction::Both, load: false };
        let torque = Torque::new(&model(vec![weighted(term, 1.7)]));
        for dq in [[0.3, 0.1], [-0.2, 0.9], [0.05, 0.1]] {
            let v = dq[0] - 0.5 * dq[1];
            let tau = torque.friction(&[0.0; 2], &dq).unwrap();
            let power: f64 = tau.iter().zip(dq).map(|(tau, dq)| tau * dq).sum();
            assert!((power - 1.7 * law.value(v) * v).abs() < 1e-15, "{law:?} {dq:?}");
            assert!(power >= 0.0, "friction takes energy");
        }
    }
}

#[test]
fn friction_is_a_part_of_its_own() {
    let (rubbing, bare) = (model(all_laws()), model(vec![]));
    let (with, without) = (Torque::new(&rubbing), Torque::new(&bare));
    let (q, dq, ddq) = ([0.4, 1.1], [0.2, -0.9], [1.0, 2.0]);

    assert_eq!(with.gravity(&q).unwrap(), without.gravity(&q).unwrap());
    assert_eq!(with.gravity(&q).unwrap(), [3.3 * 0.4_f64.sin(), 0.0]);
    assert_eq!(with.coriolis(&q, &dq).unwrap(), without.coriolis(&q, &dq).unwrap());
    assert_eq!(with.mass_matrix(&q).unwrap(), without.mass_matrix(&q).unwrap());
    let states = [(q.to_vec(), dq.to_vec())];
    assert_eq!(check(&rubbing, &states).unwrap(), check(&bare, &states).unwrap());
    let (whole, rest) = (with.at(&q, &dq, &ddq).unwrap(), without.at(&q, &dq, &ddq).unwrap());
    let friction = with.friction(&q, &dq).unwrap();
    for joint in 0..2 {
        assert!((whole[joint] - rest[joint] - friction[joint]).abs() < 1e-14);
    }
    assert!(friction.iter().all(|tau| tau.abs() > 0.1), "{friction:?}");
    assert!(matches!(with.friction(&q, &[1.0]), Err(ModelError::Shape { what: "dq", .. })));
    assert_eq!(rubbing.n_coefficients(), bare.n_coefficients() + 5);
    assert_eq!([rubbing.active(), bare.active()], [vec![5, 6], vec![3, 1]]);
}

#[test]
fn a_saved_model_keeps_friction_steps_and_choices() {
    let mut whole = model(all_laws());
    whole.friction[1].coefficient = 0.1 + 0.2;
    let friction = vec![whole.friction[2].clone()];
    let mut whole = after_a_step(whole, friction);
    let candidate = |label: &str, error, complexity| Candidate {
        label: label.into(),
        error,
        std_error: 0.002,
        complexity,
    };
    whole.choices = vec![Choice {
        what: "friction".into(),
        chosen: "sign, viscous".into(),
        rule: "one standard error, 5 blocks in time".into(),
        from: vec![candidate("none", 0.31, 0), candidate("sign, viscous", 0.04, 4)],
    }];

    let read = from_json(&to_json(&whole).unwrap()).unwrap();

    assert_eq!(read, whole);
    let early = read.after_step(1).unwrap();
    assert_eq!(early.friction, [whole.friction[2].clone()]);
    assert_eq!(early.choices, whole.choices);
}

#[test]
fn a_file_without_optional_parts_reads() {
    let plain = include_str!("plain.json");

    let read = from_json(plain).unwrap();

    assert!(read.friction.is_empty() && read.choices.is_empty());
    let tau = Torque::new(&read).at(&[0.5], &[4.0], &[0.0]).unwrap();
    assert_eq!(tau, [3.3 * 0.5_f64.sin()]);
    for version in ["0", "3"] {
        let other = plain.replace("\"version\": 1", &format!("\"version\": {version}"));
        assert!(matches!(from_json(&other), Err(ModelError::Version { known: 1, .. })));
    }
}

#[test]
fn friction_that_cannot_be_is_refused() {
    let good = all_laws()[4].clone();
    let law = |law| Weighted { term: directed(law, Direction::Both), ..good.clone() };
    let shaft = |shaft: Vec<f64>| Weighted {
        term: FrictionTerm { shaft, ..good.term.clone() },
        ..good.clone()
    };
    let offset = directed(FrictionLaw::Offset, Direction::Backward);
    let hostile = [
        shaft(vec![1.0]),
        shaft(vec![0.0, 1.0, 0.0]),
        shaft(vec![0.0, 0.0]),
        shaft(vec![f64::NAN, 1.0]),
        law(FrictionLaw::Stribeck { speed: 0.0, width: 0.0 }),
        law(FrictionLaw::Stribeck { speed: -0.1, width: 0.0 }),
        law(FrictionLaw::Stribeck { speed: f64::INFINITY, width: 0.0 }),
        law(FrictionLaw::Stribeck { speed: 0.1, width: f64::NAN }),
        law(FrictionLaw::Coulomb { width: -1e-3 }),
        law(FrictionLaw::Coulomb { width: f64::INFINITY }),
        Weighted { term: offset, ..good.clone() },
        Weighted { coefficient: f64::NAN, ..good.clone() },
        Weighted { std_error: f64::INFINITY, ..good.clone() },
    ];

    assert!(to_json(&model(vec![good.clone()])).is_ok());
    for broken in hostile {
        let place = format!("{broken:?}");
        let staged = after_a_step(model(vec![]), vec![broken.clone()]);
        assert!(to_json(&staged).is_err(), "{place}");
        assert!(to_json(&model(vec![broken])).is_err(), "{place}");
    }
}

#[test]
fn a_tampered_file_is_refused_with_the_place() {
    let whole = to_json(&model(all_laws())).unwrap();
    let tampered = [
        ("\"speed\": 0.05", "\"speed\": 0", "the Stribeck speed of the friction exp("),
        ("\"width\": 0.01", "\"width\": -0.01", "the width of the friction sign(dq2) [dq2 < 0]"),
        ("\"speed\": 0.05", "\"speed\": 1e999", "number out of range"),
        ("\"direction\": \"backward\"", "\"direction\": \"sideways\"", "unknown variant"),
        ("\"speed\": 0.05", "\"speed\": 0.05, \"mass\": 1", "unknown field"),
    ];

    for (from, to, message) in tampered {
        let broken = whole.replacen(from, to, 1);
        assert_ne!(broken, whole, "{from}");
        let error = from_json(&broken).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
}

#[test]
fn another_reversal_changes_friction_at_reversal_alone() {
    let smooth = after_a_step(model(all_laws()), all_laws());

    let sharp = smooth.with_reversal(1e-4);

    let at = |model: &Model, speed: f64| {
        Torque::new(model).friction(&[0.0; 2], &[speed, speed]).unwrap()
    };
    assert_eq!(at(&sharp, 0.4), at(&smooth, 0.4));
    // tanh(−0.5) of the directed law becomes tanh(−50), which is −1.
    let grown = at(&sharp, -0.005)[1] - at(&smooth, -0.005)[1];
    assert!((grown + 0.7 * (1.0 - 0.5_f64.tanh())).abs() < 1e-12, "{grown}");
    assert_eq!(at(&sharp.after_step(1).unwrap(), -0.005), at(&sharp, -0.005));
}

#[test]
fn friction_under_load_follows_the_gravity_of_its_joint() {
    let loaded = directed(EXACT, Direction::Both).under_load();
    assert_eq!(
        [loaded.name(), loaded.latex()].concat(),
        "sign(dq2)*|G2|\
        \\operatorname{sign}(\\dot q_{2})\\,|G_{2}|"
    );
    let knee = Weighted::new(Term::one(2).times(Trig::Sin, 1, 1, 1), -4.0);
    let mut rubbing = model(vec![weighted(loaded, 0.1)]);
    let Form::Torque(equations) = &mut rubbing.form else { unreachable!() };
    equations[1].push(knee);
    let torque = Torque::new(&rubbing);
    let (q, dq, ddq) = ([0.3, 0.5], [1.0, -0.2], [0.0, 3.0]);

    let friction = torque.friction(&q, &dq).unwrap();

    assert_eq!(friction[0], 0.0);
    assert!((friction[1] + 0.1 * 4.0 * 0.5_f64.sin()).abs() < 1e-15, "{friction:?}");
    let bare = Torque::new(&Model { friction: vec![], ..rubbing.clone() });
    let whole = torque.at(&q, &dq, &ddq).unwrap()[1] - bare.at(&q, &dq, &ddq).unwrap()[1];
    assert!((whole - friction[1]).abs() < 1e-14);
    assert!(driving_friction(&rubbing).is_none());
    rubbing.friction[0].coefficient = -0.1;
    assert!(driving_friction(&rubbing).is_some());

    let shared = FrictionTerm { shaft: vec![1.0, 1.0], ..rubbing.friction[0].term.clone() };
    rubbing.friction[0].term = shared;
    let refused = to_json(&rubbing).unwrap_err();
    assert!(refused.to_string().contains("of one joint"), "{refused}");
}
