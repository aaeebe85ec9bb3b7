//! From columns of values to CSV or Parquet file, written whole or not at all.

use crate::columns::{Column, Values};
use crate::error::LogError;
use crate::format::Format;
use crate::joints;
#[cfg(feature = "formats")]
use crate::parquet_sink::ParquetSink;
use crate::sink::{CsvSink, Sink};
use std::path::{Path, PathBuf};

/// A table that is written block by block, in fixed memory.
///
/// The rows go to a temporary file in the same folder, which [`finish`](Self::finish) renames. A
/// writer dropped before that leaves nothing behind, and an older file of that name as it was.
pub struct TableWriter {
    file: PathBuf,
    columns: Vec<Column>,
    sink: Box<dyn Sink>,
}

impl TableWriter {
    /// Starts a `.csv` or `.parquet` file.
    ///
    /// # Errors
    /// [`LogError`] if the extension is another one or the folder cannot be written to.
    pub fn create(file: &Path, columns: &[Column]) -> Result<Self, LogError> {
        Self::start(file, columns, None)
    }

    /// Starts a file that keeps joint names: in the metadata of a `.parquet` file, in the first
    /// line (`# joints: …`) of a `.csv` file.
    ///
    /// # Errors
    /// As [`create`](Self::create), and [`LogError::JointName`] if a name cannot be kept.
    pub fn create_with_joints(
        file: &Path,
        columns: &[Column],
        joints: &[String],
    ) -> Result<Self, LogError> {
        Self::start(file, columns, Some(&joints::join(joints)?))
    }

    fn start(file: &Path, columns: &[Column], joints: Option<&str>) -> Result<Self, LogError> {
        let sink: Box<dyn Sink> = match Format::of(file)? {
            Format::Csv => Box::new(CsvSink::create(file, columns, joints)?),
            #[cfg(feature = "formats")]
            Format::Parquet => Box::new(ParquetSink::create(file, columns, joints)?),
            _ => {
                let problem = ": this format is only read";
                let help = "name the output .csv or .parquet";
                return Err(LogError::unusable(file.display(), problem, help));
            }
        };
        Ok(Self { file: file.into(), columns: columns.to_vec(), sink })
    }

    /// Writes some rows: one slice per column, all of the same length.
    ///
    /// # Errors
    /// [`LogError::ValuesCount`], [`LogError::ValuesKind`] or [`LogError::ValuesLength`] if the
    /// values do not fit the columns; [`LogError::Write`].
    pub fn append(&mut self, values: &[Values<'_>]) -> Result<(), LogError> {
        self.check(values)?;
        match values.first() {
            Some(first) if !first.is_empty() => self.sink.append(values, first.len()),
            _ => Ok(()),
        }
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// [`LogError::Write`]; the temporary file is then removed.
    pub fn finish(self) -> Result<(), LogError> {
        self.sink.finish()
    }

    fn check(&self, values: &[Values<'_>]) -> Result<(), LogError> {
        let file = || self.file.clone();
        let (found, expected) = (values.len(), self.columns.len());
        if found != expected {
            return Err(LogError::ValuesCount { file: file(), found, expected });
        }
        let rows = values.first().map_or(0, |first| first.len());
        for (column, values) in self.columns.iter().zip(values) {
            let name = || column.name.clone();
            if values.kind() != column.kind {
                let (found, expected) = (values.kind().name(), column.kind.name());
                return Err(LogError::ValuesKind { file: file(), column: name(), found, expected });
            }
            if values.len() != rows {
                let (found, expected) = (values.len(), rows);
                let column = name();
                return Err(LogError::ValuesLength { file: file(), column, found, expected });
            }
        }
        Ok(())
    }
}
