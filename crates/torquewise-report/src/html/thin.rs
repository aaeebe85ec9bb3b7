//! Thinned points to draw: from left to right, few, with every peak among them.

use crate::html::chart::Series;
use torquewise_stepwise::evenly;

/// Points of a chart at most, per curve.
pub(crate) const MOST_POINTS: usize = 4_000;

/// The points that have an x that can be drawn, from left to right.
pub(crate) fn sorted(series: &Series, log: bool) -> Series {
    let drawable = |row: &usize| {
        let x = series.points[*row][0];
        x.is_finite() && (!log || x > 0.0)
    };
    let mut rows: Vec<usize> = (0..series.points.len()).filter(drawable).collect();
    rows.sort_by(|&a, &b| series.points[a][0].total_cmp(&series.points[b][0]));
    picked(series, &rows)
}

/// Some points of a series, with error bars if each of all has one.
pub(crate) fn picked(series: &Series, rows: &[usize]) -> Series {
    let has_bars = series.spread.len() == series.points.len();
    let bars = rows.iter().filter(|_| has_bars).map(|&row| series.spread[row]);
    let points = rows.iter().map(|&row| series.points[row]).collect();
    Series { label: series.label.clone(), points, spread: bars.collect(), ..*series }
}

/// Rows that draw curves over the same abscissae with at most `most` points: of each of a number of
/// stretches the first, and of each curve the lowest and the highest; and the last row of all. A
/// gap, which is not a number, stays one.
fn rows_of_curves(curves: &[&[[f64; 2]]], most: usize) -> Vec<usize> {
    let m = curves[0].len();
    if m <= most {
        return (0..m).collect();
    }
    let slots = (most.saturating_sub(1) / (1 + 3 * curves.len())).max(1);
    let mut rows = Vec::with_capacity(most);
    for slot in 0..slots {
        let (first, end) = (slot * m / slots, (slot + 1) * m / slots);
        let start = rows.len();
        rows.push(first);
        for curve in curves {
            let value = |row: &usize| curve[*row][1];
            let by_value = |a: &usize, b: &usize| value(a).total_cmp(&value(b));
            let finite = || (first..end).filter(|row| value(row).is_finite());
            rows.extend(finite().min_by(by_value));
            rows.extend(finite().max_by(by_value));
            rows.extend((first..end).find(|row| value(row).is_nan()));
        }
        rows[start..].sort_unstable();
    }
    rows.push(m - 1);
    rows.dedup();
    rows
}

/// Rows to draw of series over the same abscissae.
pub(crate) fn rows_of(all: &[&Series]) -> Vec<usize> {
    if !all[0].mark.is_line() {
        return evenly(all[0].points.len(), MOST_POINTS);
    }
    rows_of_curves(&all.iter().map(|own| &*own.points).collect::<Vec<_>>(), MOST_POINTS)
}

/// A curve that is thinned while it grows, so that one of any length takes little memory.
#[derive(Clone, Debug)]
pub struct Growing {
    points: Vec<[f64; 2]>,
    /// Points in front that are thinned already.
    thinned: usize,
    block: usize,
}

/// Points that a stretch of a thinned curve has: first, lowest, highest and a gap.
const SLOT: usize = 4;

impl Default for Growing {
    fn default() -> Self {
        Self { points: Vec::new(), thinned: 0, block: SLOT }
    }
}

impl Growing {
    /// Appends a point to the right of all others.
    pub fn push(&mut self, point: [f64; 2]) {
        self.points.push(point);
        if self.points.len() - self.thinned == self.block {
            self.thin(self.thinned, SLOT);
            if self.thinned > 2 * MOST_POINTS {
                self.thin(0, MOST_POINTS);
                self.block *= 2;
            }
        }
    }

    fn thin(&mut self, start: usize, most: usize) {
        let tail = self.points.split_off(start);
        let rows = rows_of_curves(&[&tail], most);
        self.points.extend(rows.into_iter().map(|row| tail[row]));
        self.thinned = self.points.len();
    }

    /// What is left of it, from left to right.
    pub fn into_points(self) -> Vec<[f64; 2]> {
        self.points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_growing_curve_stays_short_and_keeps_peaks_and_ends() {
        let m = 1_000_000;
        let mut curve = Growing::default();
        for row in 0..m {
            let peak = [(777, 9.0), (500_001, -7.0)].into_iter().find(|(at, _)| *at == row);
            curve.push([f64::from(row), peak.map_or(0.0, |(_, height)| height)]);
        }

        let points = curve.into_points();

        assert!((MOST_POINTS / 2..4 * MOST_POINTS).contains(&points.len()), "{}", points.len());
        for point in [[0.0, 0.0], [777.0, 9.0], [500_001.0, -7.0], [f64::from(m - 1), 0.0]] {
            assert!(points.contains(&point), "{point:?}");
        }
        assert!(points.windows(2).all(|pair| pair[0][0] < pair[1][0]), "in order");
    }

    #[test]
    fn thinned_curves_keep_their_peaks_gaps_and_ends() {
        let m = 100_000;
        let mut first = vec![[0.0; 2]; m];
        let mut second = first.clone();
        (first[777][1], second[50_001][1], second[90_000][1]) = (9.0, -7.0, f64::NAN);

        let rows = rows_of_curves(&[&first, &second], MOST_POINTS);

        assert!(rows.len() <= MOST_POINTS);
        for row in [0, 777, 50_001, 90_000, m - 1] {
            assert!(rows.contains(&row), "{row}");
        }
        assert!(rows.windows(2).all(|pair| pair[0] < pair[1]), "in order");
    }
}
