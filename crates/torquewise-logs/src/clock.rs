//! Rows at the times they were sampled: held rows left out, late stamps corrected.

use torquewise_motion::signals::lagrange;
use torquewise_motion::{Raw, Repairs, Signal, median};

/// Repeats of position and torque that a logger faster than its device may make; a longer run is an
/// arm at rest.
const FEW_HELD: usize = 3;
/// Where at least so many runs are about as long as each other, they may hold so many repeats: the
/// device is much slower.
const LIKE_RUNS: usize = 32;
const MOST_HELD: usize = 30;
/// Held rows that a log has at least, of those in motion, if its logger is faster than its device.
const LEAST_HELD: f64 = 0.02;
/// A joint that goes on by at most so many steps of its encoder may have stood still: its repeats are
/// no held rows.
const FEW_STEPS: f64 = 2.0;
/// Rows to each side that the clock of a device is found from.
const WINDOW: usize = 32;
/// A step over so many usual ones is a gap, over which no clock is found.
const GAP: f64 = 3.5;
/// Fewer rows between gaps tell nothing of a clock.
const LEAST_ROWS: usize = 8;
/// Stamps are corrected if positions follow their neighbours so much better afterwards: the root of
/// the mean square of what they are off falls to this part.
const BETTER: f64 = 0.9;

/// How the time stamps of logs are corrected, decided once for all of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct ClockRepair {
    /// Rows that repeat position and torque of the one before are left out, so many of a run: the
    /// device was slower than the logger.
    pub(crate) held: usize,
    /// Stamps are those of late receipt: the device sampled evenly.
    pub(crate) late: bool,
}

impl ClockRepair {
    pub(crate) fn of(pieces: &[Raw]) -> Self {
        let mut repeats = Vec::new();
        for piece in pieces {
            let repeat = repeated(piece, &mut Held::default());
            let is_last = |row: usize| repeat.get(row + 1).is_none_or(|next| *next == 0);
            let goes_on = moving(piece.of(Signal::Q));
            let ends =
                (0..repeat.len()).filter(|&row| is_last(row) && goes_on.get(row) == Some(&true));
            repeats.extend(ends.map(|row| repeat[row]));
        }
        let rows: usize = repeats.iter().map(|repeats| repeats + 1).sum();
        repeats.sort_unstable();
        let at = |part: usize| repeats.get(part * repeats.len() / 10).copied().unwrap_or_default();
        let is_even = repeats.len() >= LIKE_RUNS && at(9) <= 2 * at(1);
        let most = if is_even { FEW_HELD.max(2 * at(5)).min(MOST_HELD) } else { FEW_HELD };
        let dropped: usize = repeats.iter().filter(|repeats| **repeats <= most).sum();
        let held = if dropped as f64 > LEAST_HELD * rows as f64 { most } else { 0 };
        let mut off = [0.0, 0.0];
        for piece in pieces {
            let kept = (held > 0).then(|| without_held(piece, held, &mut Held::default()));
            let piece = kept.as_ref().unwrap_or(piece);
            let mended = mended(&piece.t);
            off[0] += roughness(&piece.t, piece.of(Signal::Q));
            off[1] += roughness(&mended, piece.of(Signal::Q));
        }
        Self { held, late: off[1] < BETTER * BETTER * off[0] }
    }
}

/// The last row of a trajectory that was read, and how often it was repeated.
#[derive(Clone, Debug, Default)]
pub(crate) struct Held {
    last: Vec<f64>,
    run: usize,
}

/// How often each row repeats what one before began.
fn repeated(block: &Raw, state: &mut Held) -> Vec<usize> {
    // Velocities may have been derived after the device, so that they never repeat.
    let columns = || block.of(Signal::Q).iter().chain(block.of(Signal::Tau));
    let mut found = Vec::with_capacity(block.t.len());
    for row in 0..block.t.len() {
        let values: Vec<f64> = columns().map(|x| x[row]).collect();
        state.run = if values == state.last { state.run + 1 } else { 0 };
        state.last = values;
        found.push(state.run);
    }
    found
}

/// Whether a joint goes on from each row by more than a few steps of its encoder.
fn moving(q: &[Vec<f64>]) -> Vec<bool> {
    let mut moving = vec![false; q.first().map_or(0, Vec::len)];
    for x in q {
        let steps = || x.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        let least = steps().filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min);
        let far = steps().map(|step| step > FEW_STEPS * least);
        moving.iter_mut().zip(far).for_each(|(moving, far)| *moving |= far);
    }
    moving
}

/// Velocities become means over what was held: differences of held positions are zero in between.
fn without_held(block: &Raw, most: usize, state: &mut Held) -> Raw {
    let repeated = repeated(block, state);
    let is_held = |row: &usize| (1..=most).contains(&repeated[*row]);
    let rows: Vec<usize> = (0..block.t.len()).filter(|row| !is_held(row)).collect();
    let mut kept = block.select(&rows);
    let velocities = kept.signals[Signal::Dq as usize].iter_mut().flatten();
    for (own, all) in velocities.zip(block.of(Signal::Dq)) {
        let ends = rows.iter().skip(1).copied().chain([all.len()]);
        let runs = rows.iter().zip(ends).map(|(&begin, end)| &all[begin..end]);
        *own = runs.map(|run| run.iter().sum::<f64>() / run.len() as f64).collect();
    }
    kept
}

/// Stamps on the line of least squares through those around them, between gaps.
fn mended(t: &[f64]) -> Vec<f64> {
    let usual = median(&mut t.windows(2).map(|pair| pair[1] - pair[0]).collect::<Vec<_>>());
    let mut out = Vec::with_capacity(t.len());
    for run in t.chunk_by(|before, after| after - before <= GAP * usual) {
        let mended = |row: usize| {
            let first = row.saturating_sub(WINDOW);
            on_line(&run[first..(row + WINDOW + 1).min(run.len())], row - first)
        };
        let is_long = run.len() >= LEAST_ROWS;
        out.extend((0..run.len()).map(|row| if is_long { mended(row) } else { run[row] }));
    }
    if out.windows(2).all(|pair| pair[0] < pair[1]) { out } else { t.to_vec() }
}

/// The value at a row of the line of least squares through stamps over their rows.
fn on_line(t: &[f64], row: usize) -> f64 {
    let count = t.len() as f64;
    let middle = 0.5 * (count - 1.0);
    let mean = t.iter().map(|x| x - t[0]).sum::<f64>() / count;
    let (mut products, mut squares) = (0.0, 0.0);
    for (k, x) in t.iter().enumerate() {
        let off = k as f64 - middle;
        products += off * (x - t[0] - mean);
        squares += off * off;
    }
    t[0] + mean + products / squares * (row as f64 - middle)
}

/// Square of what positions are off the cubic through the two rows on each side, over that of their
/// steps, each at the median over the rows; the sum of the joints.
fn roughness(t: &[f64], q: &[Vec<f64>]) -> f64 {
    let mut sum = 0.0;
    for x in q {
        let off = |k: usize| {
            let at = [k - 2, k - 1, k + 1, k + 2];
            let weights = lagrange(&at.map(|row| t[row]), t[k]);
            let between: f64 = weights.iter().zip(at).map(|(w, row)| w * (x[row] - x[k])).sum();
            between * between
        };
        let mut steps: Vec<f64> = x.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).collect();
        let steps = median(&mut steps);
        if steps > 0.0 {
            let mut off: Vec<f64> = (2..x.len().saturating_sub(2)).map(off).collect();
            sum += median(&mut off) / steps;
        }
    }
    sum
}

/// Mends the clock of one trajectory, block by block: what comes out depends on the rows alone, not
/// on how they are cut.
#[derive(Clone, Debug, Default)]
pub(crate) struct ClockLane {
    repair: ClockRepair,
    held: Held,
    /// Rows that wait for those after them, or are needed by those.
    waiting: Raw,
    /// Of these, rows that were handed out.
    done: usize,
    /// Rows left out and stamps moved so far.
    pub(crate) repairs: Repairs,
}

impl ClockLane {
    pub(crate) fn new(repair: ClockRepair) -> Self {
        Self { repair, ..Self::default() }
    }

    pub(crate) fn push(&mut self, mut block: Raw) -> Option<Raw> {
        if self.repair.held > 0 {
            let rows = block.t.len();
            block = without_held(&block, self.repair.held, &mut self.held);
            self.repairs.held_rows += (rows - block.t.len()) as u64;
        }
        if !self.repair.late {
            return Some(block).filter(|block| !block.t.is_empty());
        }
        self.waiting.append(block);
        let out = self.hand_out(self.waiting.t.len().saturating_sub(WINDOW));
        // A gap before the window, and the usual step, are found from rows long done.
        let forgotten = self.done.saturating_sub(MEMORY);
        self.done -= forgotten;
        self.waiting.forget(forgotten);
        out
    }

    pub(crate) fn finish(&mut self) -> Option<Raw> {
        self.hand_out(self.waiting.t.len())
    }

    fn hand_out(&mut self, known: usize) -> Option<Raw> {
        if known <= self.done {
            return None;
        }
        let waiting = &self.waiting;
        let t = mended(&waiting.t);
        let rows: Vec<usize> = (self.done..known).collect();
        let mut out = waiting.select(&rows);
        out.t = rows.iter().map(|&row| t[row]).collect();
        let moved = rows.iter().filter(|&&row| t[row].to_bits() != waiting.t[row].to_bits());
        self.repairs.late_stamps += moved.count() as u64;
        self.done = known;
        Some(out)
    }
}

/// Rows that are remembered once they are done.
const MEMORY: usize = 4 * WINDOW;

#[cfg(test)]
mod tests;
