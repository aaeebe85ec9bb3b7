//! Conditioned blocks of a trajectory of any length, in fixed memory.

use crate::signals::clean::{Outliers, clean};
use crate::signals::plan::SignalPlan;
use crate::signals::resample::count_gaps;
use crate::signals::smooth::{filter, kept, smooth};
use crate::{Motion, MotionError, Raw, Repairs, Result};

/// Rows that are conditioned at once, besides the overlap.
const PART_ROWS: usize = 1 << 15;

/// Conditions one trajectory block by block.
///
/// Blocks are gathered to parts of 2¹⁵ rows, or four times the overlap if that is more. Parts
/// overlap by as much as the filter remembers, so that the rows are those of
/// [`condition`](crate::signals::condition()) on the whole trajectory, but for rounding.
#[derive(Clone, Debug)]
pub struct Conditioner {
    plan: SignalPlan,
    /// Rows to each side on which a conditioned row depends.
    overlap: usize,
    waiting: Raw,
    origin: Option<f64>,
    /// Raw rows before those that wait.
    rows_before: usize,
    /// Grid index of the next row to hand out.
    next: usize,
    /// Spikes that were replaced and gaps that were bridged so far.
    pub repairs: Repairs,
    counted_to: usize,
}

impl Conditioner {
    /// A conditioner for one trajectory, by a plan made from its first part.
    pub fn new(plan: SignalPlan) -> Self {
        let overlap = plan.reach();
        let next = plan.trim;
        Self {
            plan,
            overlap,
            waiting: Raw::default(),
            origin: None,
            rows_before: 0,
            next,
            repairs: Repairs::default(),
            counted_to: 0,
        }
    }

    /// Takes the next rows and hands out those that are done, in order.
    ///
    /// # Errors
    /// Those of [`condition`](crate::signals::condition()), and [`MotionError::Block`] if the block has
    /// other joints or signals than the first. Rows are counted from the first of the trajectory,
    /// those of shapes and values from the first of the block.
    pub fn push(&mut self, block: Raw) -> Result<Vec<Motion>> {
        block.check()?;
        if block.joints != self.plan.joints {
            return Err(MotionError::Block);
        }
        let Some(&first) = block.t.first() else { return Ok(Vec::new()) };
        if self.waiting.t.last().is_some_and(|last| first <= *last) {
            return Err(MotionError::TimeOrder { row: self.rows_before + self.waiting.t.len() });
        }
        let mut pairs = self.waiting.signals.iter().zip(&block.signals);
        if self.origin.is_some() && pairs.any(|(waiting, new)| waiting.is_some() != new.is_some()) {
            return Err(MotionError::Block);
        }
        self.origin.get_or_insert(first);
        let new = self.waiting.t.len().saturating_sub(1);
        self.waiting.append(block);
        count_gaps(&self.waiting.t[new..], self.plan.rate, &mut self.repairs);
        let part = PART_ROWS.max(4 * self.overlap) + 2 * self.overlap;
        let mut done = Vec::new();
        while self.waiting.t.len() >= part {
            done.extend(self.work_off(part, false)?);
        }
        Ok(done)
    }

    /// Hands out the rest.
    ///
    /// # Errors
    /// Those of [`Conditioner::push`].
    pub fn finish(&mut self) -> Result<Vec<Motion>> {
        if self.waiting.t.is_empty() {
            return Ok(Vec::new());
        }
        let rows = self.waiting.t.len();
        Ok(self.work_off(rows, true)?.into_iter().collect())
    }

    /// Conditions the first `rows` that wait, hands out those of them that no later row can
    /// change, and forgets those that no row to come depends on.
    fn work_off(&mut self, rows: usize, last: bool) -> Result<Option<Motion>> {
        let part = self.waiting.select(&(0..rows).collect::<Vec<_>>());
        let origin = self.origin.unwrap_or_default();
        let even = clean(&part, &self.plan.base, (origin, self.rows_before))?;
        // Each replaced row counts once, though parts overlap: a row belongs to the part in which it
        // lies before the overlap begins.
        let counted_to = self.rows_before + if last { rows } else { rows - self.overlap };
        for Outliers { signal, rows, .. } in &even.outliers {
            let new = rows.iter().filter(|row| (self.counted_to..counted_to).contains(*row));
            self.repairs.add_spikes(signal, new.count() as u64);
        }
        self.counted_to = counted_to;
        let SignalPlan { cutoff, rate, settings, .. } = self.plan;
        let filtered = filter(&even.columns, cutoff, rate)?;
        let smooth = smooth(&filtered, &even.columns, rate, settings.delay)?;
        let held_back = if last { self.plan.trim } else { self.overlap };
        let end = (even.first + even.columns.t.len()).saturating_sub(held_back).max(self.next);
        let motion = kept(&smooth, even.first, self.next..end, self.plan.keep_every);
        self.next = end;
        let needed = end.saturating_sub(self.overlap);
        let forgotten = if self.plan.base.timing.is_even() {
            needed.saturating_sub(self.rows_before)
        } else {
            let from = origin + needed as f64 / self.plan.rate;
            self.waiting.t.partition_point(|t| *t < from)
        };
        self.waiting.forget(forgotten);
        self.rows_before += forgotten;
        Ok(motion)
    }
}

#[cfg(test)]
mod tests;
