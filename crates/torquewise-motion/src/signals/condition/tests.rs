//! A pendulum whose motion and torque are known, measured badly.

use super::*;
use crate::signals::clean::cleaned;
use approx::assert_abs_diff_eq;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::error::Error;
use std::f64::consts::PI;

/// q, dq, ddq of two sines at t.
fn motion(t: f64) -> [f64; 3] {
    let (a, b) = (2.0 * PI * 0.3, 2.0 * PI * 0.9);
    [
        (a * t).sin() + 0.4 * (b * t).cos(),
        a * (a * t).cos() - 0.4 * b * (b * t).sin(),
        -a * a * (a * t).sin() - 0.4 * b * b * (b * t).cos(),
    ]
}

/// Inertia and gravity.
fn torque(t: f64) -> f64 {
    let [q, _, ddq] = motion(t);
    0.7 * ddq + 9.0 * q.sin()
}

struct Measured {
    n: usize,
    jitter: f64,
    noise: f64,
    velocity_lag: f64,
    torque_lag: f64,
}

const BAD: Measured =
    Measured { n: 6000, jitter: 0.1, noise: 1.0, velocity_lag: 0.012, torque_lag: 0.02 };
const RATE: f64 = 100.0;

fn measure(how: &Measured) -> Raw {
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    let mut draw = |sigma: f64| {
        let e: f64 = StandardNormal.sample(&mut rng);
        how.noise * sigma * e
    };
    let mut jitter = ChaCha8Rng::seed_from_u64(22);
    let mut stamp = |k| (k as f64 + how.jitter * jitter.random_range(-1.0..1.0)) / RATE;
    let t: Vec<f64> = (0..how.n).map(&mut stamp).collect();
    let mut column = |sigma: f64, value: &dyn Fn(f64) -> f64| {
        Some(vec![t.iter().map(|t| value(*t) + draw(sigma)).collect()])
    };
    let q = column(1e-4, &|t| motion(t)[0]);
    let dq = column(1e-2, &|t| motion(t - how.velocity_lag)[1]);
    let tau = column(0.3, &|t| torque(t - how.torque_lag));
    Raw { joints: vec!["arm_1".to_owned()], t, signals: [q, dq, None, tau] }
}

fn torque_of(raw: &mut Raw) -> &mut Vec<f64> {
    &mut raw.signals[Signal::Tau as usize].as_mut().unwrap()[0]
}

/// Root mean square of the difference to the truth.
fn off(found: &[f64], t: &[f64], truth: impl Fn(f64) -> f64) -> f64 {
    let squares = found.iter().zip(t).map(|(x, t)| (x - truth(*t)).powi(2));
    (squares.sum::<f64>() / t.len() as f64).sqrt()
}

fn column(x: faer::MatRef<'_, f64>) -> Vec<f64> {
    x.col(0).iter().copied().collect()
}

#[test]
fn a_bad_log_becomes_the_motion_it_was() {
    let mut raw = measure(&BAD);
    for row in [1500, 2200, 2201, 4000] {
        torque_of(&mut raw)[row] += 40.0;
    }
    let settings = Conditioning { delay: BAD.torque_lag, ..Conditioning::default() };

    let Conditioned { motion: found, report } = condition(&raw, &settings).unwrap();

    let t = found.t();
    assert!(off(&column(found.q()), t, |t| motion(t)[0]) < 1e-4);
    assert!(off(&column(found.dq()), t, |t| motion(t)[1]) < 2e-3);
    assert!(off(&column(found.ddq()), t, |t| motion(t)[2]) < 0.05);
    assert!(off(&column(found.tau().unwrap()), t, torque) < 0.12);
    assert_eq!(report.outliers.len(), 1);
    assert_eq!(report.outliers[0].rows, [1500, 2200, 2201, 4000]);
    let lag = report.dq_lag[0].unwrap().seconds;
    assert_abs_diff_eq!(lag, BAD.velocity_lag, epsilon = 1e-3);
    let cutoff = report.cutoff;
    assert!((1.0..10.0).contains(&cutoff), "{cutoff}");
    assert!(!report.timing.is_even() && report.rate_out >= 8.0 * cutoff);
}

#[test]
fn noise_of_each_signal_is_reported() {
    let report = condition(&measure(&BAD), &Conditioning::default()).unwrap().report;

    let sigma = |name| report.signals.iter().find(|s| s.signal == name).unwrap().noise;
    // Resampling takes away up to a quarter of it.
    assert!((0.7e-4..1.1e-4).contains(&sigma("q")));
    assert!((0.7e-2..1.1e-2).contains(&sigma("dq")));
    assert!((0.2..0.33).contains(&sigma("tau")));
}

#[test]
fn a_perfect_log_passes_as_it_is() {
    let perfect = Measured { jitter: 0.0, noise: 0.0, velocity_lag: 0.0, torque_lag: 0.0, ..BAD };
    let raw = measure(&perfect);

    let (base, even) = cleaned(&raw).unwrap();
    let found = smooth(&even.columns, &even.columns, base.timing.rate, 0.0).unwrap();

    assert_eq!(found.t(), raw.t);
    assert_eq!(column(found.q()), raw.of(Signal::Q)[0]);
    assert_eq!(column(found.tau().unwrap()), raw.of(Signal::Tau)[0]);
    assert!(off(&column(found.ddq()), &raw.t, |t| motion(t)[2]) < 1e-6);
    assert!(even.outliers.is_empty() && base.timing.is_even());
}

#[test]
fn rows_are_thinned_and_ends_dropped_unless_all_are_wanted() {
    let raw = measure(&Measured { jitter: 0.0, ..BAD });
    let usual = Conditioning { cutoff: Cutoff::Hz(5.0), ..Default::default() };

    let kept = condition(&raw, &usual).unwrap();
    let all = condition(&raw, &Conditioning { thins: false, trims: false, ..usual }).unwrap();

    assert_eq!((all.motion.t(), all.report.trimmed), (&raw.t[..], 0.0));
    assert_eq!((kept.report.cutoff, kept.report.rate_out), (5.0, 50.0));
    let t = kept.motion.t();
    assert!((0.1..6.0).contains(&t[0]) && t[t.len() - 1] < 59.9, "{}", t[0]);
    assert_abs_diff_eq!(t[1] - t[0], 0.02, epsilon = 1e-12);
}

#[test]
fn a_coarse_current_is_told_and_one_of_two_values_is_not_cut_off() {
    let mut raw = measure(&BAD);
    for tau in torque_of(&mut raw) {
        *tau = (*tau / 4.0).round() * 4.0;
    }

    let report = condition(&raw, &Conditioning::default()).unwrap().report;

    let coarse = report.signals.iter().filter(|s| s.is_coarse()).map(|s| s.signal);
    assert_eq!(coarse.collect::<Vec<_>>(), ["tau"]);
    assert!(report.to_string().contains("tau of arm_1 is quantised to 4.000e0"));
    *torque_of(&mut raw) = (0..BAD.n).map(|row| (row % 9).min(1) as f64).collect();
    let report = condition(&raw, &Conditioning::default()).unwrap().report;
    assert!(report.signals.iter().all(|s| !s.is_cut_off()));
}

#[test]
fn errors_say_which_signal_of_which_joint() {
    let mut raw = measure(&BAD);
    torque_of(&mut raw)[17] = f64::NAN;
    let error = condition(&raw, &Conditioning::default()).unwrap_err();
    assert_eq!(error.to_string(), "cannot condition tau of joint arm_1");
    assert_eq!(error.source().unwrap().to_string(), "tau1 is not finite at row 17");
    let help = miette::Diagnostic::help(&error).unwrap().to_string();
    assert_eq!(help, "drop the row or repair the signal");

    let mut repeated = measure(&BAD);
    repeated.t[2] = repeated.t[1];
    let error = condition(&repeated, &Conditioning::default()).unwrap_err();
    assert_eq!(error, MotionError::TimeOrder { row: 2 });

    let short = measure(&Measured { n: 40, ..BAD });
    assert!(condition(&short, &Conditioning::default()).is_err());

    let settings = Conditioning { delay: 1.0, ..Default::default() };
    let error = condition(&measure(&Measured { n: 200, ..BAD }), &settings).unwrap_err();
    assert!(matches!(error, MotionError::NothingLeft { .. }));
}
