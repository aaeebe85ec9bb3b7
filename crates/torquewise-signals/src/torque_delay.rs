//! Motion → delay: how long the torque of a log lags its motion.

use crate::delay::{Shift, best_shift, shift};
use crate::error::SignalError;
use faer::linalg::solvers::{Llt, Solve};
use faer::{ColRef, Mat, Side};
use torquewise_motion::Motion;

/// Delays looked at \[s\], to both sides.
const RANGE: f64 = 0.06;
/// Step of the first look \[s\].
const RESOLUTION: f64 = 0.003;
/// A delay that lowers the error by less than this part is none.
const LEAST_GAIN: f64 = 0.01;
/// Ridge relative to the mean square of a column.
const RIDGE: f64 = 1e-6;
/// Fewer rows than this times the columns say nothing of a delay.
const ROWS_PER_COLUMN: usize = 5;
/// Rows looked at; neighbours are alike.
const MOST_ROWS: usize = 8_000;

/// The lag of torque behind motion that a rough model of the arm is least wrong with.
///
/// The model of a joint is linear in 1, its own velocity and the sign of it, all accelerations, and
/// sines and cosines of the angles of each joint and of each two neighbours together: enough to
/// tell a lag, whatever the arm. A lag counts for all joints.
///
/// - `motion`: conditioned and evenly sampled, with torque
/// - returns: seconds by which the torque lags; `None` if no lag explains the torque clearly better
///   than none, or there is too little motion to tell
///
/// # Errors
/// [`SignalError::Motion`] if the motion holds no torque.
pub fn torque_delay(motion: &Motion) -> Result<Option<Shift>, SignalError> {
    let tau = motion.require_tau()?;
    let (m, n) = (motion.n_rows(), motion.n_joints());
    let common = 3 * n + 2 * n.saturating_sub(1);
    if m < ROWS_PER_COLUMN * (common + 3) {
        return Ok(None);
    }
    let rows = m.min(MOST_ROWS);
    let rate = (rows - 1) as f64 / (motion.t()[rows - 1] - motion.t()[0]);
    // Rows at the ends miss their neighbours once shifted.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bounded")]
    let margin = (RANGE * rate).ceil().clamp(0.0, rows as f64 / 4.0) as usize;
    let models: Vec<Rough> =
        (0..n).filter_map(|joint| Rough::new(motion, joint, rows, margin)).collect();
    let torque = |joint: usize| tau.col(joint).iter().take(rows).copied().collect::<Vec<f64>>();
    let torques: Vec<Vec<f64>> = models.iter().map(|model| torque(model.joint)).collect();
    let error = |seconds: f64| {
        let parts = models.iter().zip(&torques);
        parts.map(|(model, tau)| model.error(&shift(tau, rate, seconds))).sum::<f64>()
    };
    let none = error(0.0);
    let best = best_shift(error, -RANGE..=RANGE, RESOLUTION)?;
    let gain = 0.5 * (none - best.error) / models.len().max(1) as f64;
    Ok((!models.is_empty() && !best.at_end && gain > LEAST_GAIN).then_some(best))
}

/// A rough linear model of one joint.
struct Rough {
    joint: usize,
    margin: usize,
    columns: Mat<f64>,
    factor: Llt<f64>,
}

impl Rough {
    /// `None` for a joint that does not move.
    fn new(motion: &Motion, joint: usize, rows: usize, margin: usize) -> Option<Self> {
        let n = motion.n_joints();
        let (q, dq, ddq) = (motion.q(), motion.dq(), motion.ddq());
        let peak = dq.col(joint).iter().fold(0.0_f64, |peak, dq| peak.max(dq.abs()));
        if peak <= 0.0 {
            return None;
        }
        let count = rows - 2 * margin;
        let mut all: Vec<Vec<f64>> = Vec::new();
        let mut add = |value: &dyn Fn(usize) -> f64| {
            all.push((margin..margin + count).map(value).collect());
        };
        add(&|_| 1.0);
        add(&|row| dq[(row, joint)]);
        add(&|row| (dq[(row, joint)] / (0.02 * peak)).tanh());
        for k in 0..n {
            add(&|row| ddq[(row, k)]);
            add(&|row| q[(row, k)].sin());
            add(&|row| q[(row, k)].cos());
            if k > 0 {
                add(&|row| (q[(row, k - 1)] + q[(row, k)]).sin());
                add(&|row| (q[(row, k - 1)] + q[(row, k)]).cos());
            }
        }
        let columns = Mat::from_fn(count, all.len(), |row, column| all[column][row]);
        let mut gram = columns.transpose() * &columns;
        let mean = (0..all.len()).map(|j| gram[(j, j)]).sum::<f64>() / all.len() as f64;
        for j in 0..all.len() {
            gram[(j, j)] += RIDGE * mean;
        }
        let factor = gram.llt(Side::Lower).ok()?;
        Some(Self { joint, margin, columns, factor })
    }

    /// Logarithm of the mean square that the model leaves of a torque.
    fn error(&self, tau: &[f64]) -> f64 {
        let tau = &tau[self.margin..self.margin + self.columns.nrows()];
        let weights = self.factor.solve(self.columns.transpose() * ColRef::from_slice(tau));
        let fitted = &self.columns * &weights;
        let squares: f64 = tau.iter().zip(fitted.iter()).map(|(a, b)| (a - b).powi(2)).sum();
        (squares / tau.len() as f64).max(f64::MIN_POSITIVE).ln()
    }
}

#[cfg(test)]
mod tests {
    use super::torque_delay;
    use faer::Mat;
    use torquewise_motion::{Motion, Signals};

    /// Two joints driven by three sines each; the torque is that of `lag` seconds ago.
    fn motion(lag: f64) -> Motion {
        let t: Vec<f64> = (0..3_000).map(|row| 0.005 * f64::from(row)).collect();
        // Of a single sine, a lag and a little more friction look the same: three make a motion.
        let wave = |t: f64, joint: usize, order: i32| -> f64 {
            let parts = [(0.9, 1.3), (0.5, 3.1), (0.3, 5.9)].into_iter().enumerate();
            let part = |(k, (size, rate)): (usize, (f64, f64))| {
                let rate = rate + 0.7 * joint as f64;
                let angle = rate * t + k as f64 + f64::from(order) * std::f64::consts::FRAC_PI_2;
                size * rate.powi(order) * angle.sin()
            };
            parts.map(part).sum()
        };
        let of = |order| Mat::from_fn(t.len(), 2, |row, joint| wave(t[row], joint, order));
        let tau = Mat::from_fn(t.len(), 2, |row, joint| {
            let then = t[row] - lag;
            let [q, dq, ddq] = [0, 1, 2].map(|order| wave(then, joint, order));
            0.3 * ddq + 4.0 * q.sin() + 0.5 * dq + 0.05 * (137.0 * row as f64).sin()
        });
        Motion::new(Signals {
            joints: vec!["hip".into(), "knee".into()],
            q: of(0),
            dq: of(1),
            ddq: of(2),
            tau: Some(tau),
            t,
        })
        .unwrap()
    }

    #[test]
    fn a_lag_is_found_to_a_fifth_of_a_sample() {
        for lag in [0.013, -0.02, 0.004] {
            let found = torque_delay(&motion(lag)).unwrap().unwrap();
            assert!((found.seconds - lag).abs() < 1e-3, "{lag}: {found:?}");
        }
    }

    #[test]
    fn no_lag_is_no_lag() {
        assert_eq!(torque_delay(&motion(0.0)).unwrap(), None);
    }
}
