//! From planted laws of friction to the parameters they were planted with, and their errors.

use crate::two_joints;
use faer::Mat;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use torquewise_model::model::TrainingFilter;
use torquewise_model::print::{friction_tables, text};
use torquewise_model::selection::Selection;
use torquewise_model::shaft_friction::{Estimated, FrictionParameters, ShaftFriction};
use torquewise_model::{
    Direction, Form, FrictionLaw, FrictionTerm, Kind, Model, RigidChain, Weighted,
};

const DRY: FrictionLaw = FrictionLaw::Coulomb { width: 0.008 };

fn stribeck(speed: f64) -> FrictionLaw {
    FrictionLaw::Stribeck { speed, width: 0.008 }
}

/// A law of the second of two joints.
fn law(law: FrictionLaw, direction: Direction, coefficient: f64) -> Weighted<FrictionTerm> {
    let term = FrictionTerm { direction, ..FrictionTerm::of_joint(2, 1, law) };
    Weighted { term, coefficient, std_error: 0.01, inclusion: None }
}

fn both(own: FrictionLaw, coefficient: f64) -> Weighted<FrictionTerm> {
    law(own, Direction::Both, coefficient)
}

fn under_load(weighted: &Weighted<FrictionTerm>) -> Weighted<FrictionTerm> {
    Weighted { term: weighted.term.clone().under_load(), ..weighted.clone() }
}

fn model(friction: Vec<Weighted<FrictionTerm>>) -> Model {
    two_joints(Form::Torque(vec![vec![], vec![]]), friction)
}

fn only(model: &Model) -> FrictionParameters {
    let shafts = ShaftFriction::all(model);
    assert_eq!(shafts.len(), 1);
    shafts[0].parameters()
}

#[track_caller]
fn assert_near(found: Option<Estimated>, value: f64, std_error: f64) {
    let found = found.unwrap();
    assert!((found.value - value).abs() < 1e-9 * value.abs(), "{found:?}, not {value}");
    assert!((found.std_error - std_error).abs() < 1e-9 * std_error, "{found:?}, ± {std_error}");
}

#[test]
fn a_planted_law_has_its_planted_parameters() {
    let planted = model(vec![
        both(FrictionLaw::Offset, -0.3),
        both(FrictionLaw::Viscous, 2.0),
        both(DRY, 3.0),
        both(stribeck(0.05), 1.2),
        law(FrictionLaw::Viscous, Direction::Backward, 0.1),
        law(DRY, Direction::Backward, 0.5),
        under_load(&both(DRY, 0.1)),
        under_load(&law(DRY, Direction::Backward, 0.04)),
    ]);

    let found = only(&planted);

    let root = |laws: f64| 0.01 * laws.sqrt();
    assert_near(found.offset, -0.3, 0.01);
    assert_near(found.forward.coulomb, 3.0, 0.01);
    assert_near(found.forward.stiction, 4.2, root(2.0));
    assert_near(found.forward.viscous, 2.0, 0.01);
    assert_near(found.backward.coulomb, 3.5, root(2.0));
    assert_near(found.backward.stiction, 4.7, root(3.0));
    assert_near(found.backward.viscous, 2.1, root(2.0));
    // Half the law of one direction.
    assert_near(found.load_factor, 0.12, 0.01 * 1.25_f64.sqrt());
    // A speed from the dictionary is exact.
    let speed = found.forward.stribeck_speed.unwrap();
    assert!((speed.value - 0.05).abs() < 1e-12 && speed.std_error < 1e-12, "{speed:?}");
    assert_eq!((found.stiffness, found.travel), (None, None));
}

#[test]
fn elements_are_dry_friction_with_a_stiffness_and_a_travel() {
    let one = only(&model(vec![both(DRY, 3.0), both(FrictionLaw::Dahl { travel: 0.01 }, 2.0)]));

    assert_near(one.forward.coulomb, 5.0, 0.01 * 2.0_f64.sqrt());
    assert_near(one.stiffness, 200.0, 1.0);
    let travel = one.travel.unwrap();
    assert!((travel.value - 0.01 * 10.0_f64.ln()).abs() < 1e-12 && travel.std_error < 1e-12);
}

#[test]
fn friction_that_rises_from_rest_has_less_of_it_there() {
    let rising = only(&model(vec![both(DRY, 3.0), both(stribeck(0.05), -1.0)])).forward;

    assert_near(rising.coulomb, 3.0, 0.01);
    assert_near(rising.stiction, 2.0, 0.01 * 2.0_f64.sqrt());
    let speed = rising.stribeck_speed.unwrap();
    assert!((speed.value - 0.05).abs() < 1e-12, "{speed:?}");
}

#[test]
fn what_is_not_resolved_has_no_number() {
    let weak = only(&model(vec![
        both(DRY, 0.019),
        both(stribeck(0.05), 0.019),
        both(FrictionLaw::Viscous, -1.0),
        both(FrictionLaw::Dahl { travel: 0.01 }, 0.001),
    ]));

    assert_eq!([weak.offset, weak.stiffness, weak.travel, weak.load_factor], [None; 4]);
    let sliding = weak.forward;
    // The law and the element together are 1.4 errors from zero.
    assert_eq!([sliding.coulomb, sliding.stiction, sliding.stribeck_speed], [None; 3]);
    assert_eq!(sliding.viscous, None);
    // A curve that bends where rows no longer count, below five half widths of the reversal.
    let bent =
        |width| model(vec![both(FrictionLaw::Coulomb { width }, 3.0), both(stribeck(0.05), 1.2)]);
    let [fast, slow] = [0.008, 0.02].map(|width| only(&bent(width)).forward);
    assert!(fast.stiction.is_some() && fast.stribeck_speed.is_some());
    assert_eq!([slow.stiction, slow.stribeck_speed], [None; 2]);
    assert_near(slow.coulomb, 3.0, 0.01);
    // Nor where a filter makes one of what reverses faster.
    let mut filtered = bent(0.008);
    filtered.training.ddq_peak = vec![1.0; 2];
    let seen = [4.0, 8.0].map(|cutoff_hz| {
        filtered.training.filter = Some(TrainingFilter { cutoff_hz, delay: 0.0 });
        only(&filtered).forward.stribeck_speed.is_some()
    });
    assert_eq!(seen, [false, true]);
}

/// A chain whose covariance is that of its friction alone, L Lᵀ.
fn with_covariance(mut model: Model, root: &Mat<f64>) -> Model {
    let mut chain = RigidChain {
        geometry: vec![0.1, -0.2, 1.4, 0.05, 0.3, -0.1],
        fitted: vec![0, 2],
        links: vec![[0.0; 10]; 2],
        ..RigidChain::default()
    };
    let (k, p) = (model.friction.len(), chain.n_parameters(model.friction.len()));
    let own = root * root.transpose();
    let at = |i: usize| i.checked_sub(20).filter(|i| *i < k);
    chain
        .set_covariance(&Mat::from_fn(p, p, |i, j| match (at(i), at(j)) {
            (Some(i), Some(j)) => own[(i, j)],
            _ => 0.0,
        }))
        .unwrap();
    model.chain = Some(chain);
    model
}

#[test]
fn errors_by_the_delta_method_are_those_of_a_monte_carlo() {
    let laws = vec![
        both(DRY, 3.0),
        both(FrictionLaw::Viscous, 2.0),
        both(stribeck(0.03), 1.1),
        both(stribeck(0.09), 0.7),
        both(FrictionLaw::Dahl { travel: 0.002 }, 0.8),
        both(FrictionLaw::Dahl { travel: 0.01 }, 1.4),
    ];
    let root = Mat::from_fn(6, 6, |i, j| match (i, j) {
        _ if i == j => 0.02,
        _ if j < i => 0.004 * (1.0 + i as f64 - 2.0 * j as f64),
        _ => 0.0,
    });
    let planted = with_covariance(model(laws), &root);
    let numbers = |model: &Model| {
        let FrictionParameters { forward, stiffness, travel, .. } = only(model);
        let [coulomb, stiction, speed] =
            [forward.coulomb, forward.stiction, forward.stribeck_speed];
        [coulomb, stiction, speed, forward.viscous, stiffness, travel].map(Option::unwrap)
    };
    let claimed = numbers(&planted).map(|own| own.std_error);

    let (draws, mut random) = (2_000, ChaCha8Rng::seed_from_u64(7));
    let mut sums = [[0.0; 2]; 6];
    for _ in 0..draws {
        let step = &root * Mat::<f64>::from_fn(6, 1, |_, _| StandardNormal.sample(&mut random));
        let mut drawn = planted.clone();
        let laws = drawn.friction.iter_mut().enumerate();
        laws.for_each(|(k, law)| law.coefficient += step[(k, 0)]);
        for (sum, own) in sums.iter_mut().zip(numbers(&drawn)) {
            *sum = [sum[0] + own.value, sum[1] + own.value.powi(2)];
        }
    }

    for ([sum, squares], claimed) in sums.into_iter().zip(claimed) {
        let mean = sum / f64::from(draws);
        let spread = (squares / f64::from(draws) - mean * mean).sqrt();
        // A spread of 2000 draws errs by 1.6 %; curvature adds a little.
        assert!((spread / claimed - 1.0).abs() < 0.06, "{spread} drawn, {claimed} claimed");
    }
}

#[test]
fn a_loop_closes_and_a_long_way_ends_at_the_curve() {
    let friction = model(vec![
        both(FrictionLaw::Offset, 0.2),
        both(DRY, 1.0),
        both(FrictionLaw::Dahl { travel: 0.01 }, 2.0),
    ]);
    let shaft = ShaftFriction::all(&friction)[0];
    let at = |q: f64, way: f64| shaft.on_loop(q, 0.03, way).value;

    // The dry law jumps at the ends, the element does not.
    for end in [0.03, -0.03] {
        assert!((at(end, 1.0) - at(end, -1.0) - 2.0).abs() < 1e-12, "{end}");
    }
    let slow = |way: f64| shaft.on_loop(way, 1.0, way).value - shaft.at_speed(way).value;
    assert!(slow(1.0).abs() < 0.01 && slow(-1.0).abs() < 0.01);
}

#[test]
fn a_table_names_every_shaft_and_leaves_out_what_none_has() {
    let mut friction = vec![both(FrictionLaw::Viscous, 2.0), both(stribeck(0.05), 1.2)];
    friction.push(law(DRY, Direction::Backward, 0.5));
    let mut shared = both(DRY, 0.7);
    shared.term.shaft = vec![1.0, -0.5];
    friction.push(shared);
    let rubbing = model(friction);

    let tables = friction_tables(&rubbing);

    let expected = [
        vec!["joint", "direction", "F_c [N·m]", "F_s [N·m]", "v_s [rad/s]", "F_v [N·m·s/rad]"],
        vec!["knee", "forward", "–", "1.200 ± 0.010", "0.05000000000", "2.000 ± 0.010"],
        vec![
            "knee",
            "backward",
            "0.500 ± 0.010",
            "1.700 ± 0.014",
            "0.05000000000",
            "2.000 ± 0.010",
        ],
        vec!["q1 - 0.5*q2", "both", "0.700 ± 0.010", "–", "–", "–"],
    ];
    assert_eq!(tables, [expected.map(|row| row.into_iter().map(String::from).collect::<Vec<_>>())]);
    assert_eq!(friction_tables(&model(vec![])), Vec::<Vec<Vec<String>>>::new());
    let equations = text(&rubbing, &Selection::default());
    assert!(equations.contains("  + F2(dq2)\n  - 0.3500 ± 0.0050 * tanh"), "{equations}");
    let gravity = Selection { part: Some(Kind::Gravity), ..Selection::default() };
    assert!(!text(&rubbing, &gravity).contains("F2("));
    let (_, laws) = equations.split_once("\n\nF2(dq2) = [knee]\n").unwrap();
    assert_eq!(laws.lines().take_while(|line| line.starts_with("  + ")).count(), 3, "{laws}");
    assert!(laws.contains("  + 0.500 ± 0.010 * tanh(") && laws.contains(" [dq2 < 0]\n"), "{laws}");
}

#[test]
fn a_symbol_says_what_friction_depends_on() {
    let symbol = |laws| ShaftFriction::all(&model(laws))[0].symbol();
    let element = both(FrictionLaw::Dahl { travel: 0.01 }, 2.0);

    assert_eq!(symbol(vec![both(DRY, 1.0), both(FrictionLaw::Viscous, 1.0)]), None);
    assert_eq!(symbol(vec![element.clone()]).unwrap(), "F2(q2, dq2)");
    assert_eq!(symbol(vec![under_load(&element)]).unwrap(), "F2(q, dq2)");
}
