//! Where values of a table go: a temporary file that takes its place when it is whole.

use crate::columns::{Column, Values};
use crate::error::LogError;
use crate::joints::CSV_COMMENT;
use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use torquewise_motion::whole_file::Output;

/// Where the values of a table go; they were checked before.
pub(crate) trait Sink {
    fn append(&mut self, values: &[Values<'_>], rows: usize) -> Result<(), LogError>;

    fn finish(self: Box<Self>) -> Result<(), LogError>;
}

/// A CSV file in the making.
pub(crate) struct CsvSink {
    file: PathBuf,
    writer: csv::Writer<Output>,
    number: String,
}

impl CsvSink {
    pub(crate) fn create(
        file: &Path,
        columns: &[Column],
        joints: Option<&str>,
    ) -> Result<Self, LogError> {
        let mut output = Output::create(file).map_err(write_error(file))?;
        if let Some(joints) = joints {
            writeln!(output, "{CSV_COMMENT} {joints}").map_err(write_error(file))?;
        }
        let mut writer = csv::WriterBuilder::new().comment(Some(b'#')).from_writer(output);
        let header = writer.write_record(columns.iter().map(|column| &column.name));
        header.map_err(|source| write_error(file)(source.into()))?;
        Ok(Self { file: file.into(), writer, number: String::new() })
    }

    fn write_row(&mut self, values: &[Values<'_>], row: usize) -> csv::Result<()> {
        for column in values {
            self.number.clear();
            match column {
                // The shortest digits that are read back to the same bits.
                Values::Numbers(values) => write!(self.number, "{:?}", values[row]),
                Values::Counts(values) => write!(self.number, "{}", values[row]),
                Values::Texts(values) => self.number.write_str(values[row]),
            }
            .map_err(io::Error::other)?;
            self.writer.write_field(&self.number)?;
        }
        self.writer.write_record(None::<&[u8]>)
    }
}

impl Sink for CsvSink {
    fn append(&mut self, values: &[Values<'_>], rows: usize) -> Result<(), LogError> {
        for row in 0..rows {
            self.write_row(values, row).map_err(|source| write_error(&self.file)(source.into()))?;
        }
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), LogError> {
        let written = self.writer.into_inner().map_err(csv::IntoInnerError::into_error);
        let written = written.map_err(write_error(&self.file))?;
        written.put_in_place().map_err(write_error(&self.file))
    }
}

pub(crate) fn write_error(file: &Path) -> impl Fn(io::Error) -> LogError {
    move |source| LogError::Write { file: file.into(), source }
}
