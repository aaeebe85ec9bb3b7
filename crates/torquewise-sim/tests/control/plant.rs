//! Plants against inverse dynamics, and parts that do not belong together.
use torquewise_motion::Signal;
use torquewise_sim::control::{Periodic, Plant, periodic, record};
use torquewise_sim::{Arm, Friction, SimError, Stribeck};

const RUBS: Stribeck = Stribeck { coulomb: 4.0, stiction: 6.0, speed: 0.1, viscous: 3.0 };

fn rubbing(arm: Arm) -> Plant {
    let friction = Friction::new(&vec![RUBS; arm.n_joints()]).unwrap();
    Plant { friction, ..Plant::ideal(arm) }
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
        let at = |x: faer::MatRef<'_, f64>| x.row(row).iter().copied().collect::<Vec<_>>();
        let (q, dq, ddq) = (at(wanted.q()), at(wanted.dq()), at(wanted.ddq()));
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
