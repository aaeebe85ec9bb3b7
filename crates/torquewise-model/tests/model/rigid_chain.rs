//! A rigid chain as parameters: its derivatives, its covariance, what can be a body.

use crate::two_joints;
use faer::Mat;
use torquewise_model::momentum_observer::MomentumObserver;
use torquewise_model::{
    Drive, EnergyTerm, Form, FrictionLaw, FrictionTerm, Model, Place, RigidChain, Term, Torque,
    Trig, Weighted, from_json, to_json,
};

/// A link of three kilograms about as large as a forearm.
const LINK: [f64; 10] = [3.0, 0.3, -0.15, 0.6, 0.3, 0.4, 0.2, 0.02, -0.05, 0.01];

fn spring() -> EnergyTerm {
    let function = Term::one(2).times(Trig::Cos, 1, 2, 1);
    EnergyTerm { place: Place::Potential, function }
}

/// Two links at odd angles, a rotor of a shared shaft and a spring.
fn chain() -> RigidChain {
    RigidChain {
        geometry: vec![0.1, -0.2, 1.4, 0.05, 0.3, -0.1],
        fitted: vec![0, 2, 4],
        links: vec![LINK; 2],
        drives: vec![
            Drive::Rotor { shaft: vec![1.0, -0.5], inertia: 0.3 },
            Drive::Energy { term: spring(), coefficient: 1.5 },
        ],
        ..RigidChain::default()
    }
}

fn friction() -> Vec<Weighted<FrictionTerm>> {
    vec![Weighted::new(FrictionTerm::of_joint(2, 1, FrictionLaw::Viscous), 0.7)]
}

const STATE: [[f64; 2]; 3] = [[0.4, -1.1], [0.9, 0.3], [-2.0, 1.5]];
/// What the law of friction comes to there: the speed of the second joint.
const LAWS: [f64; 1] = [STATE[1][1]];

fn state() -> [&'static [f64]; 3] {
    [&STATE[0], &STATE[1], &STATE[2]]
}

/// The torque of the equations that follow from a chain.
fn torque(chain: &RigidChain, friction: Vec<Weighted<FrictionTerm>>) -> Vec<f64> {
    let model = Model { chain: None, friction, ..model(chain.clone()) };
    let [q, dq, ddq] = state();
    Torque::new(&model).at(q, dq, ddq).unwrap()
}

#[test]
fn parameters_go_into_the_chain_they_came_from() {
    let chain = chain();
    let known = chain.parameters(&friction());

    assert_eq!(known.len(), chain.n_parameters(1));
    assert_eq!(chain.at(&known, 1), chain);
    let moved: Vec<f64> = known.iter().map(|x| x + 0.25).collect();
    assert_eq!(chain.at(&moved, 1).parameters(&friction())[..22], moved[..22]);
    assert_eq!(chain.at(&moved, 1).parameters(&[]), [&moved[..22], &moved[23..]].concat());
}

#[test]
fn sensitivities_are_differences_of_the_torque() {
    let chain = chain();
    let sensitivities = chain.sensitivities((&friction(), &LAWS), state()).unwrap();
    let known = chain.parameters(&friction());
    let step = 1e-5;

    for k in 0..known.len() {
        let at = |sign: f64| {
            let mut parameters = known.clone();
            parameters[k] += sign * step;
            let mut friction = friction();
            friction[0].coefficient = parameters[22];
            torque(&chain.at(&parameters, 1), friction)
        };
        let (above, below) = (at(1.0), at(-1.0));
        for joint in 0..2 {
            let expected = (above[joint] - below[joint]) / (2.0 * step);
            let found = sensitivities[(joint, k)];
            assert!((found - expected).abs() < 1e-8 * (1.0 + expected.abs()), "{k}: {found}");
        }
    }
}

#[test]
fn the_error_of_the_torque_is_that_of_its_parameters() {
    let mut chain = chain();
    let p = chain.n_parameters(1);
    let half = Mat::from_fn(p, p, |i, j| 0.01 * ((i * p + j) as f64).sin());
    let covariance = &half * half.transpose();
    assert_eq!(chain.std_errors((&friction(), &LAWS), state()).unwrap(), [0.0; 2]);
    chain.set_covariance(&covariance).unwrap();

    let found = chain.std_errors((&friction(), &LAWS), state()).unwrap();

    let jacobian = chain.sensitivities((&friction(), &LAWS), state()).unwrap();
    let expected = &jacobian * &covariance * jacobian.transpose();
    for joint in 0..2 {
        let expected = expected[(joint, joint)].sqrt();
        assert!((found[joint] - expected).abs() < 1e-6 * expected, "{found:?}");
    }
}

#[test]
fn a_file_keeps_the_chain_and_what_masses_that_torque_does_not_tell_add_up_to_its_error() {
    let mut chain = chain();
    let p = chain.n_parameters(1);
    // Two masses of 10⁴ kg each whose sum is known to 10⁻² kg.
    let (untold, sum) = (1e4_f64, 1e-2_f64);
    let mut root = Mat::zeros(p, 2);
    (root[(0, 0)], root[(10, 0)], root[(10, 1)]) = (untold, -untold, sum);
    chain.set_covariance(&(&root * root.transpose())).unwrap();
    let model = model(chain);
    let read = from_json(&to_json(&model).unwrap()).unwrap();
    let chain = read.chain.as_ref().unwrap();
    let mut weights = vec![0.0; p];
    (weights[0], weights[10]) = (1.0, 1.0);

    let found = chain.std_error_of(&weights);

    assert_eq!(read, model);
    assert!((found / sum - 1.0).abs() < 0.01, "{found}");
    let both = Mat::from_fn(1, 11, |_, k| weights[k]);
    assert!((chain.covariance_of(&both)[(0, 0)].sqrt() / sum - 1.0).abs() < 0.01);
}

#[test]
fn only_bodies_that_can_be_are_feasible() {
    let with = |change: fn(&mut RigidChain)| {
        let mut chain = chain();
        change(&mut chain);
        chain.is_feasible()
    };

    assert!(with(|_| {}));
    assert!(!with(|chain| chain.links[1][0] = -1.0));
    // A first moment that no spread of the mass has.
    assert!(!with(|chain| chain.links[0][3] = 5.0));
    // More about one axis than about the other two together.
    assert!(!with(|chain| chain.links[0][6] = 4.0));
    assert!(!with(|chain| {
        chain.drives[0] = Drive::Rotor { shaft: vec![1.0, 0.0], inertia: -0.1 };
    }));
    // A term of M that no body has may make M(q) indefinite.
    assert!(!with(|chain| {
        let term = EnergyTerm { place: Place::Inertia(0, 0), ..spring() };
        chain.drives[1] = Drive::Energy { term, coefficient: 0.1 };
    }));
}

fn model(chain: RigidChain) -> Model {
    let terms = chain.energy_terms().unwrap().into_iter();
    let form = Form::Energy(terms.map(|(term, c)| Weighted::new(term, c)).collect());
    Model { chain: Some(chain), ..two_joints(form, friction()) }
}

#[test]
fn the_momentum_observer_follows_external_torque_as_a_low_pass_of_first_order() {
    let model = model(chain());
    let torque = Torque::new(&model);
    let (gain, dt, begin) = (20.0, 1e-3, 1.0);
    let mut observer = MomentumObserver::new(&model, gain);

    for row in 0..2_000 {
        let t = f64::from(row) * dt;
        let q = [(1.3 * t).sin(), 0.8 * (2.1 * t).cos()];
        let dq = [1.3 * (1.3 * t).cos(), -1.68 * (2.1 * t).sin()];
        let ddq = [-1.69 * (1.3 * t).sin(), -3.528 * (2.1 * t).cos()];
        let since = (t - begin).max(0.0);
        let pushed = if since > 0.0 { [3.0, -2.0] } else { [0.0; 2] };
        // What the motors need not do, the push does.
        let needed = torque.at(&q, &dq, &ddq).unwrap();
        let motors = [needed[0] - pushed[0], needed[1] - pushed[1]];
        let external = observer.step(dt, [&q, &dq, &motors]).unwrap();
        for (found, pushed) in external.iter().zip(pushed) {
            let expected = pushed * (1.0 - (-gain * since).exp());
            assert!((found - expected).abs() < 0.05, "{found} at {t} s, expected {expected}");
        }
    }
}
