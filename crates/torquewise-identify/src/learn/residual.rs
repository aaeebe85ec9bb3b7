//! From chain, rows to what the rest of a chain leaves to the friction of each joint.

use super::{ChainLearner, LAST_ROWS, TRIAL_ROWS};
use crate::chain_spec::ChainSpec;
use crate::drive_terms::{SHARE_AT_REST, columns};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use torquewise_model::model::Choice;
use torquewise_motion::Motion;
use torquewise_rigid::{Chain, fit};
use torquewise_stepwise::error::IdentifyError;
use torquewise_stepwise::held_out::{BLOCKS, CvScore, mean, split};
use torquewise_stepwise::survey::thinned;

/// What stands beside the links must lower the error of its joint on held-out rows by this part,
/// and the error of the whole by its share of it.
pub(super) const WORTH: f64 = 0.02;
/// Ridges of a joint, relative to the square of a column: the best one counts.
const RIDGES: [f64; 4] = [1e-4, 1e-3, 1e-2, 1e-1];

/// The torque of each joint without its friction, which any law may be fitted to.
pub(super) struct FrictionResidual {
    chain: Chain,
    pub(super) motion: Motion,
    /// Torque \[N·m\] of each joint, n×m.
    torque: Vec<Vec<f64>>,
    /// What the square of a row counts, n×m.
    shares: Vec<Vec<f64>>,
    /// Standard deviation of the whole torque of each joint \[N·m\], n.
    spread: Vec<f64>,
}

impl FrictionResidual {
    /// What a fit of a specification leaves.
    pub(super) fn of(
        learner: &ChainLearner<'_>,
        spec: &mut ChainSpec,
        chain: &Chain,
    ) -> Result<Self, IdentifyError> {
        let chain = fit(&learner.rows(spec, TRIAL_ROWS)?, chain, &spec.search)?;
        spec.bear(&chain);
        let rows = learner.rows(spec, LAST_ROWS)?;
        let (m, predicted) = (rows.len(), chain.torque(&rows));
        let motion = thinned(learner.motion, LAST_ROWS);
        let own = columns(&spec.drive, &motion, spec.gravity.as_ref());
        let left = |joint: usize, row: usize| -> f64 {
            let has_friction = (chain.drive.iter().zip(&spec.drive).enumerate())
                .filter(|(_, (_, drive))| drive.is_friction_of(joint))
                .map(|(k, (coefficient, _))| coefficient * own[joint][(row, k)]);
            rows.torque_of(joint)[row] - predicted[joint * m + row] + has_friction.sum::<f64>()
        };
        let over = |value: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<f64>> {
            (0..rows.n_joints())
                .map(|joint| (0..m).map(|row| value(joint, row)).collect())
                .collect()
        };
        let torque = over(&left);
        let moves = |joint, row| learner.moves(&motion, row, joint);
        let shares = over(&|joint, row| if moves(joint, row) { 1.0 } else { SHARE_AT_REST });
        let spread = (0..rows.n_joints()).map(|joint| rows.deviation_of(joint)).collect();
        Ok(Self { chain, motion, torque, shares, spread })
    }

    /// A way to explain what is left of a joint, tried on held-out blocks; `None` if nothing can be
    /// solved.
    pub(super) fn trial(&self, joint: usize, label: String, columns: &Mat<f64>) -> Option<CvScore> {
        let errors = RIDGES.iter().filter_map(|ridge| self.errors(joint, columns, *ridge));
        let errors = errors.min_by(|a, b| mean(a).total_cmp(&mean(b)))?;
        Some(CvScore { label, complexity: columns.ncols(), errors })
    }

    /// What columns leave of each row of a joint once all are fitted, and what it counts.
    pub(super) fn residual(&self, joint: usize, columns: &Mat<f64>) -> Option<Vec<(f64, f64)>> {
        let all: Vec<usize> = (0..self.motion.n_rows()).collect();
        let solved = self.solved(joint, columns, RIDGES[0], &all)?;
        let left =
            |&row: &usize| (self.left(joint, columns, &solved, row), self.shares[joint][row]);
        Some(all.iter().map(left).collect())
    }

    /// What columns leave on each block of time that they were not fitted on, RMS over the spread
    /// of the torque.
    fn errors(&self, joint: usize, columns: &Mat<f64>, ridge: f64) -> Option<Vec<f64>> {
        let of_block = |block: usize| {
            let (held, rest) = split(self.motion.n_rows(), block);
            let solved = self.solved(joint, columns, ridge, &rest)?;
            let shares = &self.shares[joint];
            let count: f64 = held.iter().map(|&row| shares[row]).sum();
            let square = |&row: &usize| self.left(joint, columns, &solved, row).powi(2);
            let squares: f64 = held.iter().map(|row| shares[*row] * square(row)).sum();
            let rms = (squares / count.max(f64::MIN_POSITIVE)).sqrt();
            Some(rms / self.spread[joint].max(f64::MIN_POSITIVE))
        };
        (0..BLOCKS).map(of_block).collect()
    }

    fn left(&self, joint: usize, columns: &Mat<f64>, solved: &Mat<f64>, row: usize) -> f64 {
        let explained = (0..columns.ncols()).map(|k| columns[(row, k)] * solved[(k, 0)]);
        self.torque[joint][row] - explained.sum::<f64>()
    }

    /// Coefficients of columns, fitted to some rows.
    fn solved(
        &self,
        joint: usize,
        columns: &Mat<f64>,
        ridge: f64,
        rows: &[usize],
    ) -> Option<Mat<f64>> {
        let p = columns.ncols();
        let root = |row: usize| self.shares[joint][rows[row]].sqrt();
        let own = Mat::from_fn(rows.len(), p, |row, k| root(row) * columns[(rows[row], k)]);
        let right = Mat::from_fn(rows.len(), 1, |row, _| root(row) * self.torque[joint][rows[row]]);
        let mut gram = own.transpose() * &own;
        (0..p).for_each(|k| gram[(k, k)] += (ridge * gram[(k, k)]).max(f64::MIN_POSITIVE));
        Some(gram.llt(Side::Lower).ok()?.solve(own.transpose() * right))
    }
}

impl ChainLearner<'_> {
    /// Takes another specification for one joint where the whole chain agrees on held-out rows: a longer
    /// one must be better by the share of the joint, a shorter one may be so much worse.
    ///
    /// - `now`: error of the specification as it is
    /// - returns: whether it was taken
    pub(super) fn agree(
        &self,
        (spec, now): (&mut ChainSpec, &mut f64),
        with: ChainSpec,
        left: &FrictionResidual,
    ) -> Result<bool, IdentifyError> {
        let is_longer = with.drive.len() > spec.drive.len();
        let part = WORTH / self.motion.n_joints() as f64;
        let allowed = if is_longer { 1.0 - part } else { 1.0 + part };
        let error = self.error(&with, left)?;
        let agrees = error <= allowed * *now;
        if agrees {
            (*spec, *now) = (with, error);
        }
        Ok(agrees)
    }

    /// Error of a specification on held-out rows.
    pub(super) fn error(
        &self,
        spec: &ChainSpec,
        left: &FrictionResidual,
    ) -> Result<f64, IdentifyError> {
        Ok(self.trials(&[(String::new(), spec.clone())], &left.chain, 0)?[0].error())
    }
}

/// Writes down that the whole chain was no better with what was chosen, and what is taken instead.
pub(super) fn refuse(choice: &mut Choice, instead: &str) {
    choice.rule = format!("{}; the whole is no better with {}", choice.rule, choice.chosen);
    instead.clone_into(&mut choice.chosen);
}
