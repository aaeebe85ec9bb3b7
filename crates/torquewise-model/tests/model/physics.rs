//! M(q) by itself, where it is weakest, and friction that drives its shaft.

use crate::{as_torques, two_joints};
use std::f64::consts::PI;
use torquewise_model::checks::{driving_friction, weakest_state};
use torquewise_model::{
    EnergyTerm, Form, FrictionLaw, FrictionTerm, Model, Place, Term, Torque, Training, Trig,
    Weighted,
};

fn model(form: Form, friction: Vec<Weighted<FrictionTerm>>) -> Model {
    let training = Training { dq_peak: vec![2.0, 3.0], ..Training::default() };
    Model { training, ..two_joints(form, friction) }
}

/// M₁₁ = 2 + 3 cos q₂, M₁₂ = 0.5 cos q₂ sin q₁, M₂₂ = 1, and some gravity.
fn energies() -> Form {
    let one = Term::one(2);
    let cos2 = one.clone().times(Trig::Cos, 1, 1, 1);
    let both = cos2.clone().times(Trig::Sin, 0, 1, 1);
    let term = |place, function: &Term| EnergyTerm { place, function: function.clone() };
    Form::Energy(vec![
        Weighted::new(term(Place::Inertia(0, 0), &one), 2.0),
        Weighted::new(term(Place::Inertia(0, 0), &cos2), 3.0),
        Weighted::new(term(Place::Inertia(0, 1), &both), 0.5),
        Weighted::new(term(Place::Inertia(1, 1), &one), 1.0),
        Weighted::new(term(Place::Potential, &both), 7.0),
    ])
}

#[test]
fn the_mass_matrix_is_the_torque_per_unit_acceleration_in_either_form() {
    let of_energies = model(energies(), vec![]);
    let of_torques = model(as_torques(&of_energies, |c, _| c), vec![]);

    for model in [of_energies, of_torques] {
        let torque = Torque::new(&model);
        for q in [[0.3, -0.8], [2.0, 3.0], [-1.0, 0.1]] {
            let mass = torque.mass_matrix(&q).unwrap();
            let rest = torque.at(&q, &[0.0; 2], &[0.0; 2]).unwrap();
            for column in 0..2 {
                let mut unit = [0.0; 2];
                unit[column] = 1.0;
                let moved = torque.at(&q, &[0.0; 2], &unit).unwrap();
                for row in 0..2 {
                    // A few roundings of torques below ten.
                    let expected = moved[row] - rest[row];
                    assert!((mass[(row, column)] - expected).abs() < 1e-14, "{row}, {column}");
                }
            }
        }
    }
}

#[test]
fn terms_that_no_single_acceleration_leaves_at_rest_are_not_of_the_mass_matrix() {
    let one = Term::one(2);
    let terms = vec![
        Weighted::new(one.clone().times_ddq(0), 2.0),
        Weighted::new(one.clone().times_ddq(0).times_ddq(1), 5.0),
        Weighted::new(one.clone().times_ddq(0).times_dq(1), 5.0),
    ];
    let torque = Torque::new(&model(Form::Torque(vec![terms, vec![]]), vec![]));

    let mass = torque.mass_matrix(&[0.0, 0.0]).unwrap();

    assert_eq!(mass, faer::mat![[2.0, 0.0], [0.0, 0.0]]);
}

#[test]
fn the_weakest_state_is_where_the_mass_matrix_is_least() {
    let model = model(energies(), vec![]);
    let states: Vec<Vec<f64>> = (0..=8).map(|k| vec![0.0, f64::from(k) * PI / 8.0]).collect();

    let (smallest, q) = weakest_state(&model, &states).unwrap();

    // At q₂ = π, M₁₁ = −1 and M₁₂ = 0.
    assert!((smallest + 1.0).abs() < 1e-12, "{smallest}");
    assert_eq!(q, [0.0, PI]);
    assert_eq!(weakest_state(&model, &[]).unwrap(), (f64::INFINITY, vec![]));
    assert!(weakest_state(&model, &[vec![0.0]]).is_err());
}

#[test]
fn friction_that_drives_its_shaft_is_found_with_its_speed_and_power() {
    let shaft = FrictionTerm {
        shaft: vec![1.0, -1.0],
        ..FrictionTerm::of_joint(2, 0, FrictionLaw::Viscous)
    };
    let dry = FrictionTerm { law: FrictionLaw::Coulomb { width: 0.0 }, ..shaft.clone() };
    let friction = vec![Weighted::new(dry, 1.0), Weighted::new(shaft, -0.3)];

    let driving = driving_friction(&model(energies(), friction)).unwrap();

    // The shaft turns at up to 2 + 3 rad/s, where it takes 5 − 0.3·25 W.
    assert_eq!((driving.shaft, driving.speed.abs()), (vec![1.0, -1.0], 5.0));
    assert!((driving.power + 2.5).abs() < 1e-12, "{}", driving.power);
}
