//! From file of arrays to names, shapes and elements: what NumPy and MATLAB files are decoded to.

use crate::error::LogError;
use std::collections::{BTreeMap, BTreeSet};

/// Bytes of an array at most, 2 GB.
pub(super) const MAX_BYTES: u64 = 1 << 31;

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

/// A file of arrays: names and shapes are known, elements are loaded when asked for.
pub(super) trait Arrays {
    fn arrays(&self) -> &[Array];

    /// The elements of some arrays, by their place in [`arrays`](Self::arrays), as stored.
    fn load(&self, wanted: &BTreeSet<usize>) -> Result<BTreeMap<usize, Vec<f64>>, LogError>;
}

impl Array {
    /// Instants along the longer side, and series along the other; a square has rows of instants.
    pub(super) fn instants_and_series(&self) -> (usize, usize) {
        (self.rows.max(self.columns), self.rows.min(self.columns))
    }

    /// The values of one series at all instants.
    pub(super) fn series(&self, elements: &[f64], series: usize) -> Vec<f64> {
        let (instants, _) = self.instants_and_series();
        let is_tall = self.rows >= self.columns;
        let element = |instant: usize| {
            let (row, column) = if is_tall { (instant, series) } else { (series, instant) };
            let at = match self.order {
                Order::ByRow => row * self.columns + column,
                Order::ByColumn => column * self.rows + row,
            };
            elements.get(at).copied().unwrap_or(f64::NAN)
        };
        (0..instants).map(element).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{Array, Order};

    #[test]
    fn time_runs_along_the_longer_side_however_elements_are_stored() {
        let array = |rows, columns, order| Array { name: "q".into(), rows, columns, order };
        let elements = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];

        let tall = array(3, 2, Order::ByRow);
        let flat = array(2, 3, Order::ByRow);
        assert_eq!((tall.instants_and_series(), flat.instants_and_series()), ((3, 2), (3, 2)));
        assert_eq!(tall.series(&elements, 1), [1.0, 3.0, 5.0]);
        assert_eq!(flat.series(&elements, 1), [3.0, 4.0, 5.0]);
        assert_eq!(array(3, 2, Order::ByColumn).series(&elements, 1), [3.0, 4.0, 5.0]);
        assert_eq!(array(2, 3, Order::ByColumn).series(&elements, 1), [1.0, 3.0, 5.0]);
    }
}
