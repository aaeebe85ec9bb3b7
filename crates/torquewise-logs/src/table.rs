//! Columns of values as CSV or Parquet, written whole or not at all.

use crate::error::{LogError, Result};
use crate::format::Format;
#[cfg(feature = "formats")]
use crate::parquet_sink::ParquetSink;
use crate::sink::{Column, CsvSink, Sink, Values};
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
    pub fn create(file: &Path, columns: &[Column]) -> Result<Self> {
        Self::start(file, columns, None)
    }

    /// The same of a file that keeps joint names: in the metadata of a `.parquet` file, in the first
    /// line (`# joints: …`) of a `.csv` file.
    pub(crate) fn start(file: &Path, columns: &[Column], joints: Option<&str>) -> Result<Self> {
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
    /// [`LogError::Unusable`] if the values do not fit the columns; [`LogError::Write`].
    pub fn append(&mut self, values: &[Values<'_>]) -> Result<()> {
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
    pub fn finish(self) -> Result<()> {
        self.sink.finish()
    }

    fn check(&self, values: &[Values<'_>]) -> Result<()> {
        let misfit = |problem: String| {
            let help = "give values for the columns it was created with, one per row";
            Err(LogError::unusable(self.file.display(), &format!(": {problem}"), help))
        };
        let (found, expected) = (values.len(), self.columns.len());
        if found != expected {
            return misfit(format!("{found} columns of values for a table of {expected}"));
        }
        let rows = values.first().map_or(0, |first| first.len());
        for (Column { name, kind }, values) in self.columns.iter().zip(values) {
            let (found, expected) = (values.name(), kind.name());
            if found != expected {
                return misfit(format!(
                    "column {name} is to hold {expected}, but {found} is given"
                ));
            }
            let found = values.len();
            if found != rows {
                return misfit(format!("column {name} has {found} values, the first {rows}"));
            }
        }
        Ok(())
    }
}
