//! From a chain, motion to what it leaves of a torque on blocks of time that it was not fitted on.

use crate::estimate::Linearisation;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use std::ops::Range;
use torquewise_motion::Motion;
use torquewise_stepwise::error::IdentifyError;

/// Blocks of time, each held out once: many, since few agree by chance.
pub(crate) const BLOCKS: usize = 24;
/// So many logs tell, whole ones held out, what others like them would: of two that show different
/// joints each is needed.
const LEAST_LOGS: usize = 4;
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
    /// Share of each block in the rows.
    shares: Vec<f64>,
    /// Standard deviation of the torque of each joint \[N·m\], n.
    spread: Vec<f64>,
}

impl Errors {
    /// RMSE over standard deviation of each joint, n.
    fn by_joint(&self) -> Vec<f64> {
        let joints = self.parts.first().map_or(0, Vec::len);
        let mean = |joint: usize| -> f64 {
            self.parts.iter().zip(&self.shares).map(|(block, share)| share * block[joint]).sum()
        };
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

/// Rows that are held out together, and those around them that are not fitted on.
pub(crate) struct HeldOut {
    rows: Range<usize>,
    around: Range<usize>,
}

/// Blocks of time of a motion with their neighbours: the filter carries torque there.
pub(crate) fn even_blocks(motion: &Motion) -> Vec<HeldOut> {
    let edge = |block: usize| block * motion.n_rows() / BLOCKS;
    let around = |block: usize| edge(block.saturating_sub(1))..edge((block + 2).min(BLOCKS));
    (0..BLOCKS).map(|k| HeldOut { rows: edge(k)..edge(k + 1), around: around(k) }).collect()
}

/// Whole logs where there are four or more, of very many some together; blocks of time of fewer.
///
/// A log begins where time does not go on.
pub(crate) fn whole_logs(motion: &Motion) -> Vec<HeldOut> {
    let t = motion.t();
    let begins: Vec<usize> = (1..t.len()).filter(|&row| t[row] <= t[row - 1]).collect();
    if begins.len() + 1 < LEAST_LOGS {
        return even_blocks(motion);
    }
    let edges: Vec<usize> =
        std::iter::once(0).chain(begins).chain(std::iter::once(t.len())).collect();
    let logs = edges.len() - 1;
    let groups = logs.min(BLOCKS);
    let edge = |group: usize| edges[group * logs / groups];
    let rows = (0..groups).map(|group| edge(group)..edge(group + 1));
    rows.map(|rows| HeldOut { around: rows.clone(), rows }).collect()
}

/// What the parameters of a chain, fitted to the torque of a motion but for a block of rows and
/// those around it, leave of a target in that block. The geometry takes one step.
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
    blocks: &[HeldOut],
) -> Result<Option<Errors>, IdentifyError> {
    let (m, n) = (motion.n_rows(), motion.n_joints());
    if m < BLOCKS * LEAST_ROWS {
        return Ok(None);
    }
    let (columns, weights) = at.columns_of(motion)?;
    let tau = motion.require_tau()?;
    let p = columns.ncols();
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
    let around: Vec<(Mat<f64>, Mat<f64>)> =
        blocks.iter().map(|block| sums(block.around.clone())).collect();
    let spread: Vec<f64> = (0..n).map(|joint| variance(target, joint)).collect();
    let largest = (0..p).fold(0.0_f64, |most, k| gram[(k, k)].max(most));
    let parts = |ridge: f64| -> Option<Vec<Vec<f64>>> {
        let own = |k: usize| ridge * gram[(k, k)].max(LEAST_SQUARE * largest);
        let of_block = |(block, (own_gram, own_right)): (&HeldOut, &(Mat<f64>, Mat<f64>))| {
            let mut rest = &gram - own_gram;
            (0..p).for_each(|k| rest[(k, k)] += own(k));
            let solved = rest.llt(Side::Lower).ok()?.solve(&right - own_right);
            let left = |joint: usize| {
                let fitted = rows(block.rows.clone(), joint) * &solved;
                let squares = block.rows.clone().enumerate().map(|(k, row)| {
                    (target[(row, joint)] - fitted[(k, 0)] / weights[joint * m + row]).powi(2)
                });
                squares.sum::<f64>() / block.rows.len() as f64 / spread[joint]
            };
            Some((0..n).map(left).collect())
        };
        blocks.iter().zip(&around).map(of_block).collect()
    };
    let roots: Vec<f64> = spread.iter().map(|variance| variance.sqrt()).collect();
    let shares: Vec<f64> = blocks.iter().map(|block| block.rows.len() as f64 / m as f64).collect();
    let of = |ridge: &f64| {
        Some(Errors { parts: parts(*ridge)?, shares: shares.clone(), spread: roots.clone() })
    };
    let found = RIDGES.iter().filter_map(of);
    Ok(found.min_by(|a, b| a.all().total_cmp(&b.all())))
}

fn variance(x: &Mat<f64>, column: usize) -> f64 {
    let m = x.nrows() as f64;
    let mean = x.col(column).sum() / m;
    let squares: f64 = x.col(column).iter().map(|x| (x - mean).powi(2)).sum();
    (squares / m).max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use torquewise_motion::Signals;

    fn motion(t: &[f64]) -> Motion {
        let zeros = || Mat::<f64>::zeros(t.len(), 1);
        Motion::new(Signals {
            joints: vec!["joint1".into()],
            t: t.to_vec(),
            q: zeros(),
            dq: zeros(),
            ddq: zeros(),
            tau: None,
        })
        .unwrap()
    }

    #[test]
    fn several_logs_are_held_out_whole_and_one_in_blocks_of_time() {
        let four = motion(&[0.0, 0.1, 0.2, 0.0, 0.1, 0.0, 0.1, 0.2, 0.3, 0.0]);
        let one = motion(&(0..240).map(f64::from).collect::<Vec<_>>());

        let logs: Vec<_> = whole_logs(&four).into_iter().map(|b| (b.rows, b.around)).collect();
        let blocks: Vec<_> = whole_logs(&one).into_iter().map(|b| (b.rows, b.around)).collect();

        assert_eq!(logs, [(0..3, 0..3), (3..5, 3..5), (5..9, 5..9), (9..10, 9..10)]);
        assert_eq!(blocks.len(), BLOCKS);
        assert_eq!(blocks[0], (0..10, 0..20));
        assert_eq!(blocks[5], (50..60, 40..70));
        assert_eq!(blocks[BLOCKS - 1], (230..240, 220..240));
    }

    #[test]
    fn very_many_logs_are_held_out_some_together() {
        let many = motion(&[0.0, 1.0].repeat(2 * BLOCKS + 1));

        let groups = whole_logs(&many);

        assert_eq!(groups.len(), BLOCKS);
        assert_eq!(groups[0].rows.start, 0);
        assert!(groups.windows(2).all(|pair| pair[0].rows.end == pair[1].rows.start));
        assert!(groups.iter().all(|group| group.rows.start % 2 == 0));
        assert_eq!(groups[BLOCKS - 1].rows.end, many.n_rows());
    }
}
