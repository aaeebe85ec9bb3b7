//! A learned chain finds the arm and the friction that a log was simulated with.

use crate::support::{
    assert_predicts, chain, deviation, fit, motion, normals, percent, reference_arm, states_of,
    with_torque,
};
use std::sync::LazyLock;
use torquewise_identify::plan::KnownGeometry;
use torquewise_identify::{ChainOptions, FrictionKind, Reconstruction};
use torquewise_model::{FrictionLaw, FrictionTerm, Model, Torque, check, from_json, to_json};
use torquewise_motion::Motion;
use torquewise_rigid::Coupling;
use torquewise_sim::{Arm, MotionKind};

/// White noise in the torque, as a part of its spread.
pub(crate) const NOISE: f64 = 0.01;

pub(crate) type Friction = Vec<(FrictionTerm, f64)>;

/// Offset, viscous and dry friction of each joint of the reference arm.
pub(crate) const FRICTION: [[f64; 3]; 3] = [[1.0, 6.0, 8.0], [-2.0, 9.0, 7.0], [0.5, 2.0, 3.0]];

pub(crate) fn sines(arm: &Arm, seconds: f64, seed: u64) -> Motion {
    motion(arm, MotionKind::Sines, seconds, 50.0, seed)
}

/// The motion with friction and noise in its torque.
pub(crate) fn rubbing(motion: &Motion, friction: &Friction, noise: f64) -> Motion {
    let mut normal = normals(9);
    let tau = motion.tau().unwrap();
    let noise: Vec<f64> = (0..tau.ncols()).map(|joint| noise * deviation(tau, joint)).collect();
    with_torque(motion.clone(), |[_, dq, _], tau| {
        for (joint, (tau, noise)) in tau.iter_mut().zip(&noise).enumerate() {
            *tau += friction.iter().map(|(f, c)| c * f.torque(joint, dq)).sum::<f64>();
            *tau += noise * normal();
        }
    })
}

/// Half width of the smooth sign of a joint that moves so: that of the learner, since a sharper one
/// is something that linear friction does not have.
pub(crate) fn width(motion: &Motion, joint: usize) -> f64 {
    let peak = motion.dq().col(joint).iter().fold(0.0_f64, |peak, dq| peak.max(dq.abs()));
    // To two digits.
    format!("{:.1e}", 0.01 * peak).parse().unwrap()
}

/// Offset, viscous and dry friction of each joint.
pub(crate) fn linear(motion: &Motion, joints: &[[f64; 3]]) -> Friction {
    let laws = |(joint, [offset, viscous, dry]): (usize, &[f64; 3])| {
        let sign = FrictionLaw::Coulomb { width: width(motion, joint) };
        let laws = [(FrictionLaw::Offset, *offset), (FrictionLaw::Viscous, *viscous), (sign, *dry)];
        laws.map(|(law, c)| (FrictionTerm::of_joint(joints.len(), joint, law), c))
    };
    joints.iter().enumerate().flat_map(laws).collect()
}

/// The coefficient that was found for a law on a shaft, whatever its width.
pub(crate) fn coefficient(found: &Reconstruction, wanted: &FrictionTerm) -> f64 {
    let kind = std::mem::discriminant(&wanted.law);
    let like = |term: &FrictionTerm| {
        term.shaft == wanted.shaft && std::mem::discriminant(&term.law) == kind
    };
    found.model.friction.iter().find(|w| like(&w.term)).unwrap().coefficient
}

/// What was chosen, if there was a choice.
pub(crate) fn chosen<'a>(found: &'a Reconstruction, what: &str) -> Option<&'a str> {
    let mut choices = found.model.choices.iter();
    choices.find(|choice| choice.what == what).map(|choice| choice.chosen.as_str())
}

pub(crate) fn reference_log() -> Motion {
    sines(&reference_arm(), 40.0, 1)
}

pub(crate) fn reference_friction() -> Friction {
    linear(&reference_log(), &FRICTION)
}

/// The reference arm with linear friction, any friction allowed for.
static REFERENCE: LazyLock<Reconstruction> = LazyLock::new(|| {
    let log = rubbing(&reference_log(), &reference_friction(), NOISE);
    fit(&log, &chain(FrictionKind::Auto))
});

/// Positions and speeds of an arm in motion.
pub(crate) fn states(arm: &Arm) -> Vec<(Vec<f64>, Vec<f64>)> {
    let motion = sines(arm, 10.0, 3);
    states_of(&motion).into_iter().step_by(10).map(|[q, dq, _]| (q, dq)).collect()
}

#[test]
fn linear_friction_is_chosen_and_recovered_where_there_is_no_more() {
    let found = &*REFERENCE;

    for joint in ["joint1", "joint2", "joint3"] {
        assert_eq!(chosen(found, &format!("friction of {joint}")), Some("Coulomb"));
        assert_eq!(chosen(found, &format!("counterbalance of {joint}")), Some("none"));
    }
    assert_eq!(chosen(found, "shaft shared by joints 2 and 3"), Some("none"));
    assert_eq!(chosen(found, "coupling"), None);
    assert_eq!(found.model.friction.len(), 9);
    for (term, truth) in reference_friction() {
        let found = coefficient(found, &term);
        assert!((found - truth).abs() < 0.02 * truth.abs(), "{}: {found}", term.name());
    }
}

#[test]
fn mass_matrix_and_gravity_are_those_of_the_arm() {
    let arm = reference_arm();
    let torque = Torque::new(&REFERENCE.model);
    let [mut wrong, mut size] = [[0.0; 2]; 2];

    for (q, _) in states(&arm) {
        let (mass, gravity) = (torque.mass_matrix(&q).unwrap(), torque.gravity(&q).unwrap());
        let (true_mass, true_gravity) = (arm.mass_matrix(&q), arm.gravity_torque(&q));
        for i in 0..3 {
            wrong[0] += (gravity[i] - true_gravity[i]).powi(2);
            size[0] += true_gravity[i].powi(2);
            for j in 0..3 {
                wrong[1] += (mass[(i, j)] - true_mass[(i, j)]).powi(2);
                size[1] += true_mass[(i, j)].powi(2);
            }
        }
    }

    for (wrong, size) in wrong.into_iter().zip(size) {
        assert!((wrong / size).sqrt() < 0.02, "{wrong} of {size}");
    }
}

#[test]
fn other_motion_is_predicted() {
    let test = rubbing(&sines(&reference_arm(), 10.0, 2), &reference_friction(), 0.0);

    assert_predicts(&REFERENCE.model, &test, 2.0);
}

#[test]
fn every_choice_is_on_record_with_its_errors() {
    let choices = &REFERENCE.model.choices;

    let whats: Vec<&str> = choices.iter().map(|choice| choice.what.as_str()).collect();
    for what in ["axes at right angles", "friction of joint1", "counterbalance of joint2"] {
        assert!(whats.contains(&what), "{what} in {whats:?}");
    }
    for choice in choices {
        let chosen = choice.from.iter().find(|c| c.label == choice.chosen).unwrap();
        let least = choice.from.iter().fold(f64::INFINITY, |least, c| least.min(c.error));
        assert!(choice.from.len() > 1 && chosen.complexity > 0, "{choice:?}");
        assert!(chosen.error.is_finite() && chosen.error < 2.0 * least, "{choice:?}");
        let rules = ["one standard error", "least error", "simplest within"];
        assert!(rules.iter().any(|rule| choice.rule.starts_with(rule)), "{choice:?}");
    }
}

/// Roll, pitch, roll, as at the end of an arm.
pub(crate) const WRIST: &str = include_str!("wrist.toml");

#[test]
fn the_shaft_of_a_coupled_wrist_is_found() {
    let motion = sines(&Arm::from_dh_toml(WRIST).unwrap(), 40.0, 1);
    let mut friction = linear(&motion, &[[0.0, 1.0, 1.5]; 3]);
    let sign = FrictionLaw::Coulomb { width: width(&motion, 1).min(width(&motion, 2)) };
    for (law, c) in [(FrictionLaw::Viscous, 2.0), (sign, 2.5)] {
        let shaft = vec![0.0, 1.0, -1.0];
        friction.push((FrictionTerm { shaft, ..FrictionTerm::of_joint(3, 0, law) }, c));
    }

    let found = fit(&rubbing(&motion, &friction, NOISE), &chain(FrictionKind::Linear));

    assert_eq!(chosen(&found, "shaft shared by joints 2 and 3"), Some("difference"));
    for (term, truth) in friction.into_iter().filter(|(_, truth)| *truth > 0.0) {
        let found = coefficient(&found, &term);
        assert!((found - truth).abs() < 0.02 * truth, "{}: {found}, not {truth}", term.name());
    }
}

/// The same motion logged by coordinates of which the third alone does not turn the third joint:
/// the second does so as well, `ratio` times.
fn coupled(motion: &Motion, ratio: f64) -> Motion {
    let mut signals = motion.clone().into_signals();
    for row in 0..motion.n_rows() {
        for x in [&mut signals.q, &mut signals.dq, &mut signals.ddq] {
            x[(row, 2)] -= ratio * x[(row, 1)];
        }
        let tau = signals.tau.as_mut().unwrap();
        tau[(row, 1)] += ratio * tau[(row, 2)];
    }
    Motion::new(signals).unwrap()
}

#[test]
fn a_joint_behind_a_parallelogram_is_found() {
    for (ratio, label) in [(-1.0, "q3 - q2"), (1.0, "q3 + q2")] {
        let log = |seconds, seed| coupled(&sines(&reference_arm(), seconds, seed), ratio);
        let friction = linear(&log(40.0, 1), &FRICTION);

        let train = rubbing(&log(40.0, 1), &friction, NOISE);
        let found = fit(&train, &chain(FrictionKind::Linear));

        assert_eq!(chosen(&found, "coupling"), Some(label));
        // A URDF may say where the axes lie, and nothing of the parallelogram.
        let chain = found.model.chain.as_ref().unwrap();
        let geometry = chain.axes().unwrap().coupled(Coupling::default());
        let base = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let geometry = Some(KnownGeometry { geometry, robot: None, base });
        let options =
            ChainOptions { geometry, friction: FrictionKind::Linear, ..Default::default() };
        let at_geometry = fit(&train, &options.into());
        assert_eq!(chosen(&at_geometry, "coupling"), Some(label));

        assert!(check(&found.model, &states(&reference_arm())).unwrap().passed());
        let test = rubbing(&log(10.0, 2), &friction, 0.0);
        let terms_alone = Model { chain: None, ..found.model.clone() };
        let saved = from_json(&to_json(&found.model).unwrap()).unwrap();
        for model in [&saved, &terms_alone, &at_geometry.model] {
            let errors = percent(model, &test);
            assert!(errors.iter().all(|&percent| percent < 2.0), "{label}: {errors:?}");
        }
    }
}

#[test]
fn stribeck_friction_is_chosen_where_there_is_some() {
    let motion = reference_log();
    let mut friction = linear(&motion, &[[0.0, 2.0, 2.0]; 3]);
    for joint in 0..3 {
        let width = width(&motion, joint);
        // A speed of the dictionary: 5 % of the peak.
        let law = FrictionLaw::Stribeck { speed: 5.0 * width, width };
        friction.push((FrictionTerm::of_joint(3, joint, law), 2.0));
    }

    let found = fit(&rubbing(&motion, &friction, NOISE), &chain(FrictionKind::Auto));

    assert_eq!(chosen(&found, "friction of joint1"), Some("Stribeck"));
    let saved = chosen(&found, "friction as saved");
    assert_eq!(saved, Some("mean of the laws chosen and of all offered"));
    // The other speed of the dictionary takes a little of each law: the curve is what counts.
    let torque = Torque::new(&found.model);
    for speed in [-1.2, -0.5, -0.2, -0.1, 0.05, 0.1, 0.2, 0.5, 1.2] {
        let dq = [speed, 0.4 * speed, -speed];
        let found = torque.friction(&[0.0; 3], &dq).unwrap();
        for (joint, found) in found.into_iter().enumerate() {
            let truth: f64 = friction.iter().map(|(f, c)| c * f.torque(joint, &dq)).sum();
            // 2 % of the greatest friction, more where the dictionary bends most.
            let most = if speed.abs() < 0.1 { 0.3 } else { 0.1 };
            assert!((found - truth).abs() < most, "{speed} rad/s: {found}, not {truth}");
        }
    }
}
