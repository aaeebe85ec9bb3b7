//! From work of a decoder to its result, also where it panics.

use crate::error::LogError;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// The decoder of another crate may panic on a damaged file; here that is an error like any other.
pub(crate) fn guarded<T>(
    file: &Path,
    work: impl FnOnce() -> Result<T, LogError>,
) -> Result<T, LogError> {
    catch_unwind(AssertUnwindSafe(work))
        .unwrap_or_else(|_| Err(LogError::Damaged { file: file.into() }))
}
