//! Plants under a steady torque against closed forms and identities: energy, sticking, creeping;
//! against inverse dynamics; and with bristles.

use crate::control::integrate::Integrator;
use crate::control::{Periodic, Plant, periodic, record};
use crate::{Arm, Friction, SimError, State, Stribeck};
use torquewise_motion::Signal;

const RUBS: Stribeck = Stribeck { coulomb: 4.0, stiction: 6.0, speed: 0.1, viscous: 3.0 };

fn rubbing(arm: Arm) -> Plant {
    let friction = Friction::new(&vec![RUBS; arm.n_joints()]).unwrap();
    Plant { friction, ..Plant::ideal(arm) }
}

fn energy(plant: &Plant, q: &[f64], dq: &[f64]) -> f64 {
    plant.arm.kinetic_energy(q, dq) + plant.arm.potential_energy(q)
}

/// Lets a steady torque act for some seconds: q and dq become what they are then.
fn advance(plant: &Plant, [q, dq]: [&mut [f64]; 2], tau: &[f64], seconds: f64) {
    let mut state = plant.state(q, dq);
    let mut integrator = Integrator::new(state.len(), plant.tolerance);
    plant.follow(&mut integrator, &mut state, [0.0, seconds], tau).unwrap();
    q.copy_from_slice(&state[..q.len()]);
    dq.copy_from_slice(&state[q.len()..][..dq.len()]);
}

#[test]
fn a_plant_without_friction_keeps_its_energy() {
    for name in ["planar-2", "puma560-3"] {
        let plant = Plant::ideal(Arm::builtin(name).unwrap());
        let n = plant.arm.n_joints();
        let (mut q, mut dq) = (vec![0.3; n], vec![0.5; n]);
        let (first, mut most) = (energy(&plant, &q, &dq), 0.0_f64);

        for _ in 0..1000 {
            advance(&plant, [&mut q, &mut dq], &vec![0.0; n], 0.01);
            most = most.max(plant.arm.kinetic_energy(&q, &dq));
            let lost = (energy(&plant, &q, &dq) - first).abs();
            assert!(lost <= 1e-8 * most.max(1.0), "{name}: {lost} J of {most} J");
        }
        assert!(most > 10.0, "{name} swings");
    }
}

#[test]
fn friction_takes_as_much_energy_as_its_power_says() {
    let plant = rubbing(Arm::builtin("planar-2").unwrap());
    let (mut q, mut dq) = (vec![-1.0, 0.4], vec![2.0, -1.0]);
    let (first, step, mut taken) = (energy(&plant, &q, &dq), 1e-4, 0.0);
    let power = |dq: &[f64]| -> f64 {
        plant.friction.torques(dq).iter().zip(dq).map(|(rubs, dq)| rubs * dq).sum()
    };

    for _ in 0..5000 {
        let before = power(&dq);
        advance(&plant, [&mut q, &mut dq], &[0.0; 2], step);
        taken += step * f64::midpoint(before, power(&dq));
    }

    // Trapezoids of 0.1 ms across the reversals, where power is next to nothing.
    let lost = first - energy(&plant, &q, &dq);
    assert!(lost > 1.0 && (lost - taken).abs() < 1e-4 * lost, "{lost} J, {taken} J");
}

#[test]
fn a_joint_creeps_below_its_breakaway_torque_as_slowly_as_is_said_and_slides_above() {
    let plant = rubbing(Arm::builtin("planar-2").unwrap());
    // Hanging down, with a torque at the first joint for a second: how far it turns.
    let turned = |tau: f64| {
        let (mut q, mut dq) = (vec![-std::f64::consts::FRAC_PI_2, 0.0], vec![0.0; 2]);
        advance(&plant, [&mut q, &mut dq], &[tau, 0.0], 1.0);
        q[0] + std::f64::consts::FRAC_PI_2
    };

    // Half of the breakaway torque, and one and a half of it.
    let (creeps, slides) = (turned(3.0), turned(9.0));

    let creep = 0.5_f64.atanh() * plant.friction.width;
    assert!(creeps > 0.0 && creeps < 1.01 * creep, "{creeps} rad in a second, {creep} expected");
    assert!(slides > 0.1, "{slides}");
}

#[test]
fn a_sharper_reversal_changes_little() {
    let arm = Arm::builtin("planar-2").unwrap();
    let end = |width: f64| {
        let text = format!(
            "width = {width}\n[joint1]\ncoulomb = 4.0\nstiction = 6.0\nspeed = 0.1\n\
             [joint2]\ncoulomb = 1.0"
        );
        let friction = Friction::from_toml(&text, arm.joints()).unwrap();
        let plant = Plant { friction, ..Plant::ideal(arm.clone()) };
        let (mut q, mut dq) = (vec![-1.0, 0.4], vec![0.0; 2]);
        advance(&plant, [&mut q, &mut dq], &[0.0; 2], 1.5);
        q
    };

    let (usual, sharp) = (end(1e-3), end(1e-4));

    for (usual, sharp) in usual.iter().zip(&sharp) {
        assert!((usual - sharp).abs() < 5e-3, "{usual} and {sharp}");
    }
}

#[test]
fn an_arm_with_larger_rotors_is_slower_to_move() {
    let arm = Arm::builtin("puma560-3").unwrap();
    let geared = Plant::ideal(arm.clone().with_rotors(&[1.0, 2.0, 3.0]).unwrap());
    let (q, dq, ddq) = ([0.1, 0.2, 0.3], [0.5; 3], [1.0, -1.0, 2.0]);

    let [bare, more] = [arm.inverse_dynamics(&q, &dq, &ddq), geared.needed_torque(&q, &dq, &ddq)];

    for (i, rotor) in [1.0, 2.0, 3.0].into_iter().enumerate() {
        assert!((more[i] - bare[i] - rotor * ddq[i]).abs() < 1e-12);
    }
    assert!(arm.clone().with_rotors(&[1.0]).is_err());
    assert!(arm.with_rotors(&[1.0, -1.0, 0.0]).is_err());
}

#[test]
fn a_recording_follows_its_velocities_and_holds_the_torque_they_need() {
    let plant = rubbing(Arm::builtin("puma560-3").unwrap());
    let wanted = periodic(&plant.arm, &Periodic { seconds: 5.0, ..Periodic::default() }).unwrap();

    let log = record(&plant, &wanted, 60.0).unwrap();

    let (mut wrong, mut size) = (0.0, 0.0);
    for row in 1000..5000 {
        let State { q, dq, ddq } = State::of(&wanted, row);
        for (i, tau) in plant.needed_torque(&q, &dq, &ddq).into_iter().enumerate() {
            assert!((log.of(Signal::Q)[i][row] - q[i]).abs() < 0.05, "joint {i} at row {row}");
            wrong += (log.of(Signal::Tau)[i][row] - tau).powi(2);
            size += tau * tau;
        }
    }
    // The drives follow with an error of some mrad, and reverse a little later.
    assert!((wrong / size).sqrt() < 0.1, "{}", (wrong / size).sqrt());
}

#[test]
fn parts_of_different_arms_are_refused() {
    let arm = Arm::builtin("planar-2").unwrap();
    let plant = Plant { friction: Friction::none(3), ..Plant::ideal(arm.clone()) };
    let mut slow = Plant::ideal(arm);
    slow.drive.delay = f64::NAN;

    assert!(matches!(plant.check(), Err(SimError::JointCount { .. })));
    assert!(matches!(slow.check(), Err(SimError::Setting { .. })));
}

/// Dry friction of each joint \[N·m\], the same at rest and in motion.
const DRY: [f64; 3] = [8.0, 10.0, 4.0];
/// Of the bristles \[N·m/rad\].
const STIFFNESS: f64 = 200.0;

#[test]
fn bristles_hold_a_load_below_the_breakaway_torque() {
    // Damped, or they would swing past what the load asks for.
    let arm = Arm::builtin("puma560-3").unwrap();
    let row = |(name, dry): (&String, f64)| {
        format!("[{name}]\ncoulomb = {dry}\nstiffness = {STIFFNESS}\ndamping = 60.0\n")
    };
    let text: String = arm.joints().iter().zip(DRY).map(row).collect();
    let friction = Friction::from_toml(&text, arm.joints()).unwrap();
    let plant = Plant { friction, ..Plant::ideal(arm) };
    let q = [0.3, 0.2, -0.4];
    let held = plant.arm.gravity_torque(&q);
    let pushed: Vec<f64> = held.iter().zip(DRY).map(|(held, dry)| held + 0.3 * dry).collect();
    let (mut now, mut dq) = (q, [0.0; 3]);

    advance(&plant, [&mut now, &mut dq], &pushed, 20.0);

    for joint in 0..3 {
        // Bent as far as the load asks for, and gravity has hardly changed: no creep.
        let moved = (now[joint] - q[joint]).abs();
        assert!(moved < 2.0 * DRY[joint] / STIFFNESS, "joint {joint} moved {moved} rad");
    }
}
