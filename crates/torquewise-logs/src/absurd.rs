//! Rows with a value that no motion leads to: a flipped bit, a sensor that dropped out.

use torquewise_motion::{LARGEST, Signal, median};

/// Rows in a row that may be absurd; more are taken for what happened.
pub(crate) const LONGEST: usize = 3;
/// Rows of a stretch whose values are larger than usual: these at least, and one in so many.
const LARGER: (usize, usize) = (3, 200);
/// A stretch of fewer rows does not tell what is usual.
const LEAST_ROWS: usize = 64;
/// A value is absurd beyond so many times what is usual in its stretch.
const TIMES: f64 = 20.0;

/// No value of q, q̇, q̈ or τ below this is absurd \[rad, rad/s, rad/s², N·m\].
const LEAST: [f64; 4] = [std::f64::consts::TAU, 5.0, 100.0, 10.0];
/// Numbers beyond are of a damaged file, which is to fail as a whole.
const DAMAGED: f64 = 1e9;
/// Where more than this part of a stretch is so, it is in another unit.
const OTHER_UNIT: f64 = 0.25;

/// Rows on each side that a position is compared with: more than are absurd.
pub(crate) const NEAR: usize = LONGEST + 1;

/// Rows of a column, ascending, that stand out alone: farther from the median than 20 times all but
/// the largest few, or a position farther than a turn from half of those before and of
/// those after; at most three beside each other.
pub(crate) fn absurd(x: &[f64], signal: Signal) -> Vec<usize> {
    let (few, part) = LARGER;
    if x.len() < LEAST_ROWS {
        return Vec::new();
    }
    let kept = x.len() - 1 - few.max(x.len() / part);
    let mut sorted = x.to_vec();
    let median = median(&mut sorted);
    for x in &mut sorted {
        *x = (*x - median).abs();
    }
    let (_, usual, _) = sorted.select_nth_unstable_by(kept, f64::total_cmp);
    let least = LEAST[signal as usize];
    let most = (TIMES * *usual).max(least);
    let jumps = signal == Signal::Q && x.windows(2).any(|pair| (pair[1] - pair[0]).abs() > least);
    // From the rows before and from those after: a step that lasts is none.
    let stands_off = |row: usize| {
        let sides = [row.saturating_sub(NEAR)..row, row + 1..(row + 1 + NEAR).min(x.len())];
        sides.into_iter().all(|side| {
            let far = x[side.clone()].iter().filter(|other| (x[row] - **other).abs() > least);
            !side.is_empty() && 2 * far.count() >= side.len()
        })
    };
    let is_off = |row: &usize| (x[*row] - median).abs() > most || jumps && stands_off(*row);
    let off: Vec<usize> = (0..x.len()).filter(is_off).collect();
    let runs = off.chunk_by(|a, b| a + 1 == *b).filter(|run| run.len() <= LONGEST);
    runs.flatten().copied().collect()
}

/// Rows of a column, ascending, however many beside each other, with values that no joint has and that
/// come or go from one row to the next.
pub(crate) fn impossible(x: &[f64], signal: Signal) -> Vec<usize> {
    if x.len() < LEAST_ROWS {
        return Vec::new();
    }
    let most = LARGEST[signal as usize];
    let ends = |pick: fn(f64, f64) -> f64| x.iter().copied().reduce(pick);
    if ends(f64::max).zip(ends(f64::min)).is_none_or(|(high, low)| high - low < most) {
        return Vec::new();
    }
    let median = median(&mut x.to_vec());
    let is_beyond = |row: &usize| (most..DAMAGED).contains(&(x[*row] - median).abs());
    let beyond: Vec<usize> = (0..x.len()).filter(is_beyond).collect();
    if beyond.len() as f64 > OTHER_UNIT * x.len() as f64 {
        return Vec::new();
    }
    let is_step = |row: usize| row > 0 && row < x.len() && (x[row] - x[row - 1]).abs() >= most;
    let runs = beyond.chunk_by(|a, b| a + 1 == *b);
    let runs = runs.filter(|run| is_step(run[0]) || is_step(run[run.len() - 1] + 1));
    runs.flatten().copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sine() -> Vec<f64> {
        (0..600).map(|row| (0.05 * f64::from(row)).sin()).collect()
    }

    #[test]
    fn what_no_joint_does_is_impossible_however_long_it_lasts_unless_the_unit_is_another() {
        let with = |rows: std::ops::Range<usize>, value: f64, factor: f64| {
            let mut x: Vec<f64> = sine().iter().map(|x| factor * x).collect();
            x[rows].fill(value);
            x
        };
        let rows = |rows: std::ops::Range<usize>| rows.collect::<Vec<usize>>();
        let cases: [(_, _, Vec<usize>); 8] = [
            (with(100..105, 1e12, 1.0), Signal::Q, Vec::new()),
            (with(100..105, 1e3, 1.0), Signal::Q, rows(100..105)),
            (with(100..110, -1e3, 1.0), Signal::Dq, rows(100..110)),
            (with(570..600, 2e5, 40.0), Signal::Tau, rows(570..600)),
            (with(0..0, 0.0, 57.3), Signal::Q, Vec::new()),
            (with(0..0, 0.0, 500.0), Signal::Dq, Vec::new()),
            (with(100..300, 1e3, 1.0), Signal::Dq, Vec::new()),
            (with(300..310, 20.0, 0.0), Signal::Q, Vec::new()),
        ];

        for (case, (x, signal, expected)) in cases.into_iter().enumerate() {
            assert_eq!(impossible(&x, signal), expected, "case {case}");
        }
    }

    #[test]
    fn rows_that_stand_out_alone_and_positions_that_leave_by_a_turn_and_come_back_are_absurd() {
        let mut alone = sine();
        (alone[100], alone[101], alone[400]) = (1e3, -1e6, 1e300);
        let mut flickers = vec![0.0; 600];
        flickers[300] = 1e-3;
        let mut moved = vec![0.0; 600];
        moved[300..310].fill(20.0);
        let mut turned: Vec<f64> = sine().iter().map(|x| 3.0 * x).collect();
        (turned[300], turned[301], turned[302]) = (40.0, 40.0, 40.0);
        // An encoder that wraps.
        let wrapped: Vec<f64> = (0..600).map(|row| (0.1 * f64::from(row)) % 7.0).collect();
        let mut fallen = sine();
        fallen[596..].fill(-9.0);
        let cases: [(_, _, &[usize]); 7] = [
            (alone, Signal::Dq, &[100, 101, 400]),
            (sine(), Signal::Dq, &[]),
            (flickers, Signal::Dq, &[]),
            (moved, Signal::Dq, &[]),
            (turned, Signal::Q, &[300, 301, 302]),
            (fallen, Signal::Q, &[]),
            (wrapped, Signal::Q, &[]),
        ];

        for (case, (x, signal, expected)) in cases.into_iter().enumerate() {
            assert_eq!(absurd(&x, signal), expected, "case {case}");
        }
    }
}
