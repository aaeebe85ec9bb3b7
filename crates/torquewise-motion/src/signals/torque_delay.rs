//! From Raw to delay: how long the torque of a log lags its motion.

use crate::MotionError;
use crate::signals::butterworth::low_pass;
use crate::signals::delay::{Shift, best_shift, shift};
use crate::signals::plan::Plan;
use crate::signals::raw::Raw;
use crate::signals::settings::Conditioning;
use crate::signals::smooth::{Smooth, filter, smooth};
use crate::signals::zero_phase::filtfilt;
use faer::Mat;

mod rough;
mod folds;

use folds::{FOLDS, Folds};
use rough::{Detail, friction, n_rigid, rigid};

/// Delays looked at \[s\], to both sides.
const RANGE: f64 = 0.06;
/// Step of the first look \[s\].
const RESOLUTION: f64 = 0.003;
/// A delay that lowers the error of held-out rows by less than this part is none.
const LEAST_GAIN: f64 = 0.01;
/// Nor is one whose gain is less than this many standard errors over the blocks.
const LEAST_CERTAINTY: f64 = 2.0;
/// Nor one that is less than this many of its own standard errors.
const LEAST_SIGNIFICANCE: f64 = 2.0;
/// Ridge relative to the mean square of a column.
const RIDGE: f64 = 1e-5;
/// Fewer rows than this times the columns do not carry a model.
const ROWS_PER_COLUMN: usize = 5;
/// Rows and columns looked at: enough to tell a delay, and few enough to be quick.
const MOST_ROWS: usize = 8_000;
const MOST_COLUMNS: usize = 500;

/// The lag of torque behind motion that a rough model of the arm predicts held-out rows best with.
///
/// Rigid bodies return the same torque when a motion runs backwards in time; friction the opposite
/// one, and so does the trace of a delay, τ̇ times the delay. What the model lacks of friction can
/// therefore pass for a delay, what it lacks of rigid bodies cannot, but for chance. So any
/// friction that depends on its own velocity is fitted: as a sum of smooth signs of five widths
/// that pass the low-pass filter which the torque passed. Inertia, Coriolis torque and gravity are
/// linear in sines and cosines of angles, as finely as the rows allow. A lag counts for all joints.
///
/// - `raw`: a trajectory with torque, or its first part; `settings`: how it is to be conditioned
/// - returns: seconds by which the torque lags, beyond the delay of the settings; `None` if no lag
///   predicts blocks of time that were held out clearly better than none, if it is within two of
///   its standard errors, or if there is too little motion to tell
///
/// # Errors
/// Those of [`condition`](crate::signals::condition()), and [`MotionError::Unmeasured`] without torque.
pub fn torque_delay(raw: &Raw, settings: &Conditioning) -> Result<Option<Shift>, MotionError> {
    let columns = raw.columns()?;
    let (plan, even) = Plan::with_even(&columns, settings)?;
    plan.check(&even.columns)?;
    let smooth = smooth(&filter(&even, &plan)?, even.first, &plan)?;
    let Some(seen) = Seen::of(&smooth, &plan)? else { return Ok(None) };
    let Some(model) = seen.model() else { return Ok(None) };
    let errors = |seconds: f64| model.errors(&seen.torque(seconds));
    let best = best_shift(|seconds| total(&errors(seconds)), -RANGE..=RANGE, RESOLUTION)?;
    let gains = gains(&errors(0.0), &errors(best.seconds));
    let around = [-RESOLUTION, 0.0, RESOLUTION].map(|off| errors(best.seconds + off));
    let is_sharp = best.seconds.abs() > LEAST_SIGNIFICANCE * standard_error(&around);
    Ok((!best.at_end && is_clear(&gains) && is_sharp).then_some(best))
}

/// How well the blocks agree on the shift \[s\], by the jackknife: slopes of their errors at the
/// best shift over the bend of all.
///
/// - `around`: errors a step before the best shift, there, and a step after
fn standard_error(around: &[Vec<Vec<f64>>; 3]) -> f64 {
    let [before, at, after] = around.each_ref().map(|errors| {
        let log = |fold: &Vec<f64>| fold.iter().map(|error| error.ln()).sum::<f64>();
        errors.iter().map(log).collect::<Vec<f64>>()
    });
    let (mut slopes, mut bend) = (0.0, 0.0);
    for ((before, at), after) in before.iter().zip(&at).zip(&after) {
        slopes += ((after - before) / (2.0 * RESOLUTION)).powi(2);
        bend += (after - 2.0 * at + before) / RESOLUTION.powi(2);
    }
    let folds = FOLDS as f64;
    let error = (folds / (folds - 1.0) * slopes).sqrt() / bend;
    // Bent the other way, the blocks agree on nothing.
    if error >= 0.0 { error } else { f64::INFINITY }
}

/// Logarithms of the mean squares of all joints, summed.
fn total(errors: &[Vec<f64>]) -> f64 {
    let joints = errors.first().map_or(0, Vec::len);
    let of_joint = |joint: usize| errors.iter().map(|fold| fold[joint]).sum::<f64>();
    (0..joints).map(|joint| of_joint(joint).max(f64::MIN_POSITIVE).ln()).sum()
}

/// What each block gains by a shift: the part by which its error falls, mean of the joints.
fn gains(none: &[Vec<f64>], best: &[Vec<f64>]) -> [f64; FOLDS] {
    std::array::from_fn(|fold| {
        let parts = none[fold].iter().zip(&best[fold]);
        let parts = parts.map(|(none, best)| 0.5 * (none / best).ln());
        parts.sum::<f64>() / none[fold].len() as f64
    })
}

/// Whether blocks agree that there is something to gain.
fn is_clear(gains: &[f64; FOLDS]) -> bool {
    let folds = FOLDS as f64;
    let mean = gains.iter().sum::<f64>() / folds;
    let variance = gains.iter().map(|gain| (gain - mean).powi(2)).sum::<f64>() / (folds - 1.0);
    mean > LEAST_GAIN && mean > LEAST_CERTAINTY * (variance / folds).sqrt()
}

/// Rows that can be looked at, torques of moving joints and what they may follow from.
struct Seen {
    rate: f64,
    /// Rows at each end that miss their neighbours once shifted.
    margin: usize,
    /// Signals at all rows, joint by joint; torque of the joints that move.
    q: Mat<f64>,
    dq: Mat<f64>,
    ddq: Mat<f64>,
    tau: Vec<Vec<f64>>,
    /// Filtered columns of friction of all joints.
    friction: Vec<Vec<f64>>,
}

impl Seen {
    /// `None` if nothing moves.
    fn of(smooth: &Smooth, plan: &Plan) -> Result<Option<Self>, MotionError> {
        let missing = MotionError::Unmeasured { what: "the delay of the torque", signal: "tau" };
        let tau = smooth.tau.as_ref().ok_or(missing)?;
        let every = plan.keep_every_for_lag();
        let (trim, m) = (plan.trim, smooth.dq.nrows());
        let rows: Vec<usize> =
            (trim..m.saturating_sub(trim)).step_by(every).take(MOST_ROWS).collect();
        let sections = plan.cutoff.map(|cutoff| low_pass(plan.settings.order, cutoff, plan.rate));
        let sections = sections.transpose()?;
        let (mut torques, mut rubbing) = (Vec::new(), Vec::new());
        let thin = |x: &[f64]| -> Vec<f64> { rows.iter().map(|&row| x[row]).collect() };
        for joint in 0..smooth.dq.ncols() {
            let columns = friction(smooth.dq.col_as_slice(joint));
            if !columns.is_empty() {
                torques.push(thin(tau.col_as_slice(joint)));
            }
            for mut column in columns {
                if let Some(sections) = &sections {
                    filtfilt(sections, &mut column)?;
                }
                rubbing.push(thin(&column));
            }
        }
        let pick = |x: &Mat<f64>| Mat::from_fn(rows.len(), x.ncols(), |row, j| x[(rows[row], j)]);
        let rate = plan.rate / every as f64;
        // Rows at the ends miss their neighbours once shifted.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bounded")]
        let margin = (RANGE * rate).ceil().clamp(0.0, rows.len() as f64 / 4.0) as usize;
        let [q, dq, ddq] = [&smooth.q, &smooth.dq, &smooth.ddq].map(pick);
        let seen = Self { rate, margin, q, dq, ddq, tau: torques, friction: rubbing };
        Ok((!seen.tau.is_empty()).then_some(seen))
    }

    /// The finest model that the rows carry.
    fn model(&self) -> Option<Folds> {
        let kept = self.margin..self.q.nrows() - self.margin;
        let (m, n) = (kept.len(), self.q.ncols());
        let carries = |detail: &Detail| {
            let columns = n_rigid(n, *detail) + self.friction.len();
            columns <= MOST_COLUMNS && columns * ROWS_PER_COLUMN <= m
        };
        let detail = Detail::ALL.into_iter().rfind(carries)?;
        let mut columns = rigid(&self.q, &self.dq, &self.ddq, detail);
        columns.extend(self.friction.iter().cloned());
        let columns: Vec<Vec<f64>> =
            columns.iter().map(|column| column[kept.clone()].to_vec()).collect();
        Folds::new(&columns, RIDGE)
    }

    /// Torques advanced by a time, without the rows at the ends.
    fn torque(&self, seconds: f64) -> Mat<f64> {
        let shifted: Vec<Vec<f64>> =
            self.tau.iter().map(|tau| shift(tau, self.rate, seconds)).collect();
        let rows = self.q.nrows() - 2 * self.margin;
        Mat::from_fn(rows, shifted.len(), |row, joint| shifted[joint][row + self.margin])
    }
}

#[cfg(test)]
mod tests;
