//! One trajectory cleaned, resampled, filtered and differentiated.

use crate::signals::delay::{Shift, lag};
use crate::signals::noise::{quantisation, standstill, white_noise};
use crate::signals::plan::{Conditioning, Cutoff, SignalPlan, keep_every, rows};
use crate::signals::report::{ConditionReport, CutoffFrom, SignalReport};
use crate::signals::smooth::{filter, kept, smooth};
use crate::{Motion, MotionError, Raw, Result, Signal};
use faer::Mat;

/// Longest lag of the measured velocity that is looked for \[s\].
const LONGEST_LAG: f64 = 0.25;
const LAG_ROWS: usize = 4096;
/// A joint of less than this RMS speed \[rad/s, m/s\] stands still, by means over a little time.
const STILL: f64 = 1e-3;
/// Gains are found from means over so many times one over the cut-off: slopes of encoders are noise
/// where a joint hardly moves, and less so over some time.
const SLOWLY: f64 = 4.0;

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
    let (plan, even) = SignalPlan::with_even(raw, settings)?;
    let filtered = filter(&even.columns, plan.cutoff, plan.rate)?;
    let smooth = smooth(&filtered, &even.columns, plan.rate, plan.settings.delay)?;
    let rows = even.columns.t.len();
    let indices = plan.trim..rows.saturating_sub(plan.trim);
    let motion = kept(&smooth, even.first, indices, plan.keep_every);
    let motion = motion.ok_or(MotionError::NothingLeft { rows })?;
    // The lag is against the derivative of position, wherever velocity is taken from.
    let dq = smooth.dq().to_owned();
    let (dq_lag, dq_gain) = lags_and_gains(&dq, &filtered, &plan);
    let report = ConditionReport {
        rows_in: raw.t.len(),
        rows_out: motion.n_rows(),
        timing: plan.base.timing,
        rate_out: plan.rate / plan.keep_every as f64,
        cutoff: plan.cutoff,
        cutoff_from: match plan.settings.cutoff {
            Cutoff::Auto => CutoffFrom::Motion,
            Cutoff::Hz(_) => CutoffFrom::Setting,
        },
        signals: signal_reports(raw, &even.columns, &dq),
        outliers: even.outliers,
        dq_lag,
        dq_gain,
        seen_elsewhere: Vec::new(),
        stuck: Vec::new(),
        delay: plan.settings.delay,
        trimmed: plan.trim as f64 / plan.rate,
    };
    Ok(Conditioned { motion, report })
}

fn signal_reports(raw: &Raw, even: &Raw, dq: &Mat<f64>) -> Vec<SignalReport> {
    let still: Vec<Vec<bool>> = (0..dq.ncols()).map(|j| standstill(dq.col_as_slice(j))).collect();
    let mut reports = Vec::new();
    for ((signal, raw_columns), (_, even_columns)) in raw.present().zip(even.present()) {
        for (joint, name) in raw.joints.iter().enumerate() {
            let noise = white_noise(&even_columns[joint], &still[joint]);
            let quantisation = quantisation(&raw_columns[joint]);
            let (signal, joint, at_ends) =
                (signal.name(), name.clone(), at_ends(&raw_columns[joint]));
            reports.push(SignalReport { signal, joint, noise, quantisation, at_ends });
        }
    }
    reports
}

/// Part of the values that equal the least or the largest, and runs of two and more of them.
fn at_ends(x: &[f64]) -> (f64, usize) {
    let [low, high] = [f64::min, f64::max].map(|pick| x.iter().copied().reduce(pick));
    let is_end = |x: &f64| Some(*x) == low || Some(*x) == high;
    let runs = x
        .chunk_by(|a, b| a.to_bits() == b.to_bits())
        .filter(|run| is_end(&run[0]) && run.len() > 1);
    (x.iter().filter(|x| is_end(x)).count() as f64 / x.len().max(1) as f64, runs.count())
}

/// Lag of each joint's measured velocity, on rows thinned out as far as the filter allows, and
/// Σ measured · derived / Σ derived² of their means over a little time, away from the ends.
fn lags_and_gains(
    dq: &Mat<f64>,
    filtered: &Raw,
    plan: &SignalPlan,
) -> (Vec<Option<Shift>>, Vec<Option<f64>>) {
    let every = keep_every(plan.cutoff, plan.rate);
    let rate = plan.rate / every as f64;
    let kept = plan.trim..dq.nrows().saturating_sub(plan.trim);
    let together = rows(SLOWLY * plan.rate / plan.cutoff).max(1);
    let means = |x: &[f64]| -> Vec<f64> {
        x.chunks(together).map(|x| x.iter().sum::<f64>() / x.len() as f64).collect()
    };
    let thin =
        |x: &[f64]| -> Vec<f64> { x.iter().step_by(every).take(LAG_ROWS).copied().collect() };
    let (mut lags, mut gains) = (Vec::new(), Vec::new());
    for (joint, measured) in filtered.of(Signal::Dq).iter().enumerate() {
        let derived = dq.col_as_slice(joint).get(kept.clone()).unwrap_or_default();
        let measured = measured.get(kept.clone()).unwrap_or_default();
        let late = || lag(&thin(derived), &thin(measured), rate, LONGEST_LAG);
        let (derived, measured) = (means(derived), means(measured));
        let square: f64 = derived.iter().map(|x| x * x).sum();
        let product: f64 = derived.iter().zip(&measured).map(|(d, m)| d * m).sum();
        let moves = square > STILL * STILL * derived.len() as f64;
        lags.push(moves.then(late).flatten());
        gains.push(moves.then(|| product / square).filter(|gain| gain.is_finite()));
    }
    (lags, gains)
}

#[cfg(test)]
mod tests;
