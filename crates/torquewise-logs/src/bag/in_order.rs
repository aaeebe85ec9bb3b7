//! From rows roughly in order of time to rows in order, from a window of bounded length.

use std::collections::BTreeMap;

/// Values that a window holds at most, about 16 MB; it is never shorter than 1 024 rows.
const WINDOW_VALUES: usize = 1 << 21;

/// Rows that wait until no earlier one can come.
#[derive(Debug, Default)]
pub(super) struct InOrder {
    /// By time stamp \[ns\] and number of the message, 1 for the first.
    waiting: BTreeMap<(i64, u64), Vec<f64>>,
    latest: Option<i64>,
    /// Rows that came after one with a later stamp.
    pub(super) n_late: u64,
}

impl InOrder {
    /// Whether a row may go out while others are still to come.
    pub(super) fn is_full(&self, columns: usize) -> bool {
        self.waiting.len() >= (WINDOW_VALUES / (columns + 4)).clamp(1_024, 1 << 16)
    }

    pub(super) fn push(&mut self, stamp: i64, number: u64, values: Vec<f64>) {
        self.n_late += u64::from(self.latest.is_some_and(|latest| stamp < latest));
        self.latest = self.latest.max(Some(stamp));
        self.waiting.insert((stamp, number), values);
    }

    /// Number and values of the row with the earliest stamp.
    pub(super) fn pop(&mut self) -> Option<(u64, Vec<f64>)> {
        self.waiting.pop_first().map(|((_, number), values)| (number, values))
    }
}

#[cfg(test)]
mod tests {
    use super::InOrder;

    #[test]
    fn rows_come_out_by_stamp_and_late_ones_are_counted() {
        let mut rows = InOrder::default();
        for (number, stamp) in [(1, 10), (2, 30), (3, 20), (4, 30), (5, 5)] {
            rows.push(stamp, number, Vec::new());
        }

        let out = std::iter::from_fn(|| rows.pop()).map(|(number, _)| number);
        assert_eq!(out.collect::<Vec<_>>(), [5, 1, 3, 2, 4]);
        assert_eq!(rows.n_late, 2);
    }

    #[test]
    fn a_window_is_bounded_whatever_the_width() {
        let mut rows = InOrder::default();
        for number in 0..1_024 {
            assert!(!rows.is_full(1_000_000));
            rows.push(0, number, Vec::new());
        }

        assert!(rows.is_full(1_000_000) && !rows.is_full(30));
    }
}
