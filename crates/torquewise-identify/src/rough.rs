//! A rough linear model of each joint, good for any arm: does its torque follow its motion?

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use torquewise_motion::Motion;
use torquewise_stepwise::survey::thinned;

/// Rows that are fitted.
const ROWS: usize = 2_000;
/// Fewer rows than this times the columns are too few.
const ROWS_PER_COLUMN: usize = 20;
/// Ridge on columns of unit length.
const RIDGE: f64 = 1e-8;
/// Dry friction is smooth below this part of the peak speed.
const SLOW: f64 = 0.02;

/// Part of the deviation of the torque of a joint that a linear model leaves: of 1, its speed and
/// the sign of it, all accelerations, and sines and cosines of each angle, twice each angle and each
/// two neighbours together.
///
/// `None` for a joint at rest, or if there are too few rows.
pub(crate) fn unexplained_part(motion: &Motion, joint: usize) -> Option<f64> {
    let motion = thinned(motion, ROWS);
    let tau = motion.tau()?;
    let tau = Mat::from_fn(motion.n_rows(), 1, |row, _| tau[(row, joint)]);
    let mut columns = columns(&motion, joint)?;
    let (m, p) = (columns.nrows(), columns.ncols());
    if m < ROWS_PER_COLUMN * p {
        return None;
    }
    for column in columns.col_iter_mut() {
        let length = column.norm_l2().max(f64::MIN_POSITIVE);
        column.iter_mut().for_each(|x| *x /= length);
    }
    let mut gram = columns.transpose() * &columns;
    (0..p).for_each(|k| gram[(k, k)] += RIDGE);
    let fitted = &columns * gram.llt(Side::Lower).ok()?.solve(columns.transpose() * &tau);
    let mean = tau.sum() / m as f64;
    let variance = (tau.squared_norm_l2() / m as f64 - mean * mean).max(f64::MIN_POSITIVE);
    Some(((&tau - fitted).squared_norm_l2() / m as f64 / variance).sqrt())
}

/// The regressors of that model, m×p; `None` for a joint at rest.
fn columns(motion: &Motion, joint: usize) -> Option<Mat<f64>> {
    let (q, dq, ddq) = (motion.q(), motion.dq(), motion.ddq());
    let peak = dq.col(joint).iter().fold(0.0_f64, |peak, dq| peak.max(dq.abs()));
    let (m, n) = (motion.n_rows(), motion.n_joints());
    if peak <= 0.0 {
        return None;
    }
    let row = |row: usize| -> Vec<f64> {
        let own = dq[(row, joint)];
        let mut values = vec![1.0, own, (own / (SLOW * peak)).tanh()];
        values.extend((0..n).map(|k| ddq[(row, k)]));
        for k in 0..n {
            let before = k.checked_sub(1).map(|before| q[(row, before)] + q[(row, k)]);
            for angle in [q[(row, k)], 2.0 * q[(row, k)]].into_iter().chain(before) {
                values.extend([angle.sin(), angle.cos()]);
            }
        }
        values
    };
    let rows: Vec<Vec<f64>> = (0..m).map(row).collect();
    let p = rows.first()?.len();
    Some(Mat::from_fn(m, p, |row, k| rows[row][k]))
}
