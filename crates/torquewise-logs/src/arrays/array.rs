//! From file of arrays to names, shapes and elements: what NumPy and MATLAB files are decoded to.

use crate::arrays::numbers::Numbers;
use crate::error::LogError;

/// Series of one array at most; a wider one, such as an image, is no signal of a robot.
const MAX_SERIES: usize = 256;

/// Columns of all arrays at most.
pub(super) const MAX_COLUMNS: usize = 10_000;

/// Bytes of the name of an array at most.
pub(super) const LONGEST_NAME: usize = 4_096;

/// How the elements of a matrix follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    ByRow,
    ByColumn,
}

/// A matrix of numbers with a name; a vector has one row or one column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Array {
    pub(super) name: String,
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) order: Order,
}

/// A file of arrays: names and shapes are known, elements are read when asked for.
pub(super) trait Arrays {
    fn arrays(&self) -> &[Array];

    /// The elements of an array from number `first` on, as stored; `array` is its place in
    /// [`arrays`](Self::arrays).
    fn numbers(&self, array: usize, first: u64) -> Result<Numbers, LogError>;
}

impl Array {
    /// Whether it holds signals: instants, and no more series than a robot has.
    pub(super) fn is_signal(&self) -> bool {
        let (instants, series) = self.instants_and_series();
        instants > 1 && (1..=MAX_SERIES).contains(&series) && self.name.len() <= LONGEST_NAME
    }

    /// Instants along the longer side, and series along the other; a square has rows of instants.
    pub(super) fn instants_and_series(&self) -> (usize, usize) {
        (self.rows.max(self.columns), self.rows.min(self.columns))
    }

    /// Whether the series of one instant stand side by side, rather than the instants of a series.
    pub(super) fn is_by_instant(&self) -> bool {
        (self.rows >= self.columns) == (self.order == Order::ByRow)
    }

    /// Elements; `None` where they cannot be counted.
    pub(super) fn count(&self) -> Option<u64> {
        u64::try_from(self.rows.checked_mul(self.columns)?).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::{Array, Order};

    #[test]
    fn scalars_images_and_long_names_are_no_signals() {
        let array = |name: &str, rows, columns| {
            Array { name: name.into(), rows, columns, order: Order::ByRow }.is_signal()
        };
        assert!(array("q", 2, 1) && array("q", 300, 256));
        assert!(!array("q", 1, 1) && !array("q", 0, 5) && !array("q", 300, 300));
        assert!(!array(&"q".repeat(5_000), 2, 1));
    }
}
