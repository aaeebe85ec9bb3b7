//! Blocks of signals: split at gaps, q̇ and q̈ completed if wanted, in fixed memory.

use crate::absurd::{NEAR, absurd, impossible};
use crate::gaps::UsualStep;
use crate::signal_rows::{Origin, SignalRows};
use crate::{LogError, Result};
use faer::Mat;
use std::f64::consts::TAU;
use std::ops::Range;
use torquewise_motion::{
    BLOCK_ROWS, HALF_WINDOW, Motion, MotionError, Raw, Signal, Signals, derivative,
};

/// A position that goes on by less \[rad\] before, as and after it jumps by a whole turn was wrapped.
const MOST_STEP: f64 = 1.0;

/// Rows in a row that repeat a position, beyond which an arm stands still.
const MOST_REPEATS: usize = 10_000;
/// A device did not answer where a joint then steps farther than so many of the next steps, by this
/// \[rad, m\] at least, and came as far as its speed in the last steps leads to, but for these factors, in
/// at most so long \[s\] for the lower; it moved in most of these.
const STANDS_OUT: f64 = 2.0;
const LEAST_STEP: f64 = 1e-3;
const LAST_STEPS: usize = 5;
const SPEED_FACTORS: [f64; 2] = [0.3, 3.0];
const LONGEST: f64 = 0.2;

/// A position jumps where it steps by this \[rad, m\], and farther and faster than in any of so many rows
/// before and after, by this factor, of which this many move at all; slow rows \[s\] tell neither.
const LEAST_JUMP: f64 = 0.1;
const JUMPS: f64 = 5.0;
const AROUND: usize = 32;
const LEAST_MOVING: usize = 16;
/// A row of fewer values, its time among them, may be all zeros by chance.
const LEAST_VALUES: usize = 5;
const SLOW: f64 = 0.1;

/// The blocks of one log file.
///
/// `columns` holds a stretch of the current trajectory and, after its end, rows of the next one:
///
/// ```text
/// 0 … done      handed out, kept as the left part of windows
/// done … known  of this trajectory
/// known …       not yet looked at; of the next trajectory if `ended`
/// ```
pub(crate) struct Blocks {
    pub(crate) rows: SignalRows,
    joints: Vec<String>,
    /// Rows that the windows reach by which missing q̇ or q̈ are found; 0 if the file has both or none
    /// is wanted.
    reach: usize,
    /// Whether rows with absurd values are left out, and how many rows of `columns` were looked at.
    screens: bool,
    screened: usize,
    columns: Vec<Vec<f64>>,
    /// Rows that repeat the last one of `columns`, and the first that does not, until the next tells whether
    /// the arm stood still; and the number of the last row lost.
    repeats: Vec<(Vec<f64>, Origin)>,
    after: Option<(Vec<f64>, Origin)>,
    lost: u64,
    /// Turns that were added to the position of each joint \[rad\], and rows since its file or part began.
    turns: Vec<f64>,
    run: usize,
    done: usize,
    known: usize,
    ended: bool,
    at_end_of_file: bool,
    pub(crate) usual_step: Option<UsualStep>,
    trajectory: usize,
    /// Where the rows of `columns` come from.
    origins: Vec<Origin>,
}

impl Blocks {
    pub(crate) fn new(rows: SignalRows, joints: &[String], is_completed: bool) -> Self {
        let mapping = &rows.mapping;
        let complete = [Signal::Dq, Signal::Ddq].iter().all(|s| mapping.slot(*s).is_some());
        let columns = vec![Vec::new(); mapping.n_slots()];
        Self {
            rows,
            joints: joints.to_vec(),
            screens: is_completed,
            screened: 0,
            reach: if is_completed && !complete { HALF_WINDOW } else { 0 },
            columns,
            repeats: Vec::new(),
            after: None,
            lost: 0,
            turns: vec![0.0; joints.len()],
            run: 0,
            done: 0,
            known: 0,
            ended: false,
            at_end_of_file: false,
            usual_step: None,
            trajectory: 0,
            origins: Vec::new(),
        }
    }

    /// The next block and the index of its trajectory in this file; `None` at the end.
    pub(crate) fn next<B>(
        &mut self,
        block: impl Fn(&Self, usize) -> Result<B>,
    ) -> Result<Option<(usize, B)>> {
        self.look_ahead()?;
        if self.known == self.done && self.ended {
            self.forget(self.known);
            (self.done, self.known, self.ended, self.usual_step) = (0, 0, false, None);
            self.trajectory += 1;
            self.look_ahead()?;
        }
        let rows = (self.known - self.done).min(BLOCK_ROWS);
        if rows == 0 {
            return if self.rows.report.rows > 0 { Ok(None) } else { Err(self.rows.none_left()) };
        }
        let block = block(self, rows)?;
        // The window of a row near the end moves inwards, so it reaches up to twice as far back. The
        // last time stamp stays, for the next one is compared with it.
        let done = self.done + rows;
        self.done = done.min(self.reach.saturating_mul(2).max(AROUND + 1)).max(1);
        self.forget(done - self.done);
        self.known -= done - self.done;
        Ok(Some((self.trajectory, block)))
    }

    /// Makes sure that the next block, and what its windows reach, is known.
    fn look_ahead(&mut self) -> Result<()> {
        if self.ended {
            return Ok(());
        }
        let wanted = self.done + BLOCK_ROWS + self.reach + NEAR + AROUND + 1;
        let mut row = vec![0.0; self.columns.len()];
        while self.columns[0].len() < wanted && !self.at_end_of_file {
            let Some(origin) = self.rows.next(&mut row)? else {
                self.at_end_of_file = true;
                self.release();
                break;
            };
            if self.is_lost(&row, origin) {
                self.rows.report.repairs.zeros += 1;
                self.rows.report.first_zeros.get_or_insert(origin.number);
                self.lost = origin.number;
                continue;
            }
            let resumes = self.origins.last().is_some_and(|last| last.number < self.lost);
            self.take(&row, Origin { resumes, ..origin })?;
        }
        self.screen();
        let t = &self.columns[0][..self.screened];
        self.known = self.known.max(usize::from(!t.is_empty()));
        let mut usual = self.usual_step.take().unwrap_or_else(|| UsualStep::new(t));
        let end = t.len().saturating_sub(if self.at_end_of_file { 0 } else { AROUND });
        while self.known < end && !self.ended {
            let row = self.known;
            let step = self.columns[0][row] - self.columns[0][row - 1];
            let another = self.origins[row].part != self.origins[row - 1].part;
            let bridged = self.origins[row].resumes && step < LONGEST;
            let gap = !another && usual.is_gap(step) && !bridged;
            let matters = !another && !gap && usual.0 < SLOW && (self.reach > 0 || !self.screens);
            let jump = matters.then(|| self.jump(row)).flatten();
            if let Some((joint, by)) = jump {
                let first = (self.origins[row].number, self.joints[joint].clone(), by);
                self.rows.report.jumps += 1;
                self.rows.report.first_jump.get_or_insert(first);
            }
            self.rows.report.repairs.splits += u64::from(gap || jump.is_some());
            self.ended = another || gap || jump.is_some();
            self.known += usize::from(!self.ended);
        }
        self.usual_step = Some(usual);
        Ok(())
    }

    /// Places of the positions among the columns.
    fn positions(&self) -> Range<usize> {
        self.rows.mapping.slot(Signal::Q).map_or(0..0, |first| first..first + self.joints.len())
    }

    /// The joint whose position jumps to a row, and by what, if one does.
    fn jump(&self, row: usize) -> Option<(usize, f64)> {
        let t = &self.columns[0];
        let around = || row.saturating_sub(AROUND).max(1)..(row + AROUND).min(t.len());
        self.positions().enumerate().find_map(|(joint, slot)| {
            let step = |row: usize| self.columns[slot][row] - self.columns[slot][row - 1];
            let speed = |row: usize| step(row).abs() / (t[row] - t[row - 1]);
            let by = step(row);
            let is_less = |other: usize| {
                JUMPS * step(other).abs() < by.abs() && JUMPS * speed(other) < speed(row)
            };
            let is_jump = by.abs() > LEAST_JUMP
                && (by.abs() - TAU).abs() > MOST_STEP
                && (LAST_STEPS..=t.len().saturating_sub(LAST_STEPS)).contains(&row)
                && around().all(|other| other == row || is_less(other))
                && around().filter(|other| step(*other) != 0.0).count() > LEAST_MOVING;
            is_jump.then_some((joint, by))
        })
    }

    /// Leaves out rows with absurd values, of signals to be filtered the impossible alone; but for the
    /// last ones, of which not all that stands beside them is known.
    fn screen(&mut self) {
        let all = self.columns[0].len();
        let end = all.saturating_sub(if self.at_end_of_file { 0 } else { NEAR });
        let mapping = &self.rows.mapping;
        let mut gone: Vec<usize> = Vec::new();
        for (place, column) in self.columns.iter().skip(1).enumerate() {
            let (signal, joint) =
                (mapping.present[place / mapping.n_joints], place % mapping.n_joints);
            let mut own = impossible(column, signal);
            own.extend(if self.screens { absurd(column, signal) } else { Vec::new() });
            for row in own.into_iter().filter(|row| (self.screened..end).contains(row)) {
                let name = format!("{}{}", signal.name(), joint + 1);
                let first = || (self.origins[row].number, name, column[row]);
                self.rows.report.first_absurd.get_or_insert_with(first);
                gone.push(row);
            }
        }
        gone.sort_unstable();
        gone.dedup();
        self.rows.report.repairs.absurd += gone.len() as u64;
        for &row in gone.iter().rev() {
            for column in &mut self.columns {
                column.remove(row);
            }
            self.origins.remove(row);
        }
        self.screened = end - gone.len();
    }

    /// Leaves out rows that repeat the position of the one before where the arm had moved on after them.
    fn take(&mut self, row: &[f64], origin: Origin) -> Result<()> {
        let last = self.after.as_ref().or(self.repeats.last()).map(|(row, _)| &row[0]);
        let last = last.or(self.columns[0].last());
        if let Some(&before) = last.filter(|before| **before >= row[0]) {
            return Err(LogError::TimeOrder { place: self.rows.place(), t: row[0], before });
        }
        if let Some(after) = &self.after {
            if self.was_frozen(after, (row, origin)) {
                let (report, first) = (&mut self.rows.report, &self.repeats[0].1);
                report.repairs.held_rows += self.repeats.len() as u64;
                report.first_held.get_or_insert(first.number);
                self.repeats.clear();
                self.after.iter_mut().for_each(|(_, own)| own.resumes = true);
            }
            self.release();
        }
        let is_repeat = self.origins.last().is_some_and(|last| last.part == origin.part)
            && self.steps_to(row).all(|step| step == 0.0);
        if is_repeat && self.repeats.len() == MOST_REPEATS {
            self.release();
        }
        match (is_repeat, self.repeats.is_empty()) {
            (true, _) => self.repeats.push((row.to_vec(), origin)),
            (false, true) => self.push(row, origin),
            (false, false) => self.after = Some((row.to_vec(), origin)),
        }
        Ok(())
    }

    /// Whether a row is all zeros, though the arm was elsewhere in the one before.
    fn is_lost(&self, row: &[f64], origin: Origin) -> bool {
        row.len() >= LEAST_VALUES
            && row[1..].iter().all(|value| *value == 0.0)
            && self.origins.last().is_some_and(|last| last.part == origin.part)
            && self.steps_to(row).any(|step| step.abs() > LEAST_JUMP)
    }

    /// How far each joint is in a row from where it last was.
    fn steps_to(&self, row: &[f64]) -> impl Iterator<Item = f64> {
        let slots = self.positions().zip(&self.turns);
        slots.filter_map(|(slot, turns)| Some(row[slot] + turns - self.columns[slot].last()?))
    }

    /// Whether a joint is, after rows that repeat a position, where its last speeds lead to, and stands out
    /// there from the row that follows: it did not stand still.
    fn was_frozen(&self, after: &(Vec<f64>, Origin), (next, origin): (&[f64], Origin)) -> bool {
        let t = &self.columns[0];
        let Some(first) = t.len().checked_sub(LAST_STEPS + 1) else { return false };
        let parts = self.origins[first..].iter().chain([&after.1, &origin]);
        let repeats = self.repeats.iter().map(|(row, _)| row[0]);
        let times: Vec<f64> =
            t[first..].iter().copied().chain(repeats).chain([after.0[0], next[0]]).collect();
        let mut usual = UsualStep::new(&times[..=LAST_STEPS]);
        let seconds = after.0[0] - t[t.len() - 1];
        let is_whole = parts.map(|own| own.part).all(|part| part == origin.part)
            && times.windows(2).all(|pair| !usual.is_gap(pair[1] - pair[0]));
        if !is_whole || usual.0 > SLOW || !usual.is_gap(seconds) {
            return false;
        }
        let [.., before, own, end] = times[..] else { return false };
        self.steps_to(&after.0).zip(self.positions()).any(|(step, slot)| {
            let q = &self.columns[slot];
            let speed = |row: usize| ((q[row] - q[row - 1]) / (t[row] - t[row - 1])).abs();
            let speeds: Vec<f64> = (first + 1..t.len()).map(speed).filter(|v| *v > 0.0).collect();
            let fastest = speeds.iter().copied().fold(0.0, f64::max);
            let [least, most] = SPEED_FACTORS.map(|factor| factor * fastest);
            let goes_on = (next[slot] - after.0[slot]).abs() / (end - own);
            (LEAST_STEP.max(least * seconds.min(LONGEST))..most * seconds).contains(&step.abs())
                && step.abs() / (own - before) > STANDS_OUT * goes_on
                && 2 * speeds.len() > LAST_STEPS
        })
    }

    fn release(&mut self) {
        let rows = std::mem::take(&mut self.repeats).into_iter().chain(self.after.take());
        rows.for_each(|(row, origin)| self.push(&row, origin));
    }

    fn push(&mut self, row: &[f64], origin: Origin) {
        self.columns.iter_mut().zip(row).for_each(|(column, value)| column.push(*value));
        if self.origins.last().is_some_and(|before| before.part != origin.part) {
            self.turns.fill(0.0);
            self.run = 0;
        }
        self.run += 1;
        self.unwrap_last();
        self.origins.push(origin);
    }

    /// Takes a whole turn out of the positions of the last rows, once two more follow the one that was
    /// wrapped: a spike goes back.
    fn unwrap_last(&mut self) {
        let slots = self.positions();
        for (turns, column) in self.turns.iter_mut().zip(&mut self.columns[slots]) {
            if let Some(q) = column.last_mut().filter(|_| *turns != 0.0) {
                *q += *turns;
            }
            let [.., a, b, c, d, e] = column[..] else { continue };
            let whole = TAU.copysign(c - b);
            let steps = [b - a, c - whole - b, d - c, e - d];
            if self.run > 4 && steps.iter().all(|step| step.abs() < MOST_STEP) {
                self.rows.report.repairs.whole_turns += 1;
                *turns -= whole;
                column.iter_mut().rev().take(3).for_each(|q| *q -= whole);
            }
        }
    }

    fn forget(&mut self, rows: usize) {
        self.screened -= rows;
        for column in &mut self.columns {
            column.drain(..rows);
        }
        self.origins.drain(..rows);
    }

    pub(crate) fn block(&self, rows: usize) -> Result<Motion> {
        let (start, end) = (self.done, self.done + rows);
        let [q, dq, ddq, tau] = Signal::ALL.map(|signal| self.signal(signal, start, end));
        let q = q.ok_or_else(|| self.refused(start, MotionError::Missing("q")))?;
        let has_dq = dq.is_some();
        let dq = dq.map_or_else(|| self.derived(Signal::Q, 1, rows), Ok)?;
        let (signal, order) = if has_dq { (Signal::Dq, 1) } else { (Signal::Q, 2) };
        let ddq = ddq.map_or_else(|| self.derived(signal, order, rows), Ok)?;
        let (joints, t) = (self.joints.clone(), self.columns[0][start..end].to_vec());
        Motion::new(Signals { joints, t, q, dq, ddq, tau })
            .map_err(|source| self.refused(start, source))
    }

    pub(crate) fn raw_block(&self, rows: usize) -> Raw {
        let part = |column: &Vec<f64>| column[self.done..self.done + rows].to_vec();
        let signals = Signal::ALL.map(|signal| {
            let first = self.rows.mapping.slot(signal)?;
            Some(self.columns[first..first + self.joints.len()].iter().map(part).collect())
        });
        Raw { joints: self.joints.clone(), t: part(&self.columns[0]), signals }
    }

    fn refused(&self, place: usize, source: MotionError) -> LogError {
        let (file, origin) = (self.rows.place().file, self.origins.get(place));
        let row = origin.map_or(1, |origin| origin.number);
        match source {
            MotionError::TooFewRows { rows, needed } => {
                LogError::TooShort { file, row, rows, needed }
            }
            source => LogError::Motion { file, row, source },
        }
    }

    fn signal(&self, signal: Signal, start: usize, end: usize) -> Option<Mat<f64>> {
        let slot = self.rows.mapping.slot(signal)?;
        let of_joint = |row: usize, joint: usize| self.columns[slot + joint][start + row];
        Some(Mat::from_fn(end - start, self.joints.len(), of_joint))
    }

    /// Derivative of a signal on the next `rows`, from all rows that their windows reach.
    fn derived(&self, signal: Signal, order: usize, rows: usize) -> Result<Mat<f64>> {
        let end = self.known.min(self.done + rows + HALF_WINDOW);
        let refused = |source| self.refused(0, source);
        let x = self.signal(signal, 0, end).ok_or(refused(MotionError::Missing(signal.name())))?;
        let derived = derivative(&self.columns[0][..end], x.as_ref(), order);
        Ok(derived.map_err(refused)?.subrows(self.done, rows).to_owned())
    }
}

#[cfg(test)]
pub(crate) mod tests;
