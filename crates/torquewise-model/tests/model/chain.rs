//! The torque of a model that holds a rigid chain, at one state and over a motion.

use faer::Mat;
use torquewise_model::rigid_chain::{Coupled, Coupling};
use torquewise_model::{
    Drive, EnergyTerm, Form, JointKinds, Model, ModelError, Place, RigidChain, Term, Torque, Trig,
    Weighted, check, from_json, to_json,
};
use torquewise_motion::{Motion, Signals};

/// Three links, a rotor on two shafts and a spring; no equations to read.
fn model() -> Model {
    let geometry = vec![0.0, 0.0, 1.4, 0.2, 0.1, 0.0, 0.3, 0.0, 0.5, -0.1];
    let link = |mass: f64| [mass, 0.2, -0.1, 0.3, 0.6, 0.5, 0.7, 0.02, -0.03, 0.01];
    let function = Term::one(3).times(Trig::Cos, 1, 1, 1);
    let spring = EnergyTerm { place: Place::Potential, function };
    let drives = vec![
        Drive::Rotor { shaft: vec![0.0, 1.0, -0.5], inertia: 0.3 },
        Drive::Energy { term: spring, coefficient: -4.0 },
    ];
    let links = [3.0, 2.0, 1.0].map(link).to_vec();
    let chain = RigidChain { geometry, links, drives, ..RigidChain::default() };
    Model {
        joints: ["a", "b", "c"].map(String::from).to_vec(),
        form: Form::Energy(vec![]),
        chain: Some(chain),
        ..Model::default()
    }
}

/// The same whose second joint turns with the first coordinate as well, and the third with minus
/// the second.
fn coupled() -> Model {
    let mut model = model();
    let chain = model.chain.as_mut().unwrap();
    chain.coupling = Coupling::default()
        .with(Coupled { joint: 1, driver: 0, ratio: 1 })
        .with(Coupled { joint: 2, driver: 1, ratio: -1 });
    model
}

/// The same whose second joint slides, its spring along it.
fn slid() -> Model {
    let mut model = model();
    let chain = model.chain.as_mut().unwrap();
    chain.kinds = JointKinds::read("RPR").unwrap();
    let function = Term::one(3).times(Trig::Position, 1, 1, 2);
    let term = EnergyTerm { place: Place::Potential, function };
    chain.drives[1] = Drive::Energy { term, coefficient: 40.0 };
    model
}

/// A chain with axes at all angles, whose links have masses that no body has.
fn odd(n: usize) -> Model {
    let number = |k: usize| 1.5 * (2.7 * k as f64).sin();
    let links = (0..n).map(|link| std::array::from_fn(|k| number(10 * link + k))).collect();
    let geometry = (0..2 + 4 * (n - 1)).map(|k| number(k + 99)).collect();
    let chain = RigidChain { geometry, links, ..RigidChain::default() };
    let joints = (1..=n).map(|joint| format!("joint{joint}")).collect();
    Model { joints, chain: Some(chain), ..Model::default() }
}

/// A number of rows that four do not divide.
fn motion(model: &Model) -> Motion {
    let signal = |shift: f64, size: f64| {
        Mat::from_fn(7, model.n_joints(), |row, joint| {
            size * (row as f64 + 2.1 * joint as f64 + shift).sin()
        })
    };
    let t = (0..7).map(f64::from).collect();
    let joints = model.joints.clone();
    let (q, dq, ddq) = (signal(0.1, 3.0), signal(0.7, 2.0), signal(1.9, 5.0));
    Motion::new(Signals { joints, t, q, dq, ddq, tau: None }).unwrap()
}

#[test]
fn a_chain_moves_as_its_energies_say() {
    for model in [model(), coupled(), slid()].into_iter().chain([1, 2, 4, 5].map(odd)) {
        let motion = motion(&model);
        let terms = model.chain.as_ref().unwrap().energy_terms().unwrap();
        let weighted = terms.into_iter().map(|(term, weight)| Weighted::new(term, weight));
        let form = Form::Energy(weighted.collect());
        let expanded = Model { form, chain: None, ..model.clone() };
        let (chain, terms) = (Torque::new(&model), Torque::new(&expanded));

        let (own, expected) = (chain.parts(&motion).unwrap(), terms.parts(&motion).unwrap());

        // Terms are left out below 1e-12 of the largest.
        let least = 1e-12 * own.total().norm_max().max(10.0);
        assert!((&own.inertia - &expected.inertia).norm_max() < least);
        assert!((&own.coriolis - &expected.coriolis).norm_max() < least);
        assert!((&own.gravity - &expected.gravity).norm_max() < least);
        assert!((&own.total() - &chain.over(&motion).unwrap()).norm_max() < least);
        let q = &[0.3, -1.2, 2.1, 0.7, -0.4][..model.n_joints()];
        let (own, expected) = (chain.mass_matrix(q).unwrap(), terms.mass_matrix(q).unwrap());
        assert!((&own - &expected).norm_max() < least);
    }
}

#[test]
fn a_chain_that_is_coupled_or_slides_is_physics_and_its_file_keeps_it() {
    let states = [(vec![0.3, -1.2, 2.1], vec![1.0, -0.4, 0.7])];
    for (model, key, from, to, told) in [
        (coupled(), "coupling", "\"driver\": 0", "\"driver\": 1", "coupling"),
        (slid(), "kinds", "\"prismatic\",", "\"prismatic\", \"revolute\",", "kinds"),
        (slid(), "kinds", "\"prismatic\"", "\"screw\"", "screw"),
    ] {
        assert!(check(&model, &states).unwrap().passed());

        let file = to_json(&model).unwrap();

        assert_eq!(from_json(&file).unwrap(), model);
        assert!(!to_json(&self::model()).unwrap().contains(key));
        let odd = file.replace(from, to);
        assert_ne!(odd, file);
        let error = from_json(&odd).unwrap_err().to_string();
        assert!(error.contains(told), "{error}");
    }
}

#[test]
fn a_coupled_joint_must_turn_and_energies_of_nine_joints_are_not_listed() {
    let mut model = coupled();
    model.chain.as_mut().unwrap().kinds = JointKinds::read("RPR").unwrap();

    let error = to_json(&model).unwrap_err().to_string();

    assert!(error.contains("slides is coupled"), "{error}");
    let error = odd(9).chain.unwrap().energy_terms().unwrap_err();

    assert!(matches!(error, ModelError::TooManyJoints { joints: 9, most: 8 }));
}

#[test]
fn coefficients_of_terms_are_those_of_the_list() {
    let chain = slid().chain.unwrap();
    let terms = chain.energy_terms().unwrap();
    let wanted: Vec<EnergyTerm> = terms.iter().map(|(term, _)| term.clone()).collect();
    assert!(wanted.iter().any(|term| term.name() == "M11: q2^2"), "{wanted:?}");

    let found = chain.coefficients_of(&wanted).unwrap();

    for (term, found) in wanted.iter().zip(found) {
        let all = terms.iter().filter(|(own, _)| own == term).map(|(_, coefficient)| coefficient);
        assert!((all.sum::<f64>() - found).abs() < 1e-12, "{}", term.name());
    }
}

#[test]
fn a_row_has_the_same_bits_whatever_is_beside_it() {
    let (torque, motion) = (Torque::new(&model()), motion(&model()));
    let whole = torque.over(&motion).unwrap();

    let some = torque.over(&motion.select(&[5, 2])).unwrap();

    for (place, row) in [5, 2].into_iter().enumerate() {
        (0..3).for_each(|joint| {
            assert_eq!(some[(place, joint)].to_bits(), whole[(row, joint)].to_bits());
        });
    }
}
