//! Friction that grows with the load of its joint.
#![expect(clippy::float_cmp, reason = "no load leaves exactly nothing")]

use crate::friction::{EXACT, directed, model, weighted};
use torquewise_model::checks::driving_friction;
use torquewise_model::friction::Direction;
use torquewise_model::{Form, FrictionTerm, Model, Term, Torque, Trig, Weighted, to_json};

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
