//! From rows roughly in order of time to rows in order, from a window of bounded length.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// Values that a window holds at most, about 16 MB; it is never shorter than 1 024 rows.
const WINDOW_VALUES: usize = 1 << 21;

/// A row with its time stamp.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stamped {
    /// Time \[ns\].
    pub(super) stamp: i64,
    /// Number of its message, 1 for the first.
    pub(super) number: u64,
    pub(super) values: Vec<f64>,
}

/// Rows that wait until no earlier one can come.
#[derive(Debug, Default)]
pub(super) struct InOrder {
    waiting: BinaryHeap<Reverse<ByStamp>>,
    latest: Option<i64>,
    /// Rows that came after one with a later stamp.
    pub(super) n_late: u64,
}

impl InOrder {
    /// Whether a row may go out while others are still to come.
    pub(super) fn is_full(&self, columns: usize) -> bool {
        self.waiting.len() >= (WINDOW_VALUES / (columns + 4)).clamp(1_024, 1 << 16)
    }

    pub(super) fn push(&mut self, row: Stamped) {
        self.n_late += u64::from(self.latest.is_some_and(|latest| row.stamp < latest));
        self.latest = self.latest.max(Some(row.stamp));
        self.waiting.push(Reverse(ByStamp(row)));
    }

    /// The row with the earliest stamp.
    pub(super) fn pop(&mut self) -> Option<Stamped> {
        self.waiting.pop().map(|Reverse(ByStamp(row))| row)
    }
}

/// Rows compared by stamp, then in the order of the file.
#[derive(Debug)]
struct ByStamp(Stamped);

impl ByStamp {
    fn key(&self) -> (i64, u64) {
        (self.0.stamp, self.0.number)
    }
}

impl PartialEq for ByStamp {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}

impl Eq for ByStamp {}

impl PartialOrd for ByStamp {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for ByStamp {
    fn cmp(&self, other: &Self) -> Ordering {
        self.key().cmp(&other.key())
    }
}

#[cfg(test)]
mod tests {
    use super::{InOrder, Stamped};

    #[test]
    fn rows_come_out_by_stamp_and_late_ones_are_counted() {
        let mut rows = InOrder::default();
        for (number, stamp) in [(1, 10), (2, 30), (3, 20), (4, 30), (5, 5)] {
            rows.push(Stamped { stamp, number, values: Vec::new() });
        }

        let mut out = Vec::new();
        while let Some(row) = rows.pop() {
            out.push((row.stamp, row.number));
        }

        assert_eq!(out, [(5, 5), (10, 1), (20, 3), (30, 2), (30, 4)]);
        assert_eq!(rows.n_late, 2);
    }

    #[test]
    fn a_window_is_bounded_whatever_the_width() {
        let mut rows = InOrder::default();
        for number in 0..1_024 {
            assert!(!rows.is_full(1_000_000));
            rows.push(Stamped { stamp: 0, number, values: Vec::new() });
        }

        assert!(rows.is_full(1_000_000) && !rows.is_full(30));
    }
}
