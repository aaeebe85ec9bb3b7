//! Models drawn from a learned chain: physical, as far apart as the covariance says, and told by
//! the seed.

use crate::support::{chain, fit, noisy, reference_arm, row_of, states_of};
use torquewise_identify::{FrictionKind, samples};
use torquewise_model::checks::driving_friction;
use torquewise_model::{Model, Torque};
use torquewise_motion::Motion;
use torquewise_sim::MotionKind;

const COUNT: usize = 240;

fn motion(kind: MotionKind, seconds: f64, seed: u64) -> Motion {
    crate::support::motion(&reference_arm(), kind, seconds, 50.0, seed)
}

fn learned() -> Model {
    let log = noisy(&motion(MotionKind::Moves, 60.0, 1), 2, 1);
    fit(&log, &chain(FrictionKind::Stribeck)).model
}

#[test]
fn drawn_models_are_physical_and_scatter_as_the_covariance_says() {
    let model = learned();
    let drawn = samples(&model, COUNT, 0).unwrap();

    assert!(drawn.iter().all(|own| own.chain.as_ref().unwrap().is_feasible()));
    // Between the speeds that are looked at friction that is none may drive by less than a milliwatt.
    let driven = |own: &Model| driving_friction(own).map_or(0.0, |found| -found.power);
    assert!(drawn.iter().map(driven).fold(driven(&model), f64::max) < 1e-3);
    assert_eq!(drawn, samples(&model, COUNT, 0).unwrap());
    assert_ne!(drawn, samples(&model, COUNT, 1).unwrap());
    let others = motion(MotionKind::Sines, 4.0, 9);
    let chain = model.chain.as_ref().unwrap();
    let laws = Torque::new(&model).laws(&others).unwrap();
    let all: Vec<_> = drawn.iter().map(|own| Torque::new(own).over(&others).unwrap()).collect();
    let (mut drawn_square, mut said_square) = (0.0, 0.0);
    for (row, state) in states_of(&others).iter().enumerate() {
        let known = row_of(laws.as_ref(), row);
        let friction = (&model.friction[..], &known[..]);
        let state = state.each_ref().map(|signal| &signal[..]);
        let said = chain.std_errors(friction, state).unwrap();
        for (joint, said) in said.iter().enumerate() {
            let mean = all.iter().map(|tau| tau[(row, joint)]).sum::<f64>() / COUNT as f64;
            let squares = all.iter().map(|tau| (tau[(row, joint)] - mean).powi(2));
            drawn_square += squares.sum::<f64>() / (COUNT - 1) as f64 / (said * said);
            said_square += 1.0;
        }
    }
    // Arms that cannot be, whose friction would drive, are not drawn: less scatter, not more.
    let ratio = (drawn_square / said_square).sqrt();
    assert!((0.75..1.15).contains(&ratio), "{ratio}");
}

#[test]
fn the_equations_of_a_drawn_model_are_those_of_its_chain_and_without_one_there_is_none() {
    let model = learned();
    let test = motion(MotionKind::Sines, 4.0, 9);
    let apart = |model: &Model| {
        let equations = Model { chain: None, ..model.clone() };
        let [whole, listed] = [model, &equations].map(|own| Torque::new(own).over(&test).unwrap());
        (whole - listed).norm_l2()
    };

    for drawn in samples(&model, 5, 3).unwrap() {
        // What its equations leave out is as small as of the model itself.
        assert!(apart(&drawn) < 3.0 * apart(&model), "{} {}", apart(&drawn), apart(&model));
    }
    let library = Model { chain: None, ..model };
    assert!(samples(&library, 1, 0).unwrap_err().to_string().contains("covariance"));
}
