//! Controllers on plants: what knowledge of the arm buys, and what bad input is told.
use crate::truth::true_energies;
use faer::Mat;
use std::f64::consts::FRAC_PI_2;
use torquewise_model::{Form, FrictionLaw, FrictionTerm, Model, Weighted};
use torquewise_motion::Motion;
use torquewise_sim::control::{
    Gains, Knowledge, Law, Learned, Periodic, Plant, Sensors, Tracking, mean_inertia, periodic,
    track,
};
use torquewise_sim::{Arm, Friction, SimError, Stribeck};

/// The reference arm with friction, encoders and a drive that is late.
fn plant() -> Plant {
    let curve = |coulomb, stiction, viscous| Stribeck { coulomb, stiction, speed: 0.1, viscous };
    let curves = [curve(4.0, 6.0, 3.0), curve(5.0, 7.0, 4.0), curve(2.0, 3.0, 1.0)];
    let friction = Friction::new(&curves).unwrap();
    let mut plant = Plant { friction, ..Plant::ideal(Arm::builtin("puma560-3").unwrap()) };
    plant.drive.delay = 1e-3;
    plant.sensors = Sensors::default();
    plant
}

fn wanted(plant: &Plant) -> Motion {
    periodic(&plant.arm, &Periodic::default()).unwrap()
}

fn run(plant: &Plant, law: Law, wanted: &Motion) -> Tracking {
    let gains = Gains::critically_damped(15.0, &mean_inertia(plant, wanted).unwrap());
    track(plant, law, plant, &gains, wanted).unwrap()
}

#[test]
fn more_knowledge_tracks_better_with_the_same_gains() {
    let plant = plant();
    let wanted = wanted(&plant);

    let [pid, first, second, computed] =
        [Law::Pid, Law::Controller1, Law::Controller2, Law::ComputedTorque]
            .map(|law| run(&plant, law, &wanted).rms_error(8.0));

    for joint in 0..3 {
        assert!(first[joint] < 0.5 * pid[joint], "{first:?}, {pid:?}");
        assert!(second[joint] < 0.1 * pid[joint], "{second:?}, {pid:?}");
        assert!(computed[joint] < 0.1 * pid[joint], "{computed:?}, {pid:?}");
    }
}

#[test]
fn an_ideal_arm_with_all_that_is_known_is_where_it_should_be() {
    let plant = Plant::ideal(Arm::builtin("puma560-3").unwrap());
    let wanted = wanted(&plant);

    let found = run(&plant, Law::Controller2, &wanted).peak_error(0.0);

    // A torque held for 1 ms is late by half of that: 0.5 ms × jerk 30 rad/s³ / ω² at most.
    assert!(found.iter().all(|error| *error < 1e-4), "{found:?}");
}

#[test]
fn one_seed_gives_the_same_bits() {
    let mut plant = plant();
    plant.sensors.noise = 1e-5;
    let wanted = periodic(&plant.arm, &Periodic { seconds: 1.0, ..Periodic::default() }).unwrap();

    let [one, other] = [(); 2].map(|()| run(&plant, Law::Controller2, &wanted));
    plant.sensors.seed = 1;
    let third = run(&plant, Law::Controller2, &wanted);

    assert_eq!(one.q, other.q);
    assert_ne!(one.q, third.q);
}

/// Hanging down, then half a radian from there, where gravity takes 11 of 14 N·m.
fn step(plant: &Plant) -> Motion {
    let mut signals = wanted(plant).into_signals();
    for row in 0..signals.t.len() {
        signals.q[(row, 0)] = -FRAC_PI_2 + if row < 100 { 0.0 } else { 0.5 };
        signals.q[(row, 1)] = 0.0;
    }
    (signals.dq, signals.ddq) = (Mat::zeros(16_001, 2), Mat::zeros(16_001, 2));
    Motion::new(signals).unwrap()
}

#[test]
fn an_integral_that_does_not_wind_up_hardly_overshoots() {
    let mut plant = Plant::ideal(Arm::builtin("planar-2").unwrap());
    plant.drive.limit = vec![14.0, 8.0];
    let wanted = step(&plant);

    let kept = run(&plant, Law::Pid, &wanted);

    let error = kept.error.col_as_slice(0);
    let beyond = error.iter().fold(0.0_f64, |most, error| most.max(-error));
    assert!(kept.saturated[0] > 0.01, "{:?}", kept.saturated);
    // 0.023 rad; one whose integral goes on while the drive gives all it can went 0.033 rad too far.
    assert!(beyond < 0.03, "{beyond}");
    assert!(kept.tau.col_as_slice(0).iter().all(|tau| tau.abs() <= 14.0));
}

#[test]
fn an_arm_that_floats_is_led_with_little_force() {
    let plant = Plant::ideal(Arm::builtin("puma560-3").unwrap());
    let wanted = wanted(&plant);

    let led = run(&plant, Law::HandGuiding, &wanted).rms_hand(1.0);

    let rows = 0..wanted.n_rows();
    let weight = rows.map(|row| plant.arm.gravity_torque(&wanted.state(row)[0])[1].powi(2));
    let weight = (weight.sum::<f64>() / wanted.n_rows() as f64).sqrt();
    assert!(led[1] < 0.7 * weight, "{led:?}, {weight} to carry");
}

#[test]
fn gains_place_three_equal_poles() {
    let gains = Gains::critically_damped(7.0, &[2.5]);
    let [p, i, d] = [gains.proportional[0], gains.integral[0], gains.derivative[0]];

    for s in [-7.0_f64, -1.0, 3.0] {
        let closed = 2.5 * s.powi(3) + d * s * s + p * s + i;
        assert!((closed - 2.5 * (s + 7.0).powi(3)).abs() < 1e-9);
    }
}

/// One joint that rubs dry, and nothing else.
fn dry(n: usize) -> Model {
    let term = FrictionTerm::of_joint(n, 0, FrictionLaw::Coulomb { width: 0.0 });
    let joints = (1..=n).map(|joint| format!("joint{joint}")).collect();
    let (form, friction) = (Form::Torque(vec![vec![]; n]), vec![Weighted::new(term, 2.0)]);
    Model { joints, form, friction, ..Model::default() }
}

#[test]
fn a_learned_sign_is_smooth() {
    let known = Learned::new(&dry(2)).unwrap();
    let mut path = known.path();
    path.step(&[0.0; 2]);

    let [slow, fast] = [2e-5, 1.0].map(|speed| known.friction(&path, &[speed, 0.0]).unwrap()[0]);

    assert!(slow > 0.0 && slow < 0.05 && (fast - 2.0).abs() < 1e-12);
    assert_eq!(known.slow(&path, &[1.0, 0.0]).unwrap(), [2.0, 0.0]);
}

/// Largest error \[rad\] of each joint of an arm on bristles, once the motion is periodic, by the arm
/// itself and one law of friction for each joint, given what the bristles bear \[N·m\] and how stiff
/// they are \[N·m/rad\].
fn peak_error(law: impl Fn(f64, f64) -> FrictionLaw) -> Vec<f64> {
    let (arm, stiffness) = (Arm::builtin("puma560-3").unwrap(), 200.0);
    let dry = arm.joints().iter().zip([8.0, 10.0, 4.0]);
    let row = |(name, dry): (&String, f64)| {
        format!("[{name}]\ncoulomb = {dry:?}\nstiffness = {stiffness:?}\n")
    };
    let text: String = dry.clone().map(row).collect();
    let weighted = |(joint, (_, dry)): (usize, (&String, f64))| {
        Weighted::new(FrictionTerm::of_joint(3, joint, law(dry, stiffness)), dry)
    };
    let friction = dry.enumerate().map(weighted).collect();
    let terms = true_energies(&arm).into_iter().map(|(term, weight)| Weighted::new(term, weight));
    let (joints, form) = (arm.joints().to_vec(), Form::Energy(terms.collect()));
    let known = Learned::new(&Model { joints, form, friction, ..Model::default() }).unwrap();
    let friction = Friction::from_toml(&text, arm.joints()).unwrap();
    let plant = Plant { friction, ..Plant::ideal(arm) };
    let wanted = wanted(&plant);
    let gains = Gains::critically_damped(15.0, &mean_inertia(&plant, &wanted).unwrap());
    track(&plant, Law::Controller2, &known, &gains, &wanted).unwrap().peak_error(8.0)
}

#[test]
fn memory_of_the_path_takes_out_the_error_of_reversals() {
    // Bristles that slip at f_c bend over f_c / σ₀: one element of Dahl.
    let with = peak_error(|dry, stiffness| FrictionLaw::Dahl { travel: dry / stiffness });
    let without = peak_error(|_, _| FrictionLaw::Coulomb { width: 0.002 });

    for (joint, (with, without)) in with.iter().zip(&without).enumerate() {
        assert!(*with < 0.2 * without, "joint {joint}: {with} rad, without {without} rad");
    }
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let plant = Plant::ideal(Arm::builtin("planar-2").unwrap());
    let wanted = wanted(&plant);
    let gains = Gains::critically_damped(15.0, &[1.0, 1.0]);
    let other = Learned::new(&dry(3)).unwrap();
    let gap = wanted.select(&[0, 1, 2, 5]);

    let none = Gains::critically_damped(15.0, &[1.0, -1.0]);
    let refused = |known: &dyn Knowledge, gains: &Gains, wanted: &Motion| {
        track(&plant, Law::Pid, known, gains, wanted).unwrap_err()
    };

    assert!(matches!(refused(&other, &gains, &wanted), SimError::JointCount { .. }));
    assert!(matches!(refused(&plant, &gains, &gap), SimError::Uneven { .. }));
    let short = refused(&plant, &gains, &wanted.select(&[3]));
    assert!(matches!(short, SimError::Setting { found: 1.0, .. }));
    assert!(matches!(refused(&plant, &none, &wanted), SimError::Setting { .. }));
}
