//! From torques of an independent tool and closed forms to the same torques here.
use crate::shared::shared;
use std::path::Path;
use torquewise_sim::Arm;

/// Rows of t, q1.., dq1.., ddq1.., tau1.., each cut into q, dq, ddq and tau.
fn states(path: &Path, n: usize) -> Vec<[Vec<f64>; 4]> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    assert_eq!(reader.headers().unwrap().len(), 1 + 4 * n);
    let rows = reader.records().map(|record| {
        let numbers: Vec<f64> = record.unwrap().iter().map(|x| x.parse().unwrap()).collect();
        std::array::from_fn(|part| numbers[1 + part * n..][..n].to_vec())
    });
    rows.collect()
}

/// Every torque within 1e-9 of the largest torque of its joint: the files hold 17 digits, about
/// a hundred roundings lie between, and 1e-9 leaves room for another order of operations.
fn assert_agrees(arm: &Arm, path: &Path) {
    let n = arm.n_joints();
    let states = states(path, n);
    assert_eq!(states.len(), 500);

    for joint in 0..n {
        let scale = states.iter().map(|[.., tau]| tau[joint].abs()).fold(0.0, f64::max);
        for (row, [q, dq, ddq, tau]) in states.iter().enumerate() {
            let found = arm.inverse_dynamics(q, dq, ddq)[joint];
            let error = (found - tau[joint]).abs() / scale;
            assert!(error < 1e-9, "{}: joint {joint}, row {row}: {error:e}", arm.name());
        }
    }
}

fn urdf_arm(file: &str, locked: &[String]) -> Option<Arm> {
    let text = std::fs::read_to_string(shared(file)?).unwrap();
    Some(Arm::from_urdf(&text, locked).unwrap())
}

#[test]
fn torques_agree_with_pinocchio() {
    let fingers = ["panda_finger_joint1".to_string(), "panda_finger_joint2".to_string()];
    let arms = [
        (Some(Arm::builtin("puma560-3").unwrap()), "oracle/puma560-3.csv"),
        (urdf_arm("robots/ur5.urdf", &[]), "oracle/ur5.csv"),
        (urdf_arm("robots/panda.urdf", &fingers), "oracle/panda.csv"),
    ];
    for (arm, oracle) in arms {
        if let (Some(arm), Some(oracle)) = (arm, shared(oracle)) {
            assert_agrees(&arm, &oracle);
        }
    }
}

/// The textbook two-link arm (masses in the middle of their links), angles from the horizontal.
fn two_link_torque(q: [f64; 2], dq: [f64; 2], ddq: [f64; 2]) -> [f64; 2] {
    let (m1, m2, i1, i2) = (4.0, 2.0, 0.08, 0.03);
    let (l1, c1, c2, g) = (0.5, 0.25, 0.2, 9.81);
    let (cos2, sin2) = (q[1].cos(), q[1].sin());
    let m22 = i2 + m2 * c2 * c2;
    let m12 = m22 + m2 * l1 * c2 * cos2;
    let m11 = i1 + m1 * c1 * c1 + m22 + m2 * l1 * (l1 + 2.0 * c2 * cos2);
    let h = m2 * l1 * c2 * sin2;
    let g2 = m2 * c2 * g * (q[0] + q[1]).cos();
    let g1 = (m1 * c1 + m2 * l1) * g * q[0].cos() + g2;
    [
        m11 * ddq[0] + m12 * ddq[1] - h * (2.0 * dq[0] * dq[1] + dq[1] * dq[1]) + g1,
        m12 * ddq[0] + m22 * ddq[1] + h * dq[0] * dq[0] + g2,
    ]
}

#[test]
fn planar_arm_obeys_the_textbook_equations() {
    let arm = Arm::builtin("planar-2").unwrap();

    for k in 0..200 {
        let k = f64::from(k);
        let (q, dq) = ([k.sin() * 3.0, (1.7 * k).cos() * 3.0], [(0.3 * k).cos(), (2.9 * k).sin()]);
        let ddq = [3.0 * (1.1 * k).sin(), 4.0 * (0.7 * k).cos()];

        let found = arm.inverse_dynamics(&q, &dq, &ddq);

        let expected = two_link_torque(q, dq, ddq);
        for (found, expected) in found.iter().zip(expected) {
            // Some fifty roundings of numbers up to 50 N·m.
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }
}

#[test]
fn a_gantry_lifts_its_load_and_pushes_all_that_hangs_on_each_slide() {
    let arm = Arm::builtin("gantry-3").unwrap();
    let (masses, rotors) = ([42.0 + 15.0 + 7.5, 15.0 + 7.5, 7.5], [6.0, 4.0, 2.5]);

    let weight = arm.gravity_torque(&[0.3, -0.2, 0.4]);
    let mass = arm.mass_matrix(&[0.3, -0.2, 0.4]);

    assert!(weight[0].abs() < 1e-12 && weight[1].abs() < 1e-12, "{weight:?}");
    assert!((weight[2].abs() - 7.5 * 9.81).abs() < 1e-12, "{weight:?}");
    for i in 0..3 {
        for j in 0..3 {
            let expected = if i == j { masses[i] + rotors[i] } else { 0.0 };
            assert!((mass[(i, j)] - expected).abs() < 1e-12, "{i} {j}: {}", mass[(i, j)]);
        }
    }
}

#[test]
fn a_scara_with_its_slide_held_is_a_planar_arm_and_its_spindle_weighs() {
    let arm = Arm::builtin("scara-4").unwrap();

    let weight = arm.gravity_torque(&[0.5, -0.7, 0.1, 0.3]);

    for joint in [0, 1, 3] {
        assert!(weight[joint].abs() < 1e-12, "{weight:?}");
    }
    // Down is positive: the motor pulls up.
    assert!((weight[2] + (1.1 + 0.9) * 9.81).abs() < 1e-12, "{weight:?}");
    let alone = |q: f64| arm.mass_matrix(&[0.0, -0.7, q, 0.3]);
    assert!((&alone(0.0) - &alone(0.2)).norm_max() < 1e-12, "the spindle slides along the turns");
}
