//! Rows at hand instead of files: fit a `Motion`, and predict a single state.

use faer::Mat;
use std::error::Error;
use torquewise::motion::{Motion, Signals};
use torquewise::{Fit, Torque};

fn main() -> Result<(), Box<dyn Error>> {
    // A pendulum of 2 kg on 0.5 m: τ = m l² q̈ + m g l sin q.
    let rows = 6000;
    let t: Vec<f64> = (0..rows).map(|row| 0.01 * f64::from(row)).collect();
    let column = |signal: &dyn Fn(f64) -> f64| Mat::from_fn(t.len(), 1, |row, _| signal(t[row]));
    let q = |t: f64| 1.5 * (0.9 * t).sin() + 0.6 * (2.3 * t).cos();
    let dq = |t: f64| 1.35 * (0.9 * t).cos() - 1.38 * (2.3 * t).sin();
    let ddq = |t: f64| -1.215 * (0.9 * t).sin() - 3.174 * (2.3 * t).cos();
    let tau = |t: f64| 0.5 * ddq(t) + 9.81 * q(t).sin();
    let motion = Motion::new(Signals {
        joints: vec!["hip".into()],
        q: column(&q),
        dq: column(&dq),
        ddq: column(&ddq),
        tau: Some(column(&tau)),
        t: t.clone(),
    })?;

    let fit = Fit::new(&motion).run()?;

    let torque = Torque::new(&fit.model);
    let [held] = torque.at(&[1.0], &[0.0], &[0.0])?[..] else { return Err("one joint".into()) };
    println!("torque to hold 1 rad: {held:.4} N·m, truth {:.4}", 9.81 * 1.0_f64.sin());
    Ok(())
}
