//! One trajectory cleaned, resampled, filtered and differentiated.

use crate::Motion;
use crate::error::{MotionError, Result};
use crate::signals::clean::Even;
use crate::signals::delay::{Shift, lag};
use crate::signals::noise::{quantisation, standstill, white_noise};
use crate::signals::plan::{Conditioning, Cutoff, Plan, keep_every};
use crate::signals::raw::{Raw, Signal};
use crate::signals::report::{ConditionReport, CutoffFrom, SignalReport};
use crate::signals::resample::timing;
use crate::signals::smooth::{filter, smooth};
use faer::Mat;

/// Longest lag of the measured velocity that is looked for \[s\].
const LONGEST_LAG: f64 = 0.25;
const LAG_ROWS: usize = 4096;
/// A joint of less than this RMS speed \[rad/s, m/s\] stands still.
const STILL: f64 = 1e-3;

/// A clean trajectory, and how it came about.
#[derive(Clone, Debug)]
pub struct Conditioned {
    /// q, q̇, q̈ and τ at even times.
    pub motion: Motion,
    /// What was found and done.
    pub report: ConditionReport,
}

/// Conditions one trajectory: spikes out, even stamps, one zero-phase low-pass filter for all
/// signals, derivatives, torque advanced by its delay, ends trimmed, rows left out.
///
/// # Errors
/// [`MotionError`] that says which signal of which joint, and what to do.
pub fn condition(raw: &Raw, settings: &Conditioning) -> Result<Conditioned> {
    let (plan, even) = Plan::with_even(raw, settings)?;
    let filtered = filter(&even, &plan)?;
    let smooth = smooth(&filtered, &even, &plan)?;
    let rows = even.columns.t.len();
    let kept = plan.trim..rows.saturating_sub(plan.trim);
    let motion = smooth.rows(kept, plan.keep_every).ok_or(MotionError::NothingLeft { rows })?;
    // The lag is against the derivative of position, wherever velocity is taken from.
    let dq = smooth.motion.dq().to_owned();
    let report = ConditionReport {
        rows_in: raw.t.len(),
        rows_out: motion.n_rows(),
        timing: timing(&raw.t)?,
        resampled: !plan.base.timing.is_even(),
        rate_out: plan.rate / plan.keep_every as f64,
        cutoff: plan.cutoff,
        cutoff_from: match plan.settings.cutoff {
            Cutoff::Auto => CutoffFrom::Motion,
            Cutoff::Hz(_) | Cutoff::Off => CutoffFrom::Setting,
        },
        signals: signal_reports(raw, &even, &filtered, &dq),
        outliers: even.outliers,
        dq_lag: lags(&dq, &filtered, &plan)?,
        dq_gain: gains(&dq, &filtered, &plan),
        seen_elsewhere: Vec::new(),
        delay: plan.settings.delay,
        trimmed: plan.trim as f64 / plan.rate,
    };
    Ok(Conditioned { motion, report })
}

fn signal_reports(raw: &Raw, even: &Even, filtered: &Raw, dq: &Mat<f64>) -> Vec<SignalReport> {
    let still: Vec<Vec<bool>> = (0..dq.ncols()).map(|j| standstill(dq.col_as_slice(j))).collect();
    let mut reports = Vec::new();
    for (((signal, raw_columns), (_, before)), (_, after)) in
        raw.present().zip(even.columns.present()).zip(filtered.present())
    {
        for (joint, name) in raw.joints.iter().enumerate() {
            reports.push(SignalReport {
                signal: signal.name(),
                joint: name.clone(),
                noise: white_noise(&before[joint], &still[joint]),
                quantisation: quantisation(&raw_columns[joint]),
                removed: removed(&before[joint], &after[joint]),
            });
        }
    }
    reports
}

/// Variance of the difference as a share of that of `before`; zero for what does not move.
fn removed(before: &[f64], after: &[f64]) -> f64 {
    let variance = |x: &[f64]| {
        let mean = x.iter().sum::<f64>() / x.len() as f64;
        x.iter().map(|x| (x - mean).powi(2)).sum::<f64>()
    };
    let off: Vec<f64> = before.iter().zip(after).map(|(b, a)| b - a).collect();
    let whole = variance(before);
    if whole > 0.0 { (variance(&off) / whole).min(1.0) } else { 0.0 }
}

/// Σ measured · derived / Σ derived² of each joint, away from the ends.
fn gains(dq: &Mat<f64>, filtered: &Raw, plan: &Plan) -> Vec<Option<f64>> {
    let rows = plan.trim..dq.nrows().saturating_sub(plan.trim);
    let of = |(joint, measured): (usize, &Vec<f64>)| {
        let derived = dq.col_as_slice(joint).get(rows.clone())?;
        let measured = measured.get(rows.clone())?;
        let square: f64 = derived.iter().map(|x| x * x).sum();
        let product: f64 = derived.iter().zip(measured).map(|(d, m)| d * m).sum();
        let moves = square > STILL * STILL * derived.len() as f64;
        moves.then(|| product / square).filter(|gain| gain.is_finite())
    };
    filtered.of(Signal::Dq).iter().enumerate().map(of).collect()
}

/// Lag of each joint's measured velocity, on rows thinned out as far as the filter allows.
fn lags(dq: &Mat<f64>, filtered: &Raw, plan: &Plan) -> Result<Vec<Option<Shift>>> {
    let every = keep_every(plan.cutoff, plan.rate);
    let rows = plan.trim..dq.nrows().saturating_sub(plan.trim);
    let thin = |x: &[f64]| -> Vec<f64> {
        let kept = x.get(rows.clone()).unwrap_or_default();
        kept.iter().step_by(every).take(LAG_ROWS).copied().collect()
    };
    let rate = plan.rate / every as f64;
    let of = |(joint, measured): (usize, &Vec<f64>)| {
        let found =
            lag(&thin(dq.col_as_slice(joint)), &thin(measured), rate, -LONGEST_LAG..=LONGEST_LAG);
        found.map_err(|e| e.of(Signal::Dq.name(), &filtered.joints[joint]))
    };
    filtered.of(Signal::Dq).iter().enumerate().map(of).collect()
}

#[cfg(test)]
mod tests;
