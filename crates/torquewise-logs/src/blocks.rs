//! Rows → Motion blocks: split at gaps, q̇ and q̈ completed, in fixed memory.

use crate::error::LogError;
use crate::gaps::UsualStep;
use crate::layout::Signal;
use crate::rows::Rows;
use faer::Mat;
use torquewise_motion::{BLOCK_ROWS, LocalPolynomial, Motion, MotionError, Signals, derivative};

/// The blocks of one log file.
///
/// `columns` holds a stretch of the current trajectory and, after its end, rows of the next one:
///
/// ```text
/// 0 … done      handed out, kept as the left part of windows
/// done … known  of this trajectory
/// known …       not yet looked at; of the next trajectory if `ended`
/// ```
pub(crate) struct Blocks<'a> {
    rows: Box<dyn Rows>,
    joints: &'a [String],
    /// How missing q̇ or q̈ are found; `None` if the file has both.
    polynomial: Option<LocalPolynomial>,
    columns: Vec<Vec<f64>>,
    done: usize,
    known: usize,
    ended: bool,
    at_end_of_file: bool,
    usual_step: Option<UsualStep>,
    trajectory: usize,
    /// Data row of the first row in `columns`.
    first_row: u64,
}

impl<'a> Blocks<'a> {
    pub(crate) fn new(
        rows: Box<dyn Rows>,
        joints: &'a [String],
        polynomial: LocalPolynomial,
    ) -> Self {
        let layout = rows.layout();
        let complete = [Signal::Dq, Signal::Ddq].iter().all(|s| layout.slot(*s).is_some());
        let columns = vec![Vec::new(); layout.columns().len()];
        Self {
            rows,
            joints,
            polynomial: (!complete).then_some(polynomial),
            columns,
            done: 0,
            known: 0,
            ended: false,
            at_end_of_file: false,
            usual_step: None,
            trajectory: 0,
            first_row: 1,
        }
    }

    /// The next block and the index of its trajectory in this file; `None` at the end.
    pub(crate) fn next(&mut self) -> Result<Option<(usize, Motion)>, LogError> {
        self.look_ahead()?;
        if self.known == self.done && self.ended {
            self.begin_trajectory();
            self.look_ahead()?;
        }
        let rows = (self.known - self.done).min(BLOCK_ROWS);
        if rows == 0 {
            let file = self.rows.place().file;
            return if self.first_row == 1 && self.done == 0 {
                Err(LogError::NoRows { file })
            } else {
                Ok(None)
            };
        }
        let block = self.block(rows)?;
        self.hand_out(rows);
        Ok(Some((self.trajectory, block)))
    }

    /// Rows that a window reaches to each side.
    fn reach(&self) -> usize {
        self.polynomial.map_or(0, LocalPolynomial::half_window)
    }

    /// Makes sure that the next block, and what its windows reach, is known.
    fn look_ahead(&mut self) -> Result<(), LogError> {
        if self.ended {
            return Ok(());
        }
        let wanted = self.done + BLOCK_ROWS + self.reach();
        let mut row = vec![0.0; self.columns.len()];
        while self.columns[0].len() < wanted && !self.at_end_of_file {
            self.at_end_of_file = !self.rows.next(&mut row)?;
            if !self.at_end_of_file {
                self.push(&row)?;
            }
        }
        let t = &self.columns[0];
        if self.known == 0 && !t.is_empty() {
            self.known = 1;
        }
        let usual = self.usual_step.get_or_insert_with(|| UsualStep::new(t));
        while self.known < t.len() && !self.ended {
            self.ended = usual.is_gap(t[self.known] - t[self.known - 1]);
            self.known += usize::from(!self.ended);
        }
        Ok(())
    }

    fn push(&mut self, row: &[f64]) -> Result<(), LogError> {
        let t = row[0];
        if let Some(&before) = self.columns[0].last().filter(|before| **before >= t) {
            return Err(LogError::TimeOrder { place: self.rows.place(), t, before });
        }
        for (column, value) in self.columns.iter_mut().zip(row) {
            column.push(*value);
        }
        Ok(())
    }

    /// Forgets the trajectory that ended.
    fn begin_trajectory(&mut self) {
        self.forget(self.known);
        self.done = 0;
        self.known = 0;
        self.ended = false;
        self.usual_step = None;
        self.trajectory += 1;
    }

    /// Marks the next `rows` as handed out and forgets those that no window reaches any more.
    ///
    /// The window of a row near the end moves inwards, so it reaches up to twice as far back.
    fn hand_out(&mut self, rows: usize) {
        let done = self.done + rows;
        self.done = done.min(self.reach().saturating_mul(2));
        // The last time stamp stays, for the next one is compared with it.
        self.done = self.done.max(1);
        self.forget(done - self.done);
        self.known -= done - self.done;
    }

    fn forget(&mut self, rows: usize) {
        for column in &mut self.columns {
            column.drain(..rows);
        }
        self.first_row += rows as u64;
    }

    fn block(&self, rows: usize) -> Result<Motion, LogError> {
        let (start, end) = (self.done, self.done + rows);
        let refused = |source| LogError::Motion {
            file: self.rows.place().file,
            row: self.first_row + start as u64,
            source,
        };
        let part = |signal| self.signal(signal, start, end);
        let Some(q) = part(Signal::Q) else {
            return Err(refused(MotionError::Missing("q")));
        };
        let dq = part(Signal::Dq).map_or_else(|| self.derived(Signal::Q, 1, rows), Ok)?;
        let ddq = part(Signal::Ddq).map_or_else(
            || match self.rows.layout().slot(Signal::Dq) {
                Some(_) => self.derived(Signal::Dq, 1, rows),
                None => self.derived(Signal::Q, 2, rows),
            },
            Ok,
        )?;
        let t = self.columns[0][start..end].to_vec();
        let tau = part(Signal::Tau);
        Motion::new(Signals { joints: self.joints.to_vec(), t, q, dq, ddq, tau }).map_err(refused)
    }

    /// Rows `start` … `end` of a signal, if the file has it.
    fn signal(&self, signal: Signal, start: usize, end: usize) -> Option<Mat<f64>> {
        let slot = self.rows.layout().slot(signal)?;
        let of_joint = |row: usize, joint: usize| self.columns[slot + joint][start + row];
        Some(Mat::from_fn(end - start, self.joints.len(), of_joint))
    }

    /// Derivative of a signal on the next `rows`, from all rows that their windows reach.
    fn derived(&self, signal: Signal, order: usize, rows: usize) -> Result<Mat<f64>, LogError> {
        let polynomial = self.polynomial.unwrap_or_default();
        let end = self.known.min(self.done + rows + polynomial.half_window());
        let refused = |source| match source {
            MotionError::TooFewRows { rows, needed } => LogError::TooShort {
                file: self.rows.place().file,
                row: self.first_row,
                rows,
                needed,
            },
            source => {
                LogError::Motion { file: self.rows.place().file, row: self.first_row, source }
            }
        };
        let x = self.signal(signal, 0, end).ok_or(refused(MotionError::Missing(signal.name())))?;
        let derived = derivative(&self.columns[0][..end], x.as_ref(), polynomial, order);
        Ok(derived.map_err(refused)?.subrows(self.done, rows).to_owned())
    }
}

#[cfg(test)]
mod tests;
