//! From log file to rows: what every format is decoded to, named columns of numbers.

use crate::{Result, RowPlace};

/// The rows of one log file, in order, as they stand in it.
pub(crate) trait Rows {
    /// Names of the columns that can be chosen, as the file gives them less outer space, and of the
    /// joints where it tells.
    fn header(&self) -> (&[String], Option<&[String]>);

    fn names(&self) -> &[String] {
        self.header().0
    }

    fn joints(&self) -> Option<&[String]> {
        self.header().1
    }

    /// Chooses the columns that rows are made of, in their order; called before the first row.
    fn choose(&mut self, columns: &[usize]) -> Result<()>;

    /// Puts the next row into `row`, one value per chosen column; `false` at the end. A value that
    /// is not there is NaN.
    fn next(&mut self, row: &mut [f64]) -> Result<bool>;

    /// Where the row last read stands.
    fn place(&self) -> RowPlace;

    /// How many rows there are, if that is known before they are read.
    fn count(&self) -> Option<u64> {
        None
    }
}
