//! Simulated arms whose joints slide: the kinds, the direction of the slides and the equations are
//! found from the log alone, and on other motion there is nothing left.

use crate::chain::{NOISE, linear, rubbing, sines};
use crate::support::{chain, executed, fit, percent, states_of};
use torquewise_identify::{
    ChainOptions, FrictionKind, IdentifyError, LibraryOptions, Plan, Reconstruction, UNWATCHED,
    reconstruct,
};
use torquewise_model::{EnergyTerm, Form, JointKinds, Place, Weighted, from_json, to_json};
use torquewise_sim::Arm;

const ARMS: [(&str, &str); 3] =
    [("gantry-3", "ppp"), ("scara-4", "rrpr"), ("surgical-6", "rrprrr")];

fn kinds_of(found: &Reconstruction) -> String {
    found.model.kinds().letters(found.model.n_joints())
}

/// The largest error on other motion, as a part of the spread of the torque.
fn elsewhere(found: &Reconstruction, arm: &Arm) -> f64 {
    let percent = percent(&found.model, &sines(arm, 20.0, 77));
    percent.into_iter().fold(0.0, |most, percent| f64::max(most, 0.01 * percent))
}

#[test]
fn kinds_are_found_and_nothing_is_left_without_noise() {
    let mut found = Vec::new();
    for (name, kinds) in &ARMS[..2] {
        let arm = Arm::builtin(name).unwrap();

        let fit = fit(&sines(&arm, 20.0, 1), &chain(FrictionKind::None));

        assert_eq!(from_json(&to_json(&fit.model).unwrap()).unwrap(), fit.model);
        found.push((*name, *kinds, kinds_of(&fit), elsewhere(&fit, &arm)));
    }
    let is_well = |(_, kinds, own, error): &(_, &str, String, f64)| own == kinds && *error < 1e-6;
    assert!(found.iter().all(is_well), "{found:?}");
}

#[test]
fn kinds_are_found_among_friction_and_noise() {
    let mut found = Vec::new();
    for (name, kinds) in ARMS {
        let arm = Arm::builtin(name).unwrap();
        let motion = sines(&arm, 20.0, 2);
        let friction = linear(&motion, &vec![[0.1, 0.8, 0.5]; kinds.len()]);

        let log = rubbing(&motion, &friction, NOISE);
        let fit = fit(&log, &chain(FrictionKind::Linear));

        found.push((name, kinds, kinds_of(&fit)));
    }
    assert!(found.iter().all(|(_, kinds, own)| own == kinds), "{found:?}");
}

#[test]
fn an_axis_that_torque_leaves_open_makes_no_equation_uncertain() {
    let motion = sines(&Arm::builtin("scara-4").unwrap(), 20.0, 4);
    let log = rubbing(&motion, &linear(&motion, &[[0.0; 3]; 4]), NOISE);

    let found = fit(&log, &chain(FrictionKind::None));

    let Form::Energy(terms) = &found.model.form else { panic!("{:?}", found.model.form) };
    let is_constant = |own: &&Weighted<EnergyTerm>| {
        own.term.place == Place::Inertia(0, 0) && own.term.function.factors.is_empty()
    };
    let own = terms.iter().find(is_constant).unwrap();
    assert!(own.coefficient > 1.0 && own.std_error < 0.05 * own.coefficient, "{own:?}");
}

#[test]
fn kinds_may_be_given_and_must_be_one_of_each_joint() {
    let arm = Arm::builtin("scara-4").unwrap();
    let motion = sines(&arm, 20.0, 3);
    let plan = |kinds: &str| -> Plan {
        let kinds = JointKinds::read(kinds);
        ChainOptions { kinds, friction: FrictionKind::None, ..ChainOptions::default() }.into()
    };

    let found = fit(&motion, &plan("RRPR"));
    let refused = reconstruct(&motion, &plan("RRP"), UNWATCHED).unwrap_err();

    assert!(elsewhere(&found, &arm) < 1e-6);
    assert!(found.model.choices.iter().all(|choice| !choice.what.contains("kind")));
    assert!(matches!(refused, IdentifyError::Kinds { .. }), "{refused}");
}

#[test]
fn arms_that_turn_alone_are_not_said_to_slide() {
    for name in ["puma560-3", "generic-4", "generic-6"] {
        let arm = Arm::builtin(name).unwrap();
        let sines = sines(&arm, 20.0, 4);
        let mut states = states_of(&sines);
        // The same motion made small: no joint turns by more than half a radian.
        states.iter_mut().flatten().flatten().for_each(|x| *x *= 0.15);
        let motion = executed(&arm, sines.t().to_vec(), &states);
        let friction = linear(&motion, &vec![[0.1, 0.8, 0.5]; arm.n_joints()]);

        let log = rubbing(&motion, &friction, NOISE);
        let found = fit(&log, &chain(FrictionKind::Linear));

        assert!(found.model.kinds().all_turn(), "{name}: {:?}", found.model.choices);
    }
}

#[test]
fn libraries_of_slides_hold_their_powers() {
    let arm = Arm::builtin("scara-4").unwrap();
    let motion = sines(&arm, 20.0, 5);
    let given = |options: LibraryOptions| -> Plan {
        LibraryOptions { kinds: arm.kinds(), bags: 0, ..options }.into()
    };

    let energies = fit(&motion, &given(LibraryOptions::default()));
    let read = from_json(&to_json(&energies.model).unwrap()).unwrap();
    let all_turn = fit(&motion, &LibraryOptions { bags: 0, ..LibraryOptions::default() }.into());
    let mut short = LibraryOptions::product();
    short.kinds = JointKinds::read("RRP").unwrap();
    let refused = reconstruct(&motion, &short.into(), UNWATCHED).unwrap_err();

    assert_eq!((&read, kinds_of(&energies).as_str()), (&energies.model, "rrpr"));
    let errors = [&energies, &all_turn].map(|found| elsewhere(found, &arm));
    assert!(errors[0] < 1e-6 && errors[1] > 1e-3, "{errors:?}");
    assert!(matches!(refused, IdentifyError::Kinds { .. }), "{refused}");
}
