//! Parquet file → rows, one record batch at a time.

use crate::error::{LogError, Place};
use crate::guarded::guarded;
use crate::joints::{self, PARQUET_KEY};
use crate::rows::Rows;
use arrow_array::cast::AsArray;
use arrow_array::types::Float64Type;
use arrow_array::{Array, Float64Array, RecordBatch};
use arrow_cast::cast;
use arrow_schema::DataType;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{
    ArrowReaderMetadata, ArrowReaderOptions, ParquetRecordBatchReader,
    ParquetRecordBatchReaderBuilder,
};
use parquet::file::metadata::{ParquetMetaData, RowGroupMetaData};
use std::fs::File;
use std::path::{Path, PathBuf};
use torquewise_motion::BLOCK_ROWS;

type Builder = ParquetRecordBatchReaderBuilder<File>;

/// The rows of a Parquet file; only the chosen columns are decoded.
pub(crate) struct ParquetRows {
    file: PathBuf,
    names: Vec<String>,
    joints: Option<Vec<String>>,
    metadata: ArrowReaderMetadata,
    batches: Option<ParquetRecordBatchReader>,
    chosen: Vec<usize>,
    /// For each chosen column, its place in a batch.
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
        guarded(file, || Self::new(file, &input))
    }

    fn new(file: &Path, input: &File) -> Result<Self, LogError> {
        // The types of Parquet itself: whatever wrote the file cannot lead astray.
        let options = ArrowReaderOptions::new().with_skip_arrow_metadata(true);
        let metadata =
            ArrowReaderMetadata::load(input, options).map_err(LogError::parquet(file))?;
        if !chunks_are_in_the_file(metadata.metadata()) {
            return Err(LogError::Damaged { file: file.into() });
        }
        let fields = metadata.schema().fields();
        Ok(Self {
            file: file.into(),
            names: fields.iter().map(|field| field.name().trim().to_owned()).collect(),
            joints: joint_names(metadata.metadata()),
            metadata,
            batches: None,
            chosen: Vec::new(),
            batch_columns: Vec::new(),
            batch: Vec::new(),
            taken: 0,
            row: 0,
        })
    }

    /// Starts to decode the chosen columns.
    fn start(&mut self) -> Result<(), LogError> {
        let input = File::open(&self.file).map_err(LogError::read(&self.file))?;
        let builder = Builder::new_with_metadata(input, self.metadata.clone());
        let mut used = self.chosen.clone();
        used.sort_unstable();
        used.dedup();
        self.batch_columns =
            self.chosen.iter().map(|column| used.partition_point(|c| c < column)).collect();
        let mask = ProjectionMask::roots(builder.parquet_schema(), used);
        let batches = builder.with_projection(mask).with_batch_size(BLOCK_ROWS).build();
        self.batches = Some(batches.map_err(LogError::parquet(&self.file))?);
        Ok(())
    }

    /// Decodes the next batch that has rows; `false` at the end.
    fn next_batch(&mut self) -> Result<bool, LogError> {
        let refused = |source| LogError::RowGroup { file: self.file.clone(), source };
        let Some(batches) = &mut self.batches else { return Ok(false) };
        while let Some(batch) = guarded(&self.file, || Ok(batches.next()))? {
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
}

impl Rows for ParquetRows {
    fn names(&self) -> &[String] {
        &self.names
    }

    fn joints(&self) -> Option<&[String]> {
        self.joints.as_deref()
    }

    fn choose(&mut self, columns: &[usize]) -> Result<(), LogError> {
        for column in columns {
            let found = self.metadata.schema().fields()[*column].data_type();
            if !found.is_numeric() {
                let (column, found) = (self.names[*column].clone(), found.to_string());
                return Err(LogError::NotNumeric { file: self.file.clone(), column, found });
            }
        }
        self.chosen = columns.to_vec();
        let file = self.file.clone();
        guarded(&file, || self.start())
    }

    fn next(&mut self, row: &mut [f64]) -> Result<bool, LogError> {
        let left = self.batch.first().map_or(0, Array::len) - self.taken;
        if left == 0 && !self.next_batch()? {
            return Ok(false);
        }
        self.row += 1;
        for (value, column) in row.iter_mut().zip(&self.batch) {
            let is_null = column.is_null(self.taken);
            *value = if is_null { f64::NAN } else { column.value(self.taken) };
        }
        self.taken += 1;
        Ok(true)
    }

    fn is_null(&self, column: usize) -> bool {
        let last = self.taken.saturating_sub(1);
        self.batch.get(column).is_some_and(|values| last < values.len() && values.is_null(last))
    }

    fn count(&self) -> Option<u64> {
        u64::try_from(self.metadata.metadata().file_metadata().num_rows()).ok()
    }

    fn place(&self) -> Place {
        Place { file: self.file.clone(), row: self.row, line: None }
    }
}

/// Whether no column chunk begins or ends before the file does, which the decoder takes on trust.
fn chunks_are_in_the_file(metadata: &ParquetMetaData) -> bool {
    metadata.row_groups().iter().flat_map(RowGroupMetaData::columns).all(|chunk| {
        chunk.compressed_size() >= 0
            && chunk.data_page_offset() >= 0
            && chunk.dictionary_page_offset().unwrap_or(0) >= 0
    })
}

fn joint_names(metadata: &ParquetMetaData) -> Option<Vec<String>> {
    let pairs = metadata.file_metadata().key_value_metadata()?;
    let pair = pairs.iter().find(|pair| pair.key == PARQUET_KEY)?;
    Some(joints::parse(pair.value.as_deref()?))
}
