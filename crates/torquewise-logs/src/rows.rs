//! Log file → rows: what every format is decoded to, one row of numbers after the other.

use crate::error::{LogError, Place};
use crate::layout::Layout;

/// The rows of one log file, in order.
pub(crate) trait Rows {
    /// Which signals the rows hold.
    fn layout(&self) -> &Layout;

    /// Joint names, if the file keeps any.
    fn joints(&self) -> Option<&[String]>;

    /// Puts the next row into `row`, one finite value per slot of the layout; `false` at the end.
    fn next(&mut self, row: &mut [f64]) -> Result<bool, LogError>;

    /// Where the row last read stands.
    fn place(&self) -> Place;
}
