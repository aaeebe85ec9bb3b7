//! Joints placed at random: energies summed body by body.
#![expect(non_snake_case, reason = "frames are written quantity_fromTo, as in `spatial`")]

use crate::arm::{Joint, STANDARD_GRAVITY};
use crate::{Arm, Body, JointLimits, Pose, shifted_turned};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Joints placed and laden at random.
fn arm(n: usize, random: &mut ChaCha8Rng) -> Arm {
    let mut three = || std::array::from_fn(|_| random.random_range(-1.0..1.0));
    let joints = (0..n).map(|i| {
        let name = format!("joint{}", i + 1);
        // Principal moments of at least 0.5 outweigh products of inertia of at most 0.1.
        let ([x, y, z], [xy, xz, yz]): ([f64; 3], [f64; 3]) = (three(), three());
        let moments = [0.5 + x.abs(), 0.5 + y.abs(), 0.5 + z.abs(), 0.1 * xy, 0.1 * xz, 0.1 * yz];
        let X_PJ = shifted_turned(three(), three().map(|x| 3.0 * x));
        let body = Body::new(1.0 + 0.3 * i as f64, three(), moments);
        let (kind, limits) = (torquewise_rigid::JointKind::Revolute, JointLimits::default());
        (name, Joint { kind, X_PJ, body, rotor: 0.2, range: [-1.0, 1.0], limits })
    });
    Arm::new("arm".into(), STANDARD_GRAVITY, joints.collect()).unwrap()
}

/// T and V from the velocity and height of each body.
fn energies(arm: &Arm, q: &[f64], dq: &[f64]) -> [f64; 2] {
    let (mut w, mut v) = (Vector3::zeros(), Vector3::zeros());
    let mut X_WJ = Pose::identity();
    let (mut twice_kinetic, mut potential) = (0.0, 0.0);
    for ((joint, &q), &dq) in arm.joints.iter().zip(q).zip(dq) {
        let X_PJ = joint.X_PJ * shifted_turned([0.0; 3], [0.0, 0.0, q]);
        v = X_PJ.inverse() * (v + w.cross(&X_PJ.translation.vector));
        w = X_PJ.inverse() * w + Vector3::z() * dq;
        X_WJ *= X_PJ;
        let body = &joint.body;
        let v_com = v + w.cross(&body.com);
        twice_kinetic += body.mass * v_com.norm_squared() + w.dot(&(body.inertia * w));
        twice_kinetic += joint.rotor * dq * dq;
        potential -= body.mass * Vector3::from(arm.gravity()).dot(&body.seen_from(&X_WJ).com);
    }
    [twice_kinetic / 2.0, potential]
}

#[test]
fn energies_are_those_of_the_bodies_one_by_one() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for n in 1..=8 {
        for _ in 0..8 {
            let arm = arm(n, &mut random);
            let [q, dq] = [3.0, 2.0].map(|most| -> Vec<f64> {
                (0..n).map(|_| random.random_range(-most..most)).collect()
            });
            let [kinetic, potential] = energies(&arm, &q, &dq);

            let found = [arm.kinetic_energy(&q, &dq), arm.potential_energy(&q)];

            assert!((found[0] - kinetic).abs() < 1e-12 * kinetic, "{found:?} {kinetic}");
            // Heights of a few metres that cancel.
            let scale = 10.0 * arm.n_joints() as f64;
            assert!((found[1] - potential).abs() < 1e-13 * scale.powi(2), "{found:?} {potential}");
        }
    }
}
