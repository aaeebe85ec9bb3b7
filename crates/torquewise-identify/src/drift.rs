//! Joints whose friction changes along a log, as gears warm.

use crate::Warning;
use crate::clustered::{Solved, Stretches};
use std::ops::Range;
use torquewise_model::{Model, Torque};
use torquewise_motion::Motion;
use torquewise_stepwise::IdentifyError;

/// Logs shorter than this \[s\] warm no gear; after a pause gears have cooled, or a clock is another's.
const LONG: f64 = 300.0;
const PAUSE: f64 = 30.0;
/// Stretches of time whose scores scatter: neighbouring residuals are alike.
const STRETCHES: usize = 20;
/// A change below this is not worth a word; friction does not change by more than all of itself.
const LEAST_PART: f64 = 0.05;
const MOST_PART: f64 = 1.0;
/// A change below so many standard errors is chance.
const LEAST_ERRORS: f64 = 4.0;
/// Part of the squares of what grows that friction itself must not explain.
const LEAST_FREE: f64 = 1e-6;

/// The joints whose friction drifts along logs of five minutes or more.
///
/// What the model leaves of the torque is regressed on its friction and on its friction times the
/// time since the middle of the log, as a part of its length: r = a F + b F s with s from −½ to ½,
/// so that friction changes by b/(1 + a) of itself along the log. Standard errors are those of
/// sums over stretches of time. Rows at which the joint rests say nothing: its friction may be anything.
///
/// - `sample`: rows in the order of time, log after log, with torque
///
/// # Errors
/// [`IdentifyError`] if torque is missing or the motion is of another arm.
pub(crate) fn drifts(model: &Model, sample: &Motion) -> Result<Vec<Warning>, IdentifyError> {
    let t = sample.t();
    let length = |log: &Range<usize>| t[log.end - 1] - t[log.start];
    let runs_on = |row: usize| t[row] > t[row - 1] && t[row] - t[row - 1] < PAUSE;
    let logs = stretches(t.len(), runs_on).into_iter();
    let logs: Vec<Range<usize>> = logs.filter(|log| length(log) >= LONG).collect();
    let rows: Vec<(usize, f64)> = (logs.iter())
        .flat_map(|log| {
            let (first, length) = (t[log.start], length(log));
            log.clone().map(move |row| (row, (t[row] - first) / length - 0.5))
        })
        .collect();
    let longest = logs.iter().map(length).fold(0.0, f64::max);
    if rows.len() < 2 * STRETCHES {
        return Ok(Vec::new());
    }
    let parts = Torque::new(model).parts(sample)?;
    let (tau, total, slow) = (sample.require_tau()?, parts.total(), model.rest_speeds());
    let of_joint = |joint: usize| {
        let friction = parts.friction.col(joint);
        let moves = |(row, _): &&(usize, f64)| sample.dq()[(*row, joint)].abs() >= slow[joint];
        let rows: Vec<&(usize, f64)> = rows.iter().filter(moves).collect();
        if rows.len() < 2 * STRETCHES {
            return None;
        }
        let mut sums = Stretches::new(2, usize::MAX, rows.len().div_ceil(STRETCHES));
        for &&(row, s) in &rows {
            let left = tau[(row, joint)] - total[(row, joint)];
            sums.add(&[friction[row], friction[row] * s], left, 1.0);
        }
        let Solved { values, std_errors, free, .. } = sums.solved()?;
        let scale = 1.0 + values[0];
        let (part, std_error) = (values[1] / scale, std_errors[1] / scale);
        let is_told = free[1] > LEAST_FREE && scale > LEAST_PART;
        let found = is_told
            && (LEAST_PART..=MOST_PART).contains(&part.abs())
            && part.abs() >= LEAST_ERRORS * std_error;
        let joint = model.joints[joint].clone();
        found.then_some(Warning::Drift { joint, part, std_error, seconds: longest })
    };
    Ok((0..model.n_joints()).filter_map(of_joint).collect())
}

/// Where time runs on: a log ends where it does not.
pub(crate) fn logs(t: &[f64]) -> Vec<Range<usize>> {
    stretches(t.len(), |row| t[row] > t[row - 1])
}

/// Stretches of rows, each of which but the first runs on from the one before.
fn stretches(rows: usize, runs_on: impl Fn(usize) -> bool) -> Vec<Range<usize>> {
    let ends: Vec<usize> = (1..rows).filter(|&row| !runs_on(row)).collect();
    let starts = std::iter::once(0).chain(ends.iter().copied());
    starts.zip(ends.iter().copied().chain([rows])).map(|(a, b)| a..b).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;
    use torquewise_model::friction::FrictionLaw;
    use torquewise_model::{Form, FrictionTerm, Weighted};
    use torquewise_motion::Signals;

    const ROWS: usize = 4_000;

    fn model() -> Model {
        let law = FrictionLaw::Coulomb { width: 0.0 };
        let dry = |joint| Weighted::new(FrictionTerm::of_joint(2, joint, law), 5.0);
        Model {
            joints: vec!["cold".into(), "warm".into()],
            form: Form::Torque(vec![vec![], vec![]]),
            friction: vec![dry(0), dry(1)],
            ..Model::default()
        }
    }

    /// A log of so many seconds with waves of friction, that of the first joint falling by a part,
    /// and a wave that no model knows.
    fn log(seconds: f64, falls: f64) -> Motion {
        let t: Vec<f64> = (0..ROWS).map(|row| row as f64 * seconds / ROWS as f64).collect();
        let dq = |row: usize, joint: usize| (0.37 * row as f64 + joint as f64).sin();
        let tau = |row: usize, joint: usize| {
            let left = if joint == 0 { 1.0 - falls * row as f64 / ROWS as f64 } else { 1.0 };
            5.0 * left * dq(row, joint).signum() + (0.013 * row as f64).sin()
        };
        Motion::new(Signals {
            joints: vec!["cold".into(), "warm".into()],
            t,
            q: Mat::zeros(ROWS, 2),
            dq: Mat::from_fn(ROWS, 2, dq),
            ddq: Mat::zeros(ROWS, 2),
            tau: Some(Mat::from_fn(ROWS, 2, tau)),
        })
        .unwrap()
    }

    #[test]
    fn friction_that_falls_along_a_long_log_is_named_and_neither_a_short_log_nor_steady_friction() {
        let found = drifts(&model(), &log(1_200.0, 0.2)).unwrap();

        let [Warning::Drift { joint, part, std_error, .. }] = &found[..] else {
            panic!("{found:?}")
        };
        assert_eq!(joint, "cold");
        // From 1 to 0.8, beside 0.9 in the middle.
        assert!((part + 0.2 / 0.9).abs() < 3.0 * std_error.max(1e-3));
        assert!(found[0].to_string().starts_with("friction of cold falls by 22 ±"), "{}", found[0]);
        assert_eq!(drifts(&model(), &log(200.0, 0.2)).unwrap(), []);
        assert_eq!(drifts(&model(), &log(1_200.0, 0.0)).unwrap(), []);
    }

    #[test]
    fn a_pause_between_clocks_and_joints_at_rest_are_no_warm_gears() {
        let mut paused = log(200.0, 0.2).into_signals();
        paused.t.iter_mut().skip(ROWS / 2).for_each(|t| *t += 300.0);
        let mut resting = log(1_200.0, 0.2).into_signals();
        // Its dry friction holds what it is asked for, more and more of it.
        let tau = resting.tau.as_mut().unwrap();
        for row in (0..ROWS).filter(|row| row % 50 != 0) {
            resting.dq[(row, 0)] = 1e-3;
            tau[(row, 0)] = 5.0 - 8.0 * row as f64 / ROWS as f64;
        }
        let found = |signals| drifts(&model(), &Motion::new(signals).unwrap()).unwrap();

        assert_eq!(found(paused), []);
        let told = found(resting);
        let is_large =
            |own: &Warning| matches!(own, Warning::Drift { part, .. } if part.abs() > 0.5);
        assert!(!told.iter().any(is_large), "{told:?}");
    }
}
