//! Arms with known delay and friction: each delay is recovered, or nothing is said.

use super::torque_delay;
use crate::signals::raw::Raw;
use crate::signals::settings::Conditioning;
use faer::Mat;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use std::f64::consts::FRAC_PI_2;

const RATE: f64 = 250.0;
const ROWS: usize = 15_000;

/// Position, velocity and acceleration of two joints, each driven by five sines.
fn motion(t: f64) -> [[f64; 2]; 3] {
    // Of a single sine, a lag and a little more friction look the same.
    const SINES: [(f64, f64); 5] =
        [(0.7, 0.53), (0.4, 1.31), (0.25, 2.27), (0.15, 3.7), (0.1, 5.9)];
    let wave = |order: i32, joint: usize| -> f64 {
        let part = |(k, (size, rate)): (usize, (f64, f64))| {
            let rate = rate * (1.0 + 0.17 * joint as f64);
            let phase = (1 + k) as f64 * (1.0 + 1.3 * joint as f64);
            size * rate.powi(order) * (rate * t + phase + f64::from(order) * FRAC_PI_2).sin()
        };
        SINES.into_iter().enumerate().map(part).sum()
    };
    std::array::from_fn(|order| [0, 1].map(|joint| wave(order.try_into().unwrap(), joint)))
}

/// Torque of a planar arm of two joints, and Stribeck friction of a size (17).
fn torque([q, dq, ddq]: [[f64; 2]; 3], dry: f64) -> [f64; 2] {
    let (a, b, d) = (1.5, 0.4, 0.5);
    let (sin, cos) = q[1].sin_cos();
    let (outer, inner) = (8.0 * (q[0] + q[1]).cos(), 14.0 * q[0].cos());
    let inertia = [
        (a + 2.0 * b * cos) * ddq[0] + (d + b * cos) * ddq[1],
        (d + b * cos) * ddq[0] + d * ddq[1],
    ];
    let coriolis = [-b * sin * (2.0 * dq[0] * dq[1] + dq[1] * dq[1]), b * sin * dq[0] * dq[0]];
    let friction = |dq: f64| {
        let curve = 4.0 + 2.0 * (-(dq / 0.1).powi(2)).exp();
        dry * (dq / 1e-3).tanh() * curve + 1.5 * dq
    };
    [
        inertia[0] + coriolis[0] + outer + inner + friction(dq[0]),
        inertia[1] + coriolis[1] + outer + friction(dq[1]),
    ]
}

/// What encoders and torque sensors write down, the torque late by a time.
fn log(lag: f64, dry: f64) -> Raw {
    let t: Vec<f64> = (0..ROWS).map(|row| row as f64 / RATE).collect();
    let (mut rng, noise) = (ChaCha8Rng::seed_from_u64(7), Normal::new(0.0, 0.1).unwrap());
    let encoder = 1e-5;
    let q =
        Mat::from_fn(ROWS, 2, |row, joint| (motion(t[row])[0][joint] / encoder).round() * encoder);
    let tau = Mat::from_fn(ROWS, 2, |row, joint| {
        torque(motion(t[row] - lag), dry)[joint] + noise.sample(&mut rng)
    });
    let joints = vec!["hip".into(), "knee".into()];
    Raw { joints, t, q, dq: None, ddq: None, tau: Some(tau) }
}

#[test]
fn a_delay_is_recovered_with_and_without_dry_friction() {
    for dry in [0.0, 1.0] {
        for lag in [0.0, 0.005, 0.012, -0.013] {
            let found = torque_delay(&log(lag, dry), &Conditioning::default()).unwrap();

            let seconds = found.map_or(0.0, |shift| shift.seconds);
            println!("lag {lag}, dry friction {dry}: {found:?}");
            assert!((seconds - lag).abs() < 1e-3, "{lag}, {dry}: {found:?}");
        }
    }
}

#[test]
fn what_cannot_be_told_is_not_guessed() {
    let none = |raw: &Raw| torque_delay(raw, &Conditioning::default()).unwrap().is_none();
    let (m, whole) = (150, log(0.012, 1.0));
    let first = |x: &Mat<f64>| Mat::from_fn(m, 2, |row, joint| x[(row, joint)]);
    let mut short = whole.clone();
    (short.t, short.q) = (whole.t[..m].to_vec(), first(&whole.q));
    short.tau = whole.tau.as_ref().map(first);
    let mut still = whole.clone();
    still.q = Mat::from_fn(ROWS, 2, |_, joint| joint as f64);

    assert!(none(&short), "fewer rows than a model needs");
    assert!(none(&still), "nothing moves");
}
