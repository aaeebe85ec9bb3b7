//! From sample of a log to rough model of each joint: does its torque follow its motion, and which
//! way?

use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, Side};
use torquewise_motion::Motion;
use torquewise_stepwise::survey::thinned;

/// What a linear model of one joint, good for any arm, says of its torque.
#[derive(Clone, Copy, Debug)]
pub struct Rough {
    /// Part of the deviation of the torque that the model leaves.
    pub left: f64,
    /// Torque per acceleration of the joint itself \[kg·m²\].
    pub inertia: f64,
    /// Part of the variance of the torque that this alone explains.
    pub inertia_share: f64,
    /// Power of viscous and dry friction over the power of the whole torque, rms times rms.
    pub friction_power: f64,
}

/// Rows that tell.
const ROWS: usize = 2_000;
/// Fewer rows than this times the columns tell nothing.
const ROWS_PER_COLUMN: usize = 20;
/// Ridge on columns of unit length.
const RIDGE: f64 = 1e-8;
/// Dry friction is smooth below this part of the peak speed.
const SLOW: f64 = 0.02;

/// τ of a joint by 1, its speed and the sign of it, all accelerations, and sines and cosines of
/// each angle, twice each angle and each two neighbours together.
///
/// `None` for a joint at rest, or if there are too few rows.
pub fn rough(motion: &Motion, joint: usize) -> Option<Rough> {
    let motion = thinned(motion, ROWS);
    let tau: Vec<f64> = motion.tau()?.col(joint).iter().copied().collect();
    let columns = columns(&motion, joint)?;
    let (m, p) = (columns.nrows(), columns.ncols());
    if m < ROWS_PER_COLUMN * p {
        return None;
    }
    let normal = Normal::new(columns.transpose() * &columns, RIDGE)?;
    let tau = Mat::from_fn(m, 1, |row, _| tau[row]);
    let moments = columns.transpose() * &tau;
    let scaled = normal.scaled(&moments);
    let weights = normal.unscaled(&scaled);
    let fitted = &columns * &weights;
    let mean = tau.sum() / m as f64;
    let variance = (tau.squared_norm_l2() / m as f64 - mean * mean).max(f64::MIN_POSITIVE);
    let own = 3 + joint;
    let reach = normal.factor.solve(Mat::from_fn(p, 1, |k, _| f64::from(u8::from(k == own))));
    let power = |k: usize| -> f64 {
        (0..m).map(|row| weights[(k, 0)] * columns[(row, k)] * columns[(row, 1)]).sum()
    };
    let whole = (variance * m as f64).sqrt() * normal.size[1];
    Some(Rough {
        left: ((&tau - fitted).squared_norm_l2() / m as f64 / variance).sqrt(),
        inertia: weights[(own, 0)],
        inertia_share: scaled[(own, 0)].powi(2) / reach[(own, 0)] / (m as f64 * variance),
        friction_power: (power(1) + power(2)) / whole,
    })
}

/// Normal equations on columns of unit length, with a small ridge.
pub struct Normal {
    /// Lengths of the columns.
    size: Vec<f64>,
    factor: Llt<f64>,
}

impl Normal {
    /// `None` if they are singular.
    pub fn new(mut gram: Mat<f64>, ridge: f64) -> Option<Self> {
        let p = gram.ncols();
        let size: Vec<f64> = (0..p).map(|k| gram[(k, k)].sqrt().max(f64::MIN_POSITIVE)).collect();
        for j in 0..p {
            for i in 0..p {
                gram[(i, j)] /= size[i] * size[j];
            }
            gram[(j, j)] += ridge;
        }
        let factor = gram.llt(Side::Lower).ok()?;
        Some(Self { size, factor })
    }

    /// Weights of the columns as they are.
    pub fn solve(&self, moments: &Mat<f64>) -> Mat<f64> {
        self.unscaled(&self.scaled(moments))
    }

    /// Weights of columns of unit length.
    fn scaled(&self, moments: &Mat<f64>) -> Mat<f64> {
        let p = self.size.len();
        self.factor.solve(Mat::from_fn(p, 1, |k, _| moments[(k, 0)] / self.size[k]))
    }

    fn unscaled(&self, scaled: &Mat<f64>) -> Mat<f64> {
        Mat::from_fn(self.size.len(), 1, |k, _| scaled[(k, 0)] / self.size[k])
    }
}

/// The regressors of that model, m×p; `None` for a joint at rest.
pub fn columns(motion: &Motion, joint: usize) -> Option<Mat<f64>> {
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
