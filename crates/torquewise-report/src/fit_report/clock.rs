//! One clock for several trajectories: end to end, with a gap between them.

use crate::{Colour, Stretches};
use torquewise_motion::Pattern;
use torquewise_stepwise::evenly;

pub(crate) const LABEL: &str = "time [s]";

/// A step this many times the usual one is a break, not a part of the motion.
const BREAK: f64 = 20.0;

/// Stretches over time of each pattern that is there; none reaches over a break in the time.
pub fn pattern_bands(t: &[f64], patterns: &[Pattern]) -> Vec<Stretches> {
    Clock::new(t).bands(patterns)
}

/// A clock that starts at zero and never goes back.
pub(crate) struct Clock {
    /// Time of each row \[s\].
    pub(crate) t: Vec<f64>,
    /// Whether each row does not follow the one before it.
    breaks: Vec<bool>,
}

impl Clock {
    /// Strings trajectories together: where time goes back or leaps, the next one begins one usual
    /// step later.
    pub(crate) fn new(stamps: &[f64]) -> Self {
        let mut steps: Vec<f64> =
            stamps.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
        steps.sort_by(f64::total_cmp);
        let usual = steps.get(steps.len() / 2).copied().unwrap_or(1.0);
        let mut clock = Self { t: Vec::with_capacity(stamps.len()), breaks: Vec::new() };
        let mut now = 0.0;
        for (row, stamp) in stamps.iter().enumerate() {
            let mut is_break = false;
            if let Some(before) = row.checked_sub(1).map(|before| stamps[before]) {
                let step = stamp - before;
                let follows = step > 0.0 && step <= BREAK * usual;
                is_break = !follows;
                now += if follows { step } else { usual };
            }
            clock.t.push(now);
            clock.breaks.push(is_break);
        }
        clock
    }

    /// Rows of some seconds in the middle, evenly thinned to a number of them, two at least.
    pub(crate) fn middle(&self, seconds: f64, most: usize) -> Vec<usize> {
        let m = self.t.len();
        let surplus = 0.5 * (self.t.last().copied().unwrap_or_default() - seconds).max(0.0);
        let first = self.t.partition_point(|t| *t < surplus).min(m.saturating_sub(2));
        let end = self.t.partition_point(|t| *t <= surplus + seconds).max(first + 2).min(m);
        evenly(end - first, most).into_iter().map(|k| first + k).collect()
    }

    pub(crate) fn curve(&self, value: impl Fn(usize) -> f64) -> Vec<[f64; 2]> {
        let mut points = Vec::with_capacity(self.t.len());
        for (row, &t) in self.t.iter().enumerate() {
            if self.breaks[row] {
                points.push([0.5 * (self.t[row - 1] + t), f64::NAN]);
            }
            points.push([t, value(row)]);
        }
        points
    }

    pub(crate) fn bands(&self, patterns: &[Pattern]) -> Vec<Stretches> {
        let all = Pattern::ALL.map(|pattern| Stretches {
            label: pattern.name().into(),
            colour: Colour::Pattern(pattern),
            spans: self.spans(patterns, pattern),
        });
        all.into_iter().filter(|band| !band.spans.is_empty()).collect()
    }

    fn spans(&self, patterns: &[Pattern], pattern: Pattern) -> Vec<[f64; 2]> {
        let mut spans: Vec<[f64; 2]> = Vec::new();
        let mut is_open = false;
        for ((&t, &is_break), &own) in self.t.iter().zip(&self.breaks).zip(patterns) {
            match spans.last_mut().filter(|_| is_open) {
                // A stretch reaches to the first row of the next one.
                Some(span) if !is_break => span[1] = t,
                _ if own == pattern => spans.push([t, t]),
                _ => {}
            }
            is_open = own == pattern;
        }
        spans
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Pattern::{Standstill, VariableVelocity};

    #[test]
    fn trajectories_are_strung_together_with_a_gap_over_which_no_band_reaches() {
        let clock = Clock::new(&[1.7e9, 1.7e9 + 0.5, 1.7e9 + 1.0, 0.0, 0.5, 90.0]);

        assert_eq!(clock.t, [0.0, 0.5, 1.0, 1.5, 2.0, 2.5]);
        let curve = clock.curve(|row| row as f64);
        assert_eq!((curve[2], curve[4]), ([1.0, 2.0], [1.5, 3.0]));
        assert!(curve[3][1].is_nan() && curve[6][1].is_nan());
        assert_eq!(curve.len(), 8);
        let clock = Clock::new(&[0.0, 1.0, 2.0, 3.0, 0.0, 1.0]);
        let patterns =
            [Standstill, Standstill, VariableVelocity, Standstill, Standstill, Standstill];

        let bands = clock.bands(&patterns);

        assert_eq!(bands.len(), 2);
        assert_eq!(bands[0].spans, [[0.0, 2.0], [3.0, 3.0], [4.0, 5.0]]);
        assert_eq!(bands[1].spans, [[2.0, 3.0]]);
    }
}
