//! Values → bytes of a temporary file that takes its place when it is whole.

use crate::columns::{Column, ColumnKind, Values};
use crate::error::LogError;
use crate::joints::{CSV_COMMENT, PARQUET_KEY};
use arrow_array::{ArrayRef, Float64Array, RecordBatch, StringArray, UInt64Array};
use arrow_schema::{DataType, Field, Schema, SchemaRef};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tempfile::NamedTempFile;

/// Rows of a Parquet row group at most: what a reader and a writer have to hold.
const ROW_GROUP_ROWS: usize = 16_384;

/// Where the values of a table go; they were checked before.
pub(crate) trait Sink {
    fn append(&mut self, values: &[Values<'_>], rows: usize) -> Result<(), LogError>;

    fn finish(self: Box<Self>) -> Result<(), LogError>;
}

/// A CSV file in the making.
pub(crate) struct CsvSink {
    file: PathBuf,
    writer: csv::Writer<NamedTempFile>,
    number: String,
}

impl CsvSink {
    pub(crate) fn create(
        file: &Path,
        columns: &[Column],
        joints: Option<&str>,
    ) -> Result<Self, LogError> {
        let mut temporary = temporary(file)?;
        if let Some(joints) = joints {
            writeln!(temporary, "{CSV_COMMENT} {joints}").map_err(write_error(file))?;
        }
        let mut writer = csv::WriterBuilder::new().comment(Some(b'#')).from_writer(temporary);
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
        put_in_place(written.map_err(write_error(&self.file))?, &self.file)
    }
}

/// A Parquet file in the making.
pub(crate) struct ParquetSink {
    file: PathBuf,
    schema: SchemaRef,
    writer: ArrowWriter<NamedTempFile>,
}

impl ParquetSink {
    pub(crate) fn create(
        file: &Path,
        columns: &[Column],
        joints: Option<String>,
    ) -> Result<Self, LogError> {
        let field = |column: &Column| {
            let kind = match column.kind {
                ColumnKind::Number => DataType::Float64,
                ColumnKind::Count => DataType::UInt64,
                ColumnKind::Text => DataType::Utf8,
            };
            Field::new(&column.name, kind, false)
        };
        let schema = Arc::new(Schema::new(columns.iter().map(field).collect::<Vec<_>>()));
        let metadata = joints.map(|joints| vec![KeyValue::new(PARQUET_KEY.to_owned(), joints)]);
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_dictionary_enabled(false)
            .set_max_row_group_row_count(Some(ROW_GROUP_ROWS))
            .set_key_value_metadata(metadata)
            .build();
        let writer = ArrowWriter::try_new(temporary(file)?, schema.clone(), Some(properties));
        let writer = writer.map_err(parquet_error(file))?;
        Ok(Self { file: file.into(), schema, writer })
    }
}

impl Sink for ParquetSink {
    fn append(&mut self, values: &[Values<'_>], _rows: usize) -> Result<(), LogError> {
        let array = |values: &Values<'_>| -> ArrayRef {
            match values {
                Values::Numbers(values) => Arc::new(Float64Array::from(values.to_vec())),
                Values::Counts(values) => Arc::new(UInt64Array::from(values.to_vec())),
                Values::Texts(values) => Arc::new(StringArray::from(values.to_vec())),
            }
        };
        let arrays = values.iter().map(array).collect();
        RecordBatch::try_new(self.schema.clone(), arrays)
            .map_err(ParquetError::from)
            .and_then(|batch| self.writer.write(&batch))
            .map_err(parquet_error(&self.file))
    }

    fn finish(self: Box<Self>) -> Result<(), LogError> {
        let written = self.writer.into_inner().map_err(parquet_error(&self.file))?;
        put_in_place(written, &self.file)
    }
}

/// A new file in the folder of `file`, removed when dropped.
fn temporary(file: &Path) -> Result<NamedTempFile, LogError> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
    let mut builder = tempfile::Builder::new();
    builder.prefix(".torquewise-").suffix(".partial");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Readable for whom the user's mask allows, like any new file.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder.unwrap_or(Path::new("."))).map_err(write_error(file))
}

fn put_in_place(written: NamedTempFile, file: &Path) -> Result<(), LogError> {
    written.as_file().sync_all().map_err(write_error(file))?;
    written.persist(file).map_err(|refused| write_error(file)(refused.error))?;
    Ok(())
}

fn write_error(file: &Path) -> impl Fn(io::Error) -> LogError {
    move |source| LogError::Write { file: file.into(), source }
}

fn parquet_error(file: &Path) -> impl Fn(ParquetError) -> LogError {
    move |source| LogError::WriteParquet { file: file.into(), source }
}
