//! A chain, motion → what it leaves of a torque on blocks of time that it was not fitted on.

use crate::estimate::Linearisation;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use std::ops::Range;
use torquewise_motion::Motion;
use torquewise_survey::error::IdentifyError;

/// Blocks of time, each held out once: many, since few agree by chance.
pub(crate) const BLOCKS: usize = 24;
/// Rows that a block needs.
const LEAST_ROWS: usize = 4;
/// Ridges, relative to the square of a column: the best one counts.
const RIDGES: [f64; 4] = [1e-8, 1e-6, 1e-4, 1e-2];
/// A column whose square is a smaller part of the largest is held as if it were of this size.
const LEAST_SQUARE: f64 = 1e-9;

/// What a chain leaves of a torque on blocks of time that it was not fitted on.
#[derive(Clone, Debug)]
pub(crate) struct Errors {
    /// Mean squares over the variance of the torque, blocks by joints.
    parts: Vec<Vec<f64>>,
    /// Standard deviation of the torque of each joint \[N·m\], n.
    spread: Vec<f64>,
}

impl Errors {
    /// RMSE over standard deviation of each joint, n.
    fn by_joint(&self) -> Vec<f64> {
        let joints = self.parts.first().map_or(0, Vec::len);
        let mean =
            |joint: usize| self.parts.iter().map(|block| block[joint]).sum::<f64>() / BLOCKS as f64;
        (0..joints).map(|joint| mean(joint).sqrt()).collect()
    }

    /// RMSE of each joint \[N·m\], n.
    pub(crate) fn rms_by_joint(&self) -> Vec<f64> {
        self.by_joint().iter().zip(&self.spread).map(|(part, spread)| part * spread).collect()
    }

    /// The geometric mean of the joints.
    pub(crate) fn all(&self) -> f64 {
        geometric_mean(&self.by_joint())
    }

    pub(crate) fn by_block(&self) -> Vec<f64> {
        let roots = |block: &Vec<f64>| block.iter().map(|square| square.sqrt()).collect::<Vec<_>>();
        self.parts.iter().map(|block| geometric_mean(&roots(block))).collect()
    }
}

/// The geometric mean of positive numbers.
pub(crate) fn geometric_mean(x: &[f64]) -> f64 {
    let logs: f64 = x.iter().map(|x| x.max(f64::MIN_POSITIVE).ln()).sum();
    (logs / x.len().max(1) as f64).exp()
}

/// What the parameters of a chain, fitted to the torque of a motion but for one block of time and
/// its neighbours, leave of a target in that block. The geometry takes one step.
///
/// - `target`: \[N·m\], m×n
/// - returns: `None` where there are too few rows, or nothing can be solved
///
/// # Errors
/// [`IdentifyError::Chain`] if the motion is of another arm.
pub(crate) fn held_out(
    at: &Linearisation,
    motion: &Motion,
    target: &Mat<f64>,
) -> Result<Option<Errors>, IdentifyError> {
    let (m, n) = (motion.n_rows(), motion.n_joints());
    if m < BLOCKS * LEAST_ROWS {
        return Ok(None);
    }
    let (columns, weights) = at.columns_of(motion)?;
    let tau = motion.require_tau()?;
    let p = columns.ncols();
    let range = |block: usize| block * m / BLOCKS..(block + 1) * m / BLOCKS;
    let rows = |block: Range<usize>, joint: usize| {
        columns.submatrix(joint * m + block.start, 0, block.len(), p)
    };
    let sums = |block: Range<usize>| {
        let (mut gram, mut right) = (Mat::<f64>::zeros(p, p), Mat::<f64>::zeros(p, 1));
        for joint in 0..n {
            let own = rows(block.clone(), joint);
            let response = Mat::from_fn(own.nrows(), 1, |row, _| {
                let row = block.start + row;
                weights[joint * m + row] * tau[(row, joint)]
            });
            gram += own.transpose() * own;
            right += own.transpose() * response;
        }
        (gram, right)
    };
    let (gram, right) = sums(0..m);
    // The filter carries the torque of a block to its neighbours.
    let around =
        |block: usize| range(block.saturating_sub(1)).start..range((block + 1).min(BLOCKS - 1)).end;
    let blocks: Vec<(Mat<f64>, Mat<f64>)> = (0..BLOCKS).map(|block| sums(around(block))).collect();
    let spread: Vec<f64> = (0..n).map(|joint| variance(target, joint)).collect();
    let largest = (0..p).fold(0.0_f64, |most, k| gram[(k, k)].max(most));
    let parts = |ridge: f64| -> Option<Vec<Vec<f64>>> {
        let own = |k: usize| ridge * gram[(k, k)].max(LEAST_SQUARE * largest);
        let of_block = |(block, (own_gram, own_right)): (usize, &(Mat<f64>, Mat<f64>))| {
            let mut rest = &gram - own_gram;
            (0..p).for_each(|k| rest[(k, k)] += own(k));
            let solved = rest.llt(Side::Lower).ok()?.solve(&right - own_right);
            let left = |joint: usize| {
                let fitted = rows(range(block), joint) * &solved;
                let squares = range(block).enumerate().map(|(k, row)| {
                    (target[(row, joint)] - fitted[(k, 0)] / weights[joint * m + row]).powi(2)
                });
                squares.sum::<f64>() / range(block).len() as f64 / spread[joint]
            };
            Some((0..n).map(left).collect())
        };
        blocks.iter().enumerate().map(of_block).collect()
    };
    let roots: Vec<f64> = spread.iter().map(|variance| variance.sqrt()).collect();
    let of = |ridge: &f64| Some(Errors { parts: parts(*ridge)?, spread: roots.clone() });
    let found = RIDGES.iter().filter_map(of);
    Ok(found.min_by(|a, b| a.all().total_cmp(&b.all())))
}

fn variance(x: &Mat<f64>, column: usize) -> f64 {
    let m = x.nrows() as f64;
    let mean = x.col(column).sum() / m;
    let squares: f64 = x.col(column).iter().map(|x| (x - mean).powi(2)).sum();
    (squares / m).max(f64::MIN_POSITIVE)
}
