//! A table as a Parquet file, one row group at a time.

use crate::sink::{Sink, write_error};
use crate::{Column, LogError, PARQUET_KEY, Values};
use parquet::basic::{Compression, LogicalType, Repetition, Type};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{Type as Schema, TypePtr};
use std::io;
use std::mem::take;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use torquewise_motion::whole_file::Output;

/// Rows of a row group at most: what a reader and a writer have to hold.
const ROW_GROUP_ROWS: usize = 16_384;

pub(crate) struct ParquetSink {
    file: PathBuf,
    writer: SerializedFileWriter<Output>,
    /// What is not yet written of each column.
    held: Vec<Held>,
    rows: usize,
}

enum Held {
    Numbers(Vec<f64>),
    Counts(Vec<i64>),
    Texts(Vec<ByteArray>),
}

impl ParquetSink {
    pub(crate) fn create(
        file: &Path,
        columns: &[Column],
        joints: Option<&str>,
    ) -> std::result::Result<Self, LogError> {
        let metadata =
            joints.map(|names| vec![KeyValue::new(PARQUET_KEY.to_owned(), names.to_owned())]);
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_dictionary_enabled(false)
            .set_key_value_metadata(metadata)
            .build();
        let output = Output::create(file).map_err(write_error(file))?;
        let writer = schema(columns)
            .and_then(|schema| SerializedFileWriter::new(output, schema, properties.into()))
            .map_err(refused(file))?;
        let held = |column: &Column| match column.kind {
            Values::Numbers(_) => Held::Numbers(Vec::new()),
            Values::Counts(_) => Held::Counts(Vec::new()),
            Values::Texts(_) => Held::Texts(Vec::new()),
        };
        Ok(Self { file: file.into(), writer, held: columns.iter().map(held).collect(), rows: 0 })
    }

    fn flush(&mut self) -> Result<()> {
        if self.rows == 0 {
            return Ok(());
        }
        let mut group = self.writer.next_row_group()?;
        for held in &mut self.held {
            let Some(mut column) = group.next_column()? else { break };
            match held {
                Held::Numbers(values) => {
                    column.typed::<DoubleType>().write_batch(&take(values), None, None)
                }
                Held::Counts(values) => {
                    column.typed::<Int64Type>().write_batch(&take(values), None, None)
                }
                Held::Texts(values) => {
                    column.typed::<ByteArrayType>().write_batch(&take(values), None, None)
                }
            }?;
            column.close()?;
        }
        group.close()?;
        self.rows = 0;
        Ok(())
    }
}

impl Sink for ParquetSink {
    fn append(&mut self, values: &[Values<'_>], rows: usize) -> std::result::Result<(), LogError> {
        if self.rows + rows > ROW_GROUP_ROWS {
            self.flush().map_err(refused(&self.file))?;
        }
        for (held, values) in self.held.iter_mut().zip(values) {
            match (held, values) {
                (Held::Numbers(held), Values::Numbers(values)) => held.extend_from_slice(values),
                (Held::Counts(held), Values::Counts(values)) => {
                    held.extend(values.iter().map(|count| count.cast_signed()));
                }
                (Held::Texts(held), Values::Texts(values)) => {
                    held.extend(values.iter().map(|text| ByteArray::from(*text)));
                }
                // Kinds were checked before.
                _ => {}
            }
        }
        self.rows += rows;
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> std::result::Result<(), LogError> {
        self.flush().map_err(refused(&self.file))?;
        let written = self.writer.into_inner().map_err(refused(&self.file))?;
        written.put_in_place().map_err(write_error(&self.file))
    }
}

fn schema(columns: &[Column]) -> Result<TypePtr> {
    let field = |column: &Column| {
        let (stored, logical) = match column.kind {
            Values::Numbers(_) => (Type::DOUBLE, None),
            Values::Counts(_) => (Type::INT64, Some(LogicalType::integer(64, false))),
            Values::Texts(_) => (Type::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let field = Schema::primitive_type_builder(&column.name, stored)
            .with_repetition(Repetition::REQUIRED)
            .with_logical_type(logical);
        Ok(Arc::new(field.build()?))
    };
    let fields = columns.iter().map(field).collect::<Result<_>>()?;
    Ok(Arc::new(Schema::group_type_builder("table").with_fields(fields).build()?))
}

fn refused(file: &Path) -> impl Fn(ParquetError) -> LogError {
    move |source| LogError::Write { file: file.into(), source: io::Error::other(source) }
}
