//! Three recordings: poses held, then constant speeds, then constant accelerations.

use super::{ACCELERATION, PEAK_SPEED};
use crate::{State, between, direction};
use rand_chacha::ChaCha8Rng;
use torquewise_motion::whole;

/// Time \[s\] each pose is recorded.
const HOLD: f64 = 0.1;
/// Time \[s\] of a recorded sweep at constant speed.
const SWEEP: [f64; 2] = [0.6, 1.4];
/// Speeds of a joint \[rad/s\].
const SPEED: [f64; 2] = [0.3 * PEAK_SPEED, PEAK_SPEED];
/// Time \[s\] of a transfer at least, and its mean speed \[rad/s\].
const TRANSFER: f64 = 0.5;
const TRANSFER_SPEED: f64 = 1.0;
/// Rows that a transfer skips at least, so that its gap shows at any rate.
const GAP_ROWS: f64 = 5.0;

#[derive(Clone, Debug)]
pub(crate) struct Staged {
    arcs: Vec<Arc>,
    rate: f64,
}

/// Rows recorded in one go, at constant acceleration.
#[derive(Clone, Debug)]
struct Arc {
    first_row: usize,
    start: f64,
    from: State,
}

/// Draws how long an arc takes \[s\] and how n joints start it, wherever that is.
type Stage = fn(usize, &mut ChaCha8Rng) -> (f64, State);

impl Staged {
    /// Draws arcs, a third of the rows for each stage.
    pub(crate) fn draw(
        ranges: &[[f64; 2]],
        n_rows: usize,
        rate: f64,
        rng: &mut ChaCha8Rng,
    ) -> Self {
        let mut staged = Self { arcs: Vec::new(), rate };
        let stages: [Stage; 3] = [|n, _| (HOLD, State::at_rest(&vec![0.0; n])), sweep, accelerate];
        let mut first_row = 0;
        for (stage, last) in stages.into_iter().zip([n_rows / 3, 2 * n_rows / 3, n_rows]) {
            while first_row < last {
                let (seconds, mut from) = stage(ranges.len(), rng);
                // So that each joint stays in its range, slower where that is narrow.
                for (i, &[lower, upper]) in ranges.iter().enumerate() {
                    let [mut least, mut greatest] = reach(from.dq[i], from.ddq[i], seconds);
                    let slower = ((upper - lower) / (greatest - least)).min(1.0);
                    if slower < 1.0 {
                        for x in [&mut from.dq[i], &mut from.ddq[i], &mut least, &mut greatest] {
                            *x *= slower;
                        }
                    }
                    from.q[i] = between(rng, [lower - least, upper - greatest]);
                }
                let start = staged.next_start(first_row, &from.q);
                staged.arcs.push(Arc { first_row, start, from });
                first_row = last.min(first_row + whole((seconds * rate).round()).max(1));
            }
        }
        staged
    }

    pub(crate) fn state_at(&self, row: usize) -> (f64, State) {
        // The first begins at row 0.
        let arc = &self.arcs[self.arcs.partition_point(|arc| arc.first_row <= row) - 1];
        let t = (row - arc.first_row) as f64 / self.rate;
        let of_joint = |i: usize| {
            let [q, dq, ddq] = [arc.from.q[i], arc.from.dq[i], arc.from.ddq[i]];
            [q + t * (dq + t * ddq / 2.0), dq + t * ddq, ddq]
        };
        (arc.start + t, State::of_joints((0..arc.from.q.len()).map(of_joint)))
    }

    fn next_start(&self, first_row: usize, q: &[f64]) -> f64 {
        let Some(last_row) = first_row.checked_sub(1) else { return 0.0 };
        let (t, end) = self.state_at(last_row);
        let way = q.iter().zip(&end.q).map(|(to, from)| (to - from).abs()).fold(0.0, f64::max);
        t + (way / TRANSFER_SPEED).max(TRANSFER).max(GAP_ROWS / self.rate)
    }
}

/// Every joint moves at its own constant speed, in either direction.
fn sweep(n: usize, rng: &mut ChaCha8Rng) -> (f64, State) {
    let seconds = between(rng, SWEEP);
    (seconds, State { dq: speeds(n, rng), ..State::at_rest(&vec![0.0; n]) })
}

fn accelerate(n: usize, rng: &mut ChaCha8Rng) -> (f64, State) {
    let (before, after) = (speeds(n, rng), speeds(n, rng));
    let change: Vec<f64> = before.iter().zip(&after).map(|(from, to)| to - from).collect();
    let greatest = change.iter().fold(0.0, |most: f64, change| most.max(change.abs()));
    let seconds = greatest / between(rng, ACCELERATION);
    let ddq = change.iter().map(|change| change / seconds.max(f64::MIN_POSITIVE)).collect();
    (seconds, State { dq: before, ddq, ..State::at_rest(&vec![0.0; n]) })
}

fn speeds(n: usize, rng: &mut ChaCha8Rng) -> Vec<f64> {
    (0..n).map(|_| direction(rng) * between(rng, SPEED)).collect()
}

/// Least and greatest way \[rad\] from the start within `seconds`.
fn reach(dq: f64, ddq: f64, seconds: f64) -> [f64; 2] {
    let way = |t: f64| t * (dq + t * ddq / 2.0);
    let turning = if ddq == 0.0 { 0.0 } else { (-dq / ddq).clamp(0.0, seconds) };
    let ways = [0.0, way(seconds), way(turning)];
    [ways.into_iter().fold(0.0, f64::min), ways.into_iter().fold(0.0, f64::max)]
}

#[cfg(test)]
mod tests {
    #![expect(clippy::float_cmp, reason = "halves and quarters are exact")]

    use super::*;

    #[test]
    fn the_reach_of_an_arc_that_turns_back_is_its_turning_point() {
        assert_eq!(reach(1.0, -1.0, 2.0), [0.0, 0.5]);
        assert_eq!(reach(-1.0, 0.0, 2.0), [-2.0, 0.0]);
        assert_eq!(reach(0.0, 0.0, 2.0), [0.0, 0.0]);
    }
}
