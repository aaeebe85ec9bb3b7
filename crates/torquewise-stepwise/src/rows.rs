//! Rows of a motion as samples of a regression: q as angles; q̇, q̈, q and friction as variables.

use crate::candidates::SIGNALS;
use faer::Mat;
use std::borrow::Cow;
use torquewise_model::FrictionTerm;
use torquewise_motion::{BLOCK_ROWS, Motion, MotionError, Pattern};
use torquewise_regression::{RowAdder, RowSums, Samples, SparseError};

/// The rows of a motion in the words of a regression.
pub(crate) fn samples_of(
    motion: &Motion,
    friction: &[FrictionTerm],
) -> Result<Samples, MotionError> {
    let n = motion.n_joints();
    let mut variables = Mat::zeros(motion.n_rows(), SIGNALS * n + friction.len());
    variables.subcols_mut(0, n).copy_from(motion.dq());
    variables.subcols_mut(n, n).copy_from(motion.ddq());
    let (angles, responses) = (motion.q().to_owned(), motion.require_tau()?.to_owned());
    let mut samples = Samples { angles, variables, responses };
    fill_in(&mut samples, friction);
    Ok(samples)
}

/// A joint whose speed is this close to its reversal \[s\] is not used where friction is fitted:
/// filters blur the jump of dry friction over about as long.
const REVERSAL: f64 = 0.05;

/// The rows in which no joint is about to turn back, or has just done so; all of them without
/// friction.
pub(crate) fn clear_of_reversals<'a>(
    motion: &'a Motion,
    friction: &[FrictionTerm],
) -> Cow<'a, Motion> {
    let (dq, ddq) = (motion.dq(), motion.ddq());
    let clear = |row: &usize| {
        (0..motion.n_joints()).all(|joint| {
            let (speed, rate) = (dq[(*row, joint)].abs(), ddq[(*row, joint)].abs());
            speed == 0.0 || speed >= REVERSAL * rate
        })
    };
    if friction.is_empty() {
        return Cow::Borrowed(motion);
    }
    Cow::Owned(motion.select(&(0..motion.n_rows()).filter(clear).collect::<Vec<_>>()))
}

/// What follows from the other variables: positions, and friction at the speeds of each row.
pub fn fill_in(samples: &mut Samples, friction: &[FrictionTerm]) {
    let n = samples.angles.ncols();
    samples.variables.subcols_mut(2 * n, n).copy_from(&samples.angles);
    let mut speeds = vec![0.0; n];
    for row in 0..samples.n_rows() {
        for (joint, speed) in speeds.iter_mut().enumerate() {
            *speed = samples.variables[(row, joint)];
        }
        for (place, law) in friction.iter().enumerate() {
            samples.variables[(row, SIGNALS * n + place)] = law.value(&speeds);
        }
    }
}

/// A block cut into pieces of at most `rows` rows, but not too small to be worth their cost.
pub(crate) fn cut(samples: Samples, rows: usize) -> Vec<Samples> {
    let size = rows.clamp(LEAST_PIECE, BLOCK_ROWS);
    if samples.n_rows() <= size {
        return vec![samples];
    }
    let pieces = (0..samples.n_rows()).step_by(size);
    pieces.map(|start| samples.rows(start, size.min(samples.n_rows() - start))).collect()
}

const LEAST_PIECE: usize = 16;

/// Sums over the rows of a pattern, which are gathered to full blocks and dealt out in turn.
pub(crate) struct PatternSums<'a> {
    /// Whose rows; `None` for all.
    pattern: Option<Pattern>,
    /// A block, whose first rows are held.
    block: Samples,
    held: usize,
    piece: usize,
    sums: Vec<RowAdder<'a>>,
    /// The sum that the next piece belongs to.
    next: usize,
}

impl<'a> PatternSums<'a> {
    /// - `widths`: number of joints and of laws of friction
    /// - `piece`: rows of a piece
    pub(crate) fn new(
        pattern: Option<Pattern>,
        (n_joints, friction): (usize, usize),
        piece: usize,
        sums: Vec<RowAdder<'a>>,
    ) -> Self {
        let empty = |columns| Mat::zeros(BLOCK_ROWS, columns);
        let block = Samples {
            angles: empty(n_joints),
            variables: empty(SIGNALS * n_joints + friction),
            responses: empty(n_joints),
        };
        Self { pattern, block, held: 0, piece, sums, next: 0 }
    }

    pub(crate) fn add(&mut self, samples: &Samples, labels: &[Pattern]) -> Result<(), SparseError> {
        for (row, &label) in labels.iter().enumerate() {
            if self.pattern.is_some_and(|pattern| pattern != label) {
                continue;
            }
            let Samples { angles, variables, responses } = &mut self.block;
            angles.row_mut(self.held).copy_from(samples.angles.row(row));
            variables.row_mut(self.held).copy_from(samples.variables.row(row));
            responses.row_mut(self.held).copy_from(samples.responses.row(row));
            self.held += 1;
            if self.held == BLOCK_ROWS {
                self.deal()?;
            }
        }
        Ok(())
    }

    fn deal(&mut self) -> Result<(), SparseError> {
        for piece in cut(self.block.rows(0, std::mem::take(&mut self.held)), self.piece) {
            self.sums[self.next].push(piece)?;
            self.next = (self.next + 1) % self.sums.len();
        }
        Ok(())
    }

    pub(crate) fn finish(mut self) -> Result<Vec<RowSums>, SparseError> {
        if self.held > 0 {
            self.deal()?;
        }
        self.sums.into_iter().map(RowAdder::finish).collect()
    }
}
