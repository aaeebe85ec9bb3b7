//! From models to torque, text and back: a two-link arm, files whole and broken.

use crate::as_torques;
use crate::friction::weighted;
use crate::truth::true_energies;
use torquewise_model::print::{latex, text, with_error};
use torquewise_model::selection::Selection;
use torquewise_model::{
    Form, Kind, Model, ModelError, Place, Stage, Term, Torque, check, from_json, to_json,
};
use torquewise_sim::Arm;

/// `planar-2` as its energies, eight terms with constants read off the arm itself.
fn two_link() -> (Arm, Model) {
    let arm = Arm::builtin("planar-2").unwrap();
    let energies = true_energies(&arm).into_iter().map(|(term, weight)| weighted(term, weight));
    let terms: Vec<_> = energies.collect();
    let of_v = terms.iter().filter(|own| own.term.place == Place::Potential);
    let stage = Stage {
        name: "standstill".into(),
        rows: 10,
        candidates: 8,
        form: Form::Energy(of_v.cloned().collect()),
        friction: vec![],
    };
    let model = Model {
        joints: vec!["joint1".into(), "joint2".into()],
        form: Form::Energy(terms),
        stages: vec![stage],
        ..Model::default()
    };
    (arm, model)
}

#[test]
fn energies_give_the_torque_of_the_arm() {
    let (arm, model) = two_link();
    let torque = Torque::new(&model);

    for k in 0..20 {
        let x = f64::from(k);
        let (q, dq, ddq) = ([x.sin(), (2.0 * x).cos()], [x.cos(), -x.sin()], [0.3 * x, 1.0 - x]);
        let expected = arm.inverse_dynamics(&q, &dq, &ddq);
        let found = torque.at(&q, &dq, &ddq).unwrap();
        for joint in 0..2 {
            let scale = 1.0 + expected[joint].abs();
            assert!((found[joint] - expected[joint]).abs() < 1e-12 * scale, "state {k}");
        }
    }
}

#[test]
fn the_model_is_physics_and_a_tampered_one_is_not() {
    let (_, model) = two_link();
    let states: Vec<(Vec<f64>, Vec<f64>)> = (0..10)
        .map(|k| (vec![f64::from(k), 0.7 * f64::from(k)], vec![1.0, -0.5 * f64::from(k)]))
        .collect();

    let sound = check(&model, &states).unwrap();
    let changed = |c: f64, term: &Term| if term.kind() == Kind::Coriolis { 1.1 * c } else { c };
    let torques = as_torques(&model, changed);
    let tampered = check(&Model { form: torques, ..model }, &states).unwrap();

    assert!(sound.passed(), "{sound:?}");
    assert!(!tampered.passed() && tampered.skew_defect > 1e-3, "{tampered:?}");
}

#[test]
fn parts_that_do_not_fit_are_refused() {
    let (_, model) = two_link();
    let whole = to_json(&model).unwrap();
    let broken = [
        whole.replace("\"joint1\",", ""),
        whole.replace("torquewise-model", "another-model"),
        whole.replacen("\"std_error\": 0.01", "\"std_error\": 1e999", 1),
    ];

    for text in broken {
        assert!(from_json(&text).is_err());
    }
    let mut infinite = model;
    if let Form::Energy(terms) = &mut infinite.form {
        terms[0].coefficient = f64::INFINITY;
    }
    let refused = to_json(&infinite).unwrap_err().to_string();
    assert!(refused.contains("a coefficient is not finite in"), "{refused}");
}

#[test]
fn digits_follow_the_standard_error() {
    assert_eq!(with_error(8.396_03, 0.003_1), "8.3960 ± 0.0031");
    assert_eq!(with_error(1234.5678, 12.0), "1235 ± 12");
    assert_eq!(with_error(0.1 + 0.2, 0.0), "0.3000000000");
}

#[test]
fn equations_read_as_formulas() {
    let (_, model) = two_link();

    let (plain, tex) = (text(&model, &Selection::default()), latex(&model, &Selection::default()));

    assert!(plain.contains("M11 =") && plain.contains("V =") && plain.contains("tau2 ="));
    assert!(plain.contains("* cos(q2)*ddq1"), "{plain}");
    assert!(
        tex.starts_with(r"\begin{align*}") && tex.contains(r"\cos q_{2}\,\ddot q_{1}"),
        "{tex}"
    );
}

#[test]
fn a_log_of_other_joints_is_of_another_arm() {
    let (_, model) = two_link();
    let other = vec![model.joints[1].clone(), model.joints[0].clone()];

    let names = model.check_joints(&other).unwrap_err();
    let count = model.check_joints(&other[1..]).unwrap_err();

    assert!(model.check_joints(&model.joints).is_ok());
    assert!(matches!(names, ModelError::JointNames { log, .. } if log == other));
    assert!(matches!(count, ModelError::JointCount { model: 2, log: 1 }));
}
