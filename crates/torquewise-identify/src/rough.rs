//! A rough linear model of each joint, good for any arm: does its torque follow its motion, and show
//! its friction?

use crate::spread;
use faer::linalg::solvers::Solve;
use faer::{Col, ColRef, Mat, Side};
use torquewise_motion::Motion;
use torquewise_stepwise::thinned;

/// Rows that are fitted.
const ROWS: usize = 2_000;
/// Fewer rows than this times the columns are too few.
const ROWS_PER_COLUMN: usize = 20;
/// Ridge on columns of unit length.
const RIDGE: f64 = 1e-8;
/// Dry friction is smooth below this part of the peak speed.
const SLOW: f64 = 0.02;

/// Friction that lowers what is left of a torque by this part is seen in it: on public logs what is no
/// friction lowers it by 6 % at most. It saves the tests of signs a third of the time of a TIAGo's fit.
const SEEN: f64 = 0.2;

/// Part of the deviation of the torque of a joint that a linear model leaves: of 1, its speed and
/// the sign of it, all accelerations, and sines and cosines of each angle, twice each angle and each
/// two neighbours together.
///
/// `None` for a joint at rest, or if there are too few rows.
pub(crate) fn unexplained_part(motion: &Motion, joint: usize) -> Option<f64> {
    let motion = thinned(motion, ROWS);
    Some(fit(&motion, joint, &friction(&motion, joint)?)?.0)
}

/// Joints whose torque does not show the friction of their own shaft, more than that of any other and
/// against the motion: it may be another joint's, or of the wrong sign. Not one that never changes.
pub(crate) fn doubtful(motion: &Motion) -> Vec<usize> {
    let motion = thinned(motion, ROWS);
    let n = motion.n_joints();
    let frictions: Vec<_> = (0..n).map(|joint| friction(&motion, joint)).collect();
    let is_seen = |joint: usize| -> Option<bool> {
        let without = fit(&motion, joint, &[])?.0;
        let own = frictions[joint].as_ref()?;
        let (left, coefficients) = fit(&motion, joint, own)?;
        let load =
            |row: usize| -> f64 { own.iter().zip(&coefficients).map(|(x, b)| x[row] * b).sum() };
        let load = Col::from_fn(motion.n_rows(), load);
        let power: f64 = own[0].iter().zip(load.iter()).map(|(dq, load)| load * dq).sum();
        // What is larger than the torque is what columns that are alike make up between them.
        let is_friction = spread(load.as_ref()) <= spread(motion.tau()?.col(joint));
        let others = (0..n).filter(|other| *other != joint);
        let with_others =
            others.filter_map(|other| fit(&motion, joint, frictions[other].as_ref()?));
        let least = with_others.map(|(left, _)| left).fold((1.0 - SEEN) * without, f64::min);
        Some(left < least && power > 0.0 && is_friction)
    };
    let changes = |joint: usize| {
        let is_other = |tau: ColRef<'_, f64>| tau.iter().any(|own| (own - tau[0]).abs() > 0.0);
        motion.tau().is_some_and(|tau| is_other(tau.col(joint)))
    };
    let is_told = |joint: usize| !changes(joint) || is_seen(joint).unwrap_or(false);
    (0..n).filter(|&joint| !is_told(joint)).collect()
}

/// Speed of a joint and the sign of it, m each; `None` for a joint at rest.
fn friction(motion: &Motion, joint: usize) -> Option<[Vec<f64>; 2]> {
    let dq: Vec<f64> = motion.dq().col(joint).iter().copied().collect();
    let peak = dq.iter().fold(0.0_f64, |peak, dq| peak.max(dq.abs()));
    let sign = dq.iter().map(|dq| (dq / (SLOW * peak)).tanh()).collect();
    (peak > 0.0).then_some([dq, sign])
}

/// The part of the deviation of a joint's torque that is left, and the coefficients of `friction`.
fn fit(motion: &Motion, joint: usize, friction: &[Vec<f64>]) -> Option<(f64, Vec<f64>)> {
    let tau = motion.tau()?;
    let tau = Mat::from_fn(motion.n_rows(), 1, |row, _| tau[(row, joint)]);
    let mut columns = columns(motion, friction);
    let (m, p) = (columns.nrows(), columns.ncols());
    if m < ROWS_PER_COLUMN * p {
        return None;
    }
    let length = |column: ColRef<'_, f64>| column.norm_l2().max(f64::MIN_POSITIVE);
    let lengths: Vec<f64> = columns.col_iter().map(length).collect();
    for (column, length) in columns.col_iter_mut().zip(&lengths) {
        column.iter_mut().for_each(|x| *x /= length);
    }
    let mut gram = columns.transpose() * &columns;
    (0..p).for_each(|k| gram[(k, k)] += RIDGE);
    let coefficients = gram.llt(Side::Lower).ok()?.solve(columns.transpose() * &tau);
    let fitted = &columns * &coefficients;
    let mean = tau.sum() / m as f64;
    let variance = (tau.squared_norm_l2() / m as f64 - mean * mean).max(f64::MIN_POSITIVE);
    let left = ((&tau - fitted).squared_norm_l2() / m as f64 / variance).sqrt();
    Some((left, (0..friction.len()).map(|k| coefficients[(k, 0)] / lengths[k]).collect()))
}

/// The regressors of that model, friction first, m×p.
fn columns(motion: &Motion, friction: &[Vec<f64>]) -> Mat<f64> {
    let (q, ddq, n) = (motion.q(), motion.ddq(), motion.n_joints());
    let row = |row: usize| -> Vec<f64> {
        let mut values: Vec<f64> = friction.iter().map(|x| x[row]).collect();
        values.push(1.0);
        values.extend((0..n).map(|k| ddq[(row, k)]));
        for k in 0..n {
            let before = k.checked_sub(1).map(|before| q[(row, before)] + q[(row, k)]);
            for angle in [q[(row, k)], 2.0 * q[(row, k)]].into_iter().chain(before) {
                values.extend([angle.sin(), angle.cos()]);
            }
        }
        values
    };
    let rows: Vec<Vec<f64>> = (0..motion.n_rows()).map(row).collect();
    Mat::from_fn(rows.len(), rows.first().map_or(0, Vec::len), |row, k| rows[row][k])
}
