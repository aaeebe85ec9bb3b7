//! Held-out error of a chain, by blocks of time and regions.

use crate::Linearisation;
use crate::drift::logs;
use crate::estimate::LEAST_RESIDUAL;
use crate::regions::Regions;
use faer::linalg::solvers::Solve;
use faer::{ColRef, Mat, Side};
use rayon::prelude::*;
use torquewise_motion::Motion;
use torquewise_regression::products::picked;
use torquewise_rigid::rows::spread_above_rounding;
use torquewise_stepwise::IdentifyError;

mod physical;

pub(crate) use physical::HeldTo;

/// Blocks of time, each held out once: many, since few agree by chance; fewer of few rows.
pub(crate) const BLOCKS: usize = 24;
const LEAST_BLOCKS: usize = 6;
/// So many logs tell, whole ones held out, what others like them would: of two that show different
/// joints each is needed.
const LEAST_LOGS: usize = 4;
/// Rows that a block needs.
const LEAST_ROWS: usize = 4;
/// Rows that a choice takes: more than an error that is only said.
pub(crate) const CHOICE_ROWS: usize = BLOCKS * LEAST_ROWS;
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
    /// Standard deviation of the torque of each joint \[N·m\], n; 0 of one that never changes, which
    /// is judged by nothing.
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
        geometric_mean(&self.changing(self.by_joint().into_iter()))
    }

    /// Those of the joints whose torque changes.
    fn changing(&self, all: impl Iterator<Item = f64>) -> Vec<f64> {
        let pairs = all.zip(&self.spread);
        pairs.filter(|(_, spread)| **spread > 0.0).map(|(own, _)| own).collect()
    }

    /// Geometric mean of the joints in each block; next to nothing counts as nothing, so that no
    /// choice is made by rounding.
    pub(crate) fn by_block(&self) -> Vec<f64> {
        let root = |square: &f64| square.sqrt().max(LEAST_RESIDUAL);
        let mean = |block: &Vec<f64>| geometric_mean(&self.changing(block.iter().map(root)));
        self.parts.iter().map(mean).collect()
    }
}

pub(crate) fn geometric_mean(x: &[f64]) -> f64 {
    let logs: f64 = x.iter().map(|x| x.max(f64::MIN_POSITIVE).ln()).sum();
    (logs / x.len().max(1) as f64).exp()
}

/// Rows that are held out together, and those around them, themselves among them, that are not
/// fitted on; both ascending.
pub(crate) struct HeldOut {
    rows: Vec<usize>,
    around: Vec<usize>,
}

/// Regions of configuration that are held out.
const REGIONS: usize = 5;

/// Rows over which a filter carries torque: a period of its cut-off, of which it leaves eight rows.
const FILTER_ROWS: usize = 8;

/// Regions of configuration of a motion, of which every k-th row is at hand, each with the rows
/// before and after it that the filter carries torque to (E20).
pub(crate) fn regions(motion: &Motion, every: usize) -> Vec<HeldOut> {
    let margin = FILTER_ROWS.div_ceil(every.max(1));
    let (m, regions) = (motion.n_rows(), Regions::of(motion, REGIONS));
    let place: Vec<usize> = (0..m).map(|row| regions.of_row(motion, row)).collect();
    let of = |region: usize| -> HeldOut {
        let near = |row: &usize| {
            let (first, end) = (row.saturating_sub(margin), (row + margin + 1).min(m));
            place[first..end].contains(&region)
        };
        let rows = (0..m).filter(|&row| place[row] == region).collect();
        HeldOut { rows, around: (0..m).filter(near).collect() }
    };
    (0..REGIONS).map(of).filter(|block| !block.rows.is_empty()).collect()
}

/// What is held out of a motion that was thinned from a sample: whole logs or blocks of time, and
/// regions of configuration.
pub(crate) fn both_ways(few: &Motion, sample: &Motion) -> [Vec<HeldOut>; 2] {
    let every = sample.n_rows().div_ceil(few.n_rows().max(1));
    [whole_logs(few), regions(few, every)]
}

/// Blocks of time of a motion with their neighbours: the filter carries torque there.
pub(crate) fn even_blocks(motion: &Motion) -> Vec<HeldOut> {
    let count = (motion.n_rows() / LEAST_ROWS).clamp(1, BLOCKS);
    let edge = |block: usize| block * motion.n_rows() / count;
    let around = |block: usize| edge(block.saturating_sub(1))..edge((block + 2).min(count));
    let block =
        |k: usize| HeldOut { rows: (edge(k)..edge(k + 1)).collect(), around: around(k).collect() };
    (0..count).map(block).collect()
}

/// Whole logs where there are four or more, of very many some together; blocks of time of fewer.
fn whole_logs(motion: &Motion) -> Vec<HeldOut> {
    let logs = logs(motion.t());
    if logs.len() < LEAST_LOGS {
        return even_blocks(motion);
    }
    let groups = logs.len().min(BLOCKS);
    let first = |group: usize| group * logs.len() / groups;
    let rows = (0..groups).map(|group| logs[first(group)].start..logs[first(group + 1) - 1].end);
    rows.map(|rows| HeldOut { rows: rows.clone().collect(), around: rows.collect() }).collect()
}

/// The torque of a motion: what is fitted to, and what is to be predicted \[N·m\], m×n each.
pub(crate) type Target<'a> = (&'a Mat<f64>, &'a Mat<f64>);

/// Columns of a linearisation over a motion, and blocks of rows that are held out: any of the
/// columns may be fitted to the rest. The geometry takes one step where it may move.
pub(crate) struct Unseen<'a> {
    targets: &'a [Target<'a>],
    blocks: &'a [HeldOut],
    joints: Vec<JointRows>,
    all: Sums,
    /// Of the rows around each block.
    around: Vec<Sums>,
}

/// The equations of a joint, in units of its noise, but for columns that are nothing there.
struct JointRows {
    /// Places of the others among all.
    columns: Vec<usize>,
    /// m×columns.
    rows: Mat<f64>,
    /// What each row was multiplied by, m.
    weights: Vec<f64>,
}

/// Gram matrix and right-hand sides of some rows, p×p and p×targets.
type Sums = (Mat<f64>, Mat<f64>);

impl<'a> Unseen<'a> {
    /// - `slow`: rows at which a joint is slower than this part of its RMS speed leave nothing of it
    /// - returns: `None` where there are too few rows
    pub(crate) fn new(
        at: &Linearisation,
        motion: &Motion,
        targets: &'a [Target<'a>],
        blocks: &'a [HeldOut],
        slow: f64,
    ) -> Result<Option<Self>, IdentifyError> {
        let m = motion.n_rows();
        if m < CHOICE_ROWS {
            return Ok(None);
        }
        let (mut columns, mut weights) = at.columns_of(motion, true)?;
        for (joint, weights) in weights.chunks_mut(m).enumerate() {
            let dq = motion.dq().col(joint);
            let slow = slow * dq.norm_l2() / (m as f64).sqrt();
            for row in (0..m).filter(|row| dq[*row].abs() < slow) {
                weights[row] = 0.0;
                columns.row_mut(joint * m + row).fill(0.0);
            }
        }
        Ok(Self::of_columns((columns, weights), m, targets, blocks))
    }

    /// - `columns`: (m·n)×p, joint by joint, and what each row was multiplied by, m·n; a row that was
    ///   multiplied by 0 leaves nothing
    /// - returns: `None` where there are too few rows
    pub(crate) fn of_columns(
        (all, weights): (Mat<f64>, Vec<f64>),
        m: usize,
        targets: &'a [Target<'a>],
        blocks: &'a [HeldOut],
    ) -> Option<Self> {
        if m < LEAST_BLOCKS * LEAST_ROWS {
            return None;
        }
        let (n, p) = (weights.len() / m, all.ncols());
        let of_joint = |joint: usize| {
            let own = joint * m..(joint + 1) * m;
            let holds = |&j: &usize| all.col_as_slice(j)[own.clone()].iter().any(|x| *x != 0.0);
            let columns: Vec<usize> = (0..p).filter(holds).collect();
            let rows = picked(&all, &own.collect::<Vec<usize>>(), columns.iter().copied());
            JointRows { columns, rows, weights: weights[joint * m..(joint + 1) * m].to_vec() }
        };
        let joints: Vec<JointRows> = (0..n).map(of_joint).collect();
        let sums = |block: &[usize]| {
            let mut sums = (Mat::<f64>::zeros(p, p), Mat::<f64>::zeros(p, targets.len()));
            for (joint, JointRows { columns, rows, weights }) in joints.iter().enumerate() {
                let own = picked(rows, block, 0..columns.len());
                let responses = Mat::from_fn(block.len(), targets.len(), |k, target| {
                    weights[block[k]] * targets[target].0[(block[k], joint)]
                });
                let (gram, right) = (own.transpose() * &own, own.transpose() * responses);
                for (k, &j) in columns.iter().enumerate() {
                    columns.iter().enumerate().for_each(|(l, &i)| sums.0[(i, j)] += gram[(l, k)]);
                    (0..targets.len()).for_each(|target| sums.1[(j, target)] += right[(k, target)]);
                }
            }
            sums
        };
        let around = blocks.par_iter().map(|block| sums(&block.around)).collect();
        let all = sums(&(0..m).collect::<Vec<_>>());
        Some(Self { targets, blocks, joints, all, around })
    }

    /// What all columns leave, see [`Self::errors`].
    pub(crate) fn errors_of_all(&self) -> Option<Vec<Errors>> {
        self.errors(&(0..self.all.0.ncols()).collect::<Vec<_>>()).into_iter().collect()
    }

    /// What some columns, ascending, fitted to the torque but for each block and the rows around it,
    /// leave of what is to be predicted in that block, for each target; nothing where nothing can be
    /// solved.
    pub(crate) fn errors(&self, active: &[usize]) -> Vec<Option<Errors>> {
        let of = |(gram, right): &Sums| {
            (picked(gram, active, active.iter().copied()), picked(right, active, 0..right.ncols()))
        };
        let (all, around) = (of(&self.all), self.around.iter().map(of).collect::<Vec<Sums>>());
        let solved: Vec<Vec<Mat<f64>>> =
            RIDGES.iter().filter_map(|ridge| solved_without(&all, &around, *ridge)).collect();
        self.measured(&solved, active)
    }

    /// What coefficients without each block, of several ways to find them, leave in that block.
    fn measured(&self, solved: &[Vec<Mat<f64>>], active: &[usize]) -> Vec<Option<Errors>> {
        let (m, n) =
            (self.joints.first().map_or(0, |joint| joint.weights.len()), self.joints.len());
        let spreads = |(_, target): &Target<'_>| -> Vec<f64> {
            (0..n).map(|joint| spread(target.col(joint))).collect()
        };
        let spreads: Vec<Vec<f64>> = self.targets.iter().map(spreads).collect();
        // Mean squares over the variance of each ridge and target, blocks by joints.
        let none = vec![vec![0.0; n]; self.blocks.len()];
        let mut parts = vec![vec![none; self.targets.len()]; solved.len()];
        for (joint, JointRows { columns, rows, weights }) in self.joints.iter().enumerate() {
            let (own, places): (Vec<usize>, Vec<usize>) = (columns.iter().enumerate())
                .filter_map(|(k, j)| Some((k, active.binary_search(j).ok()?)))
                .unzip();
            for (b, block) in self.blocks.iter().enumerate() {
                let held = picked(rows, &block.rows, own.iter().copied());
                for (parts, solved) in parts.iter_mut().zip(solved) {
                    let places = picked(&solved[b], &places, 0..self.targets.len());
                    let fitted = &held * places;
                    for (k, (_, target)) in self.targets.iter().enumerate() {
                        let left = block.rows.iter().zip(fitted.col(k).iter());
                        let left = left.filter(|(row, _)| weights[**row] != 0.0);
                        let square = |(&row, x): (&usize, &f64)| {
                            (target[(row, joint)] - x / weights[row]).powi(2)
                        };
                        let mean = left.map(square).sum::<f64>() / block.rows.len() as f64;
                        let spread = spreads[k][joint];
                        parts[k][b][joint] = if spread > 0.0 { mean / spread.powi(2) } else { 0.0 };
                    }
                }
            }
        }
        let shares: Vec<f64> =
            self.blocks.iter().map(|block| block.rows.len() as f64 / m as f64).collect();
        let of = |(k, spread): (usize, &Vec<f64>)| -> Option<Errors> {
            let errors = parts.iter().map(|parts| {
                let (parts, shares, spread) = (parts[k].clone(), shares.clone(), spread.clone());
                Errors { parts, shares, spread }
            });
            errors.min_by(|a, b| a.all().total_cmp(&b.all()))
        };
        spreads.iter().enumerate().map(of).collect()
    }
}

/// Coefficients for each target without the rows around each block, p×targets; `None` where they
/// cannot be solved for.
fn solved_without((gram, right): &Sums, around: &[Sums], ridge: f64) -> Option<Vec<Mat<f64>>> {
    let p = gram.ncols();
    let largest = (0..p).fold(0.0_f64, |most, k| gram[(k, k)].max(most));
    let without = |(own_gram, own_right): &Sums| {
        let mut rest = gram - own_gram;
        for k in 0..p {
            rest[(k, k)] += ridge * gram[(k, k)].max(LEAST_SQUARE * largest);
        }
        Some(rest.llt(Side::Lower).ok()?.solve(right - own_right))
    };
    around.iter().map(without).collect()
}

/// Standard deviation, 0 where it is rounding.
pub(crate) fn spread(x: ColRef<'_, f64>) -> f64 {
    let m = x.nrows() as f64;
    let mean = x.sum() / m;
    let squares: f64 = x.iter().map(|x| (x - mean).powi(2)).sum();
    spread_above_rounding((squares / m).sqrt(), mean)
}

#[cfg(test)]
mod tests;
