//! Parquet file → rows, one record batch at a time.

use crate::error::{LogError, Place};
use crate::joints::{self, PARQUET_KEY};
use crate::layout::Layout;
use crate::rows::Rows;
use arrow_array::cast::AsArray;
use arrow_array::types::Float64Type;
use arrow_array::{Array, Float64Array, RecordBatch};
use arrow_cast::cast;
use arrow_schema::DataType;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{
    ArrowReaderOptions, ParquetRecordBatchReader, ParquetRecordBatchReaderBuilder,
};
use parquet::file::metadata::{ParquetMetaData, RowGroupMetaData};
use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use torquewise_motion::BLOCK_ROWS;

type Builder = ParquetRecordBatchReaderBuilder<File>;

/// The rows of a Parquet file; only the columns in use are decoded.
pub(crate) struct ParquetRows {
    file: PathBuf,
    layout: Layout,
    joints: Option<Vec<String>>,
    batches: ParquetRecordBatchReader,
    /// For each slot, its column in a batch.
    batch_columns: Vec<usize>,
    batch: Vec<Float64Array>,
    /// Rows of the batch handed out.
    taken: usize,
    row: u64,
}

impl ParquetRows {
    /// Opens a file and reads its footer.
    pub(crate) fn open(file: &Path) -> Result<Self, LogError> {
        let input = File::open(file).map_err(LogError::read(file))?;
        if input.metadata().map_err(LogError::read(file))?.len() == 0 {
            return Err(LogError::Empty { file: file.into() });
        }
        decode(file, || Self::new(file, input))
    }

    fn new(file: &Path, input: File) -> Result<Self, LogError> {
        // The types of Parquet itself: whatever wrote the file cannot lead astray.
        let options = ArrowReaderOptions::new().with_skip_arrow_metadata(true);
        let builder =
            Builder::try_new_with_options(input, options).map_err(LogError::parquet(file))?;
        if !chunks_are_in_the_file(builder.metadata()) {
            return Err(LogError::Damaged { file: file.into() });
        }
        let layout = layout(file, &builder)?;
        let joints = joint_names(&builder)
            .map(|names| joints::checked(file, names, layout.n_joints()))
            .transpose()?;
        let mut used = layout.columns().to_vec();
        used.sort_unstable();
        let batch_columns =
            layout.columns().iter().map(|column| used.partition_point(|c| c < column)).collect();
        let mask = ProjectionMask::roots(builder.parquet_schema(), used);
        let batches = builder.with_projection(mask).with_batch_size(BLOCK_ROWS).build();
        Ok(Self {
            file: file.into(),
            layout,
            joints,
            batches: batches.map_err(LogError::parquet(file))?,
            batch_columns,
            batch: Vec::new(),
            taken: 0,
            row: 0,
        })
    }

    /// Decodes the next batch that has rows; `false` at the end.
    fn next_batch(&mut self) -> Result<bool, LogError> {
        let refused = |source| LogError::RowGroup { file: self.file.clone(), source };
        while let Some(batch) = decode(&self.file, || Ok(self.batches.next()))? {
            let batch: RecordBatch = batch.map_err(refused)?;
            if batch.num_rows() == 0 {
                continue;
            }
            let numbers = |column: &usize| {
                let numbers = cast(batch.column(*column), &DataType::Float64).map_err(refused)?;
                Ok(numbers.as_primitive::<Float64Type>().clone())
            };
            self.batch = self.batch_columns.iter().map(numbers).collect::<Result<_, _>>()?;
            self.taken = 0;
            return Ok(true);
        }
        Ok(false)
    }

    fn number(&self, slot: usize) -> Result<f64, LogError> {
        let column = || self.layout.name(slot);
        if self.batch[slot].is_null(self.taken) {
            return Err(LogError::Null { place: self.place(), column: column() });
        }
        let value = self.batch[slot].value(self.taken);
        if value.is_finite() {
            return Ok(value);
        }
        Err(LogError::NotFinite { place: self.place(), column: column(), value })
    }
}

impl Rows for ParquetRows {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn joints(&self) -> Option<&[String]> {
        self.joints.as_deref()
    }

    fn next(&mut self, row: &mut [f64]) -> Result<bool, LogError> {
        let left = self.batch.first().map_or(0, Array::len) - self.taken;
        if left == 0 && !self.next_batch()? {
            return Ok(false);
        }
        self.row += 1;
        for (slot, value) in row.iter_mut().enumerate() {
            *value = self.number(slot)?;
        }
        self.taken += 1;
        Ok(true)
    }

    fn place(&self) -> Place {
        Place { file: self.file.clone(), row: self.row, line: None }
    }
}

/// The Parquet decoder may panic on a damaged file; here that is an error like any other.
fn decode<T>(file: &Path, work: impl FnOnce() -> Result<T, LogError>) -> Result<T, LogError> {
    let damaged = |_| Err(LogError::Damaged { file: file.into() });
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(damaged)
}

/// Whether no column chunk begins or ends before the file does, which the decoder takes on trust.
fn chunks_are_in_the_file(metadata: &ParquetMetaData) -> bool {
    metadata.row_groups().iter().flat_map(RowGroupMetaData::columns).all(|chunk| {
        chunk.compressed_size() >= 0
            && chunk.data_page_offset() >= 0
            && chunk.dictionary_page_offset().unwrap_or(0) >= 0
    })
}

fn layout(file: &Path, builder: &Builder) -> Result<Layout, LogError> {
    let fields = builder.schema().fields();
    let names: Vec<_> = fields.iter().map(|field| field.name().as_str()).collect();
    let layout = Layout::new(file, &names)?;
    for (slot, column) in layout.columns().iter().enumerate() {
        let found = fields[*column].data_type();
        if !found.is_numeric() {
            let (column, found) = (layout.name(slot), found.to_string());
            return Err(LogError::NotNumeric { file: file.into(), column, found });
        }
    }
    Ok(layout)
}

fn joint_names(builder: &Builder) -> Option<Vec<String>> {
    let pairs = builder.metadata().file_metadata().key_value_metadata()?;
    let pair = pairs.iter().find(|pair| pair.key == PARQUET_KEY)?;
    Some(joints::parse(pair.value.as_deref()?))
}
