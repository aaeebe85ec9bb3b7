//! Logs that leave something open, and a lively one that does not.

use super::*;
use torquewise_model::{Choice, Form};
use torquewise_motion::Signals;
use torquewise_stepwise::survey;

/// A sine per joint, (amplitude, rate, phase), and a smaller and faster one, without which
/// inertia and gravity look the same; torque by `tau`.
fn log(sines: [(f64, f64, f64); 2], tau: impl Fn([f64; 3]) -> f64) -> Motion {
    let t: Vec<f64> = (0..2_000).map(|row| 0.01 * f64::from(row)).collect();
    let of = |order: i32| {
        let t = t.clone();
        Mat::from_fn(t.len(), 2, move |row, joint| {
            let (amplitude, rate, phase) = sines[joint];
            let quarter = f64::from(order) * std::f64::consts::FRAC_PI_2;
            let wave = |size: f64, rate: f64| {
                size * amplitude * rate.powi(order) * (rate * t[row] + phase + quarter).sin()
            };
            wave(1.0, rate) + wave(0.3, 2.3 * rate)
        })
    };
    let (q, dq, ddq) = (of(0), of(1), of(2));
    let torque = |row: usize, j: usize| tau([q[(row, j)], dq[(row, j)], ddq[(row, j)]]);
    let tau = Some(Mat::from_fn(t.len(), 2, torque));
    let joints = vec!["hip".into(), "knee".into()];
    Motion::new(Signals { joints, t, q, dq, ddq, tau }).unwrap()
}

fn of(log: &Motion) -> Vec<Warning> {
    findings(&survey(log).unwrap())
}

#[test]
fn what_spoils_a_log_is_told_and_a_lively_one_leaves_nothing_open() {
    let lively = |tau: fn([f64; 3]) -> f64| of(&log([(1.0, 3.0, 0.0), (0.8, 4.3, 1.0)], tau));
    let sound = lively(|[q, dq, ddq]| 3.0 * q.sin() + 0.4 * dq.signum() + 0.2 * ddq);
    assert_eq!(sound, []);

    let off = lively(|[q, dq, ddq]| 0.01 * (1e4 * (q + 2.0 * dq + 3.0 * ddq)).sin());
    assert_eq!(off.len(), 2, "{off:?}");
    assert!(off.iter().all(|finding| matches!(finding, Warning::Unrelated { .. })));
    let led_by_hand = lively(|[q, ..]| 3.31 * q.sin());
    assert_eq!(led_by_hand.len(), 2);
    assert!(led_by_hand.iter().all(|finding| matches!(finding, Warning::Commanded { .. })));
    let both = Warning::Velocity { joints: vec!["hip".into(), "knee".into()] };
    assert_eq!(lively(|[_, dq, ddq]| dq + 0.003 * ddq), [both]);
    assert_eq!(lively(|[_, dq, _]| 1.2 * dq), []);
    // Nor where noise hides that nothing else is there, but where a model leaves less.
    let noisy = |[q, dq, ddq]: [f64; 3]| 3.31 * q.sin() + 0.04 * (1e4 * (q + dq + ddq)).sin();
    let led_by_hand = survey(&log([(1.0, 3.0, 0.0), (0.8, 4.3, 1.0)], noisy)).unwrap();
    for (residual, found) in [(0.028, 2), (0.01, 0), (0.5, 0)] {
        let training = Training { residual_rms: vec![residual; 2], ..Training::default() };
        let joints = led_by_hand.joints.clone();
        let model = Model { joints, form: Form::Energy(vec![]), training, ..Model::default() };
        assert_eq!(commanded_by(&led_by_hand, &model).unwrap().len(), found);
    }
    let step = log([(1.0, 3.0, 0.0), (0.8, 3.0, 0.0)], |[q, dq, ddq]| q + dq + ddq);
    assert!(matches!(&of(&step)[..], [Warning::Together { .. }]));
}

#[test]
fn a_joint_that_moves_one_way_only_is_named_and_not_one_that_creeps_while_it_rests() {
    let both = log([(1.0, 3.0, 0.0), (0.8, 4.3, 1.0)], |[q, dq, ddq]| q + dq + ddq);
    let said = |dq: &dyn Fn(usize, f64) -> f64| {
        let mut signals = both.clone().into_signals();
        for (row, own) in signals.dq.col_mut(1).iter_mut().enumerate() {
            *own = dq(row, *own);
        }
        let found = of(&Motion::new(signals).unwrap());
        found.iter().any(|own| matches!(own, Warning::OneWay { forward: false, .. }))
    };

    assert!(said(&|_, dq| -dq.abs()));
    assert!(!said(&|row, dq| if row < 300 { dq } else { -1e-3 }));
}

#[test]
fn a_lame_joint_is_named_with_what_it_lacks() {
    let lame = log([(1.0, 3.0, 0.0), (0.05, 1.0, 0.0)], |[q, dq, ddq]| q + dq + ddq);
    // So is one that starts sharply once.
    let mut jerked = lame.clone().into_signals();
    jerked.dq.col_mut(1).subrows_mut(0, 10).fill(2.0);
    jerked.ddq.col_mut(1).subrows_mut(0, 10).fill(20.0);
    for found in [of(&lame), of(&Motion::new(jerked).unwrap())] {
        assert!(matches!(&found[0], Warning::Range { joint, .. } if joint == "knee"), "{found:?}");
        assert!(matches!(&found[1], Warning::Speed { .. }), "{found:?}");
        assert!(matches!(&found[2], Warning::Acceleration { .. }), "{found:?}");
    }
}

/// Two joints, of which the torque of the second is predicted poorly on held-out rows.
fn model() -> Model {
    let training = Training {
        residual_rms: vec![0.1, 0.1],
        torque_std: vec![1.0, 1.0],
        held_out_rms: vec![0.1, 0.9],
        held_out_by_region_rms: vec![0.1, 0.2],
        ..Training::default()
    };
    let joints = vec!["joint1".into(), "joint2".into()];
    Model { joints, training, ..Model::default() }
}

#[test]
fn a_log_given_twice_is_told_from_two_alike() {
    let logs = |second: f64| {
        let t: Vec<f64> = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0].repeat(2);
        let of = |row: usize| (0.7 * t[row]).sin() + if row == 15 { second } else { 0.0 };
        let column = || Mat::from_fn(16, 1, |row, _| of(row));
        let (joints, [q, dq, ddq]) = (vec!["joint1".into()], [column(), column(), column()]);
        let tau = Some(column());
        Motion::new(Signals { joints, t: t.clone(), q, dq, ddq, tau }).unwrap()
    };

    assert!(has_log_twice(&logs(0.0)));
    assert!(!has_log_twice(&logs(1e-9)));
}

#[test]
fn doubts_about_a_joint_that_is_predicted_well_are_dropped() {
    let unrelated = |joint: &str| Warning::Unrelated { joint: joint.into(), residual: 0.9 };
    let mut warnings = vec![unrelated("joint1"), unrelated("joint2")];
    Warning::retain_founded(&mut warnings, &model());

    assert_eq!(warnings, [unrelated("joint2")]);
}

#[test]
fn a_joint_of_untold_kind_is_said_to_be() {
    let range = |joint: &str| Warning::Range { joint: joint.into(), range: 0.1 };
    let mut warnings = vec![range("joint1"), range("joint2")];
    let choice = Choice { what: "kind of joint2".into(), ..Choice::default() };
    let model = Model { choices: vec![choice], ..model() };

    Warning::retain_founded(&mut warnings, &model);

    assert_eq!(
        warnings,
        [range("joint1"), Warning::Kind { joint: "joint2".into(), slides: false }]
    );
}
