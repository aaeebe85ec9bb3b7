//! Rows of a Parquet file, some of each row group at a time.

use crate::joints;
use crate::log_input::Opened;
use crate::parquet_checks::{self, MOST_PAGE_BYTES};
use crate::{Format, LogError, LogInput, PARQUET_KEY, Result, RowPlace, Rows, guarded};
use parquet::basic::{ConvertedType, LogicalType, Type};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::file::metadata::{ColumnChunkMetaData, RowGroupMetaData};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::{ColumnDescriptor, SchemaDescriptor};
use std::path::{Path, PathBuf};
use torquewise_motion::BLOCK_ROWS;

/// The rows of a Parquet file; only the chosen columns are decoded.
pub(crate) struct ParquetRows {
    file: PathBuf,
    names: Vec<String>,
    joints: Option<Vec<String>>,
    reader: SerializedFileReader<Opened>,
    /// The file once more, for the headers of its pages.
    pages: Opened,
    chosen: Vec<usize>,
    group: Vec<NumberColumn>,
    groups: usize,
    /// Values decoded of each chosen column; NaN of a null.
    batch: Vec<Vec<f64>>,
    taken: usize,
    row: u64,
}

impl ParquetRows {
    pub(crate) fn open(file: &LogInput) -> Result<Self> {
        let mut input = file.open_whole()?;
        parquet_checks::check_footer(file, &mut input)?;
        guarded(file, || Self::new(file, input))
    }

    fn new(file: &Path, input: Opened) -> Result<Self> {
        let pages = input.clone();
        let reader =
            SerializedFileReader::new(input).map_err(LogError::decode(file, Format::Parquet))?;
        let metadata = reader.metadata();
        // The decoder takes on trust that no column chunk begins or ends before the file does.
        let mut chunks = metadata.row_groups().iter().flat_map(RowGroupMetaData::columns);
        let is_in_the_file = |chunk: &ColumnChunkMetaData| {
            chunk.compressed_size() >= 0
                && chunk.data_page_offset() >= 0
                && chunk.dictionary_page_offset().unwrap_or(0) >= 0
        };
        if !chunks.all(is_in_the_file) {
            return Err(LogError::Damaged { file: file.into() });
        }
        let names = metadata.file_metadata().schema_descr().columns().iter();
        let pairs = metadata.file_metadata().key_value_metadata();
        let joints = pairs.and_then(|pairs| pairs.iter().find(|pair| pair.key == PARQUET_KEY));
        Ok(Self {
            file: file.into(),
            names: names.map(|column| column.path().string().trim().to_owned()).collect(),
            joints: joints.and_then(|pair| Some(joints::parse(pair.value.as_deref()?))),
            reader,
            pages,
            chosen: Vec::new(),
            group: Vec::new(),
            groups: 0,
            batch: Vec::new(),
            taken: 0,
            row: 0,
        })
    }

    fn schema(&self) -> &SchemaDescriptor {
        self.reader.metadata().file_metadata().schema_descr()
    }

    fn next_batch(&mut self) -> Result<bool> {
        loop {
            let batch = self.group.iter_mut().map(|column| column.read(BLOCK_ROWS));
            let batch = batch.collect::<Result<_, _>>();
            self.batch = batch.map_err(LogError::decode(&self.file, Format::Parquet))?;
            self.taken = 0;
            let rows = self.batch.first().map_or(0, Vec::len);
            if self.batch.iter().any(|values| values.len() != rows) {
                return Err(LogError::Damaged { file: self.file.clone() });
            }
            if rows > 0 {
                return Ok(true);
            }
            if self.groups == self.reader.num_row_groups() {
                return Ok(false);
            }
            self.check_pages()?;
            let refused = LogError::decode(&self.file, Format::Parquet);
            let group = self.reader.get_row_group(self.groups).map_err(&refused)?;
            let column = |&column: &usize| {
                let reader = group.get_column_reader(column).map_err(&refused)?;
                let column = self.schema().column(column);
                let is_signed = is_signed(&column).unwrap_or(true);
                Ok(NumberColumn { reader, is_signed, present: column.max_def_level() })
            };
            self.group = self.chosen.iter().map(column).collect::<Result<_>>()?;
            self.groups += 1;
        }
    }

    fn check_pages(&mut self) -> Result<()> {
        let group = self.reader.metadata().row_group(self.groups);
        let mut bytes = 0_u64;
        for &column in &self.chosen {
            let (start, length) = group.column(column).byte_range();
            let own = parquet_checks::page_bytes(&mut self.pages, start, length);
            let own = own.map_err(LogError::read(&self.file))?;
            bytes += own.ok_or_else(|| LogError::Damaged { file: self.file.clone() })?;
        }
        if bytes > MOST_PAGE_BYTES {
            let problem = format!(
                ": the pages of one row group take {} MB, at most {} are held",
                bytes >> 20,
                MOST_PAGE_BYTES >> 20
            );
            let help = "write it with pages of 1 MB (data_page_size) or fewer rows in a row group";
            return Err(LogError::unusable(self.file.display(), &problem, help));
        }
        Ok(())
    }
}

impl Rows for ParquetRows {
    fn header(&self) -> (&[String], Option<&[String]>) {
        (&self.names, self.joints.as_deref())
    }

    fn choose(&mut self, columns: &[usize]) -> Result<()> {
        for &column in columns {
            if let Some(found) = foreign_type(&self.schema().column(column)) {
                let (column, found) = (self.names[column].clone(), found);
                return Err(LogError::NotNumeric { file: self.file.clone(), column, found });
            }
        }
        self.chosen = columns.to_vec();
        Ok(())
    }

    fn next(&mut self, row: &mut [f64]) -> Result<bool> {
        if self.taken == self.batch.first().map_or(0, Vec::len) {
            let file = self.file.clone();
            if !guarded(&file, || self.next_batch())? {
                return Ok(false);
            }
        }
        self.row += 1;
        for (value, column) in row.iter_mut().zip(&self.batch) {
            *value = column[self.taken];
        }
        self.taken += 1;
        Ok(true)
    }

    fn count(&self) -> Option<u64> {
        u64::try_from(self.reader.metadata().file_metadata().num_rows()).ok()
    }

    fn place(&self) -> RowPlace {
        RowPlace { file: self.file.clone(), row: self.row, line: None }
    }
}

/// Whether whole numbers of a column have a sign; `None` if it does not hold one number a row.
fn is_signed(column: &ColumnDescriptor) -> Option<bool> {
    use ConvertedType::{INT_8, INT_16, INT_32, INT_64, NONE, UINT_8, UINT_16, UINT_32, UINT_64};
    if column.max_rep_level() > 0 || column.path().parts().len() != 1 {
        return None;
    }
    let is_signed = match (column.logical_type_ref(), column.converted_type()) {
        (Some(LogicalType::Integer(int)), _) => int.is_signed,
        // As older writers name them.
        (None, NONE | INT_8 | INT_16 | INT_32 | INT_64) => true,
        (None, UINT_8 | UINT_16 | UINT_32 | UINT_64) => false,
        _ => return None,
    };
    match column.physical_type() {
        Type::FLOAT | Type::DOUBLE => is_signed.then_some(true),
        Type::INT32 | Type::INT64 => Some(is_signed),
        _ => None,
    }
}

/// The type of a column that cannot be read as numbers; `None` if it can.
fn foreign_type(column: &ColumnDescriptor) -> Option<String> {
    if is_signed(column).is_some() {
        return None;
    }
    Some(match column.logical_type_ref() {
        _ if column.path().parts().len() > 1 || column.max_rep_level() > 0 => "nested".to_owned(),
        Some(logical) => format!("{logical:?}"),
        None => column.physical_type().to_string(),
    })
}

struct NumberColumn {
    reader: ColumnReader,
    is_signed: bool,
    /// Definition level of a value that is there.
    present: i16,
}

impl NumberColumn {
    fn read(&mut self, rows: usize) -> parquet::errors::Result<Vec<f64>> {
        let (is_signed, present) = (self.is_signed, self.present);
        match &mut self.reader {
            ColumnReader::Int32ColumnReader(reader) => {
                let number =
                    |x: &i32| if is_signed { f64::from(*x) } else { f64::from(x.cast_unsigned()) };
                read(reader, rows, present, number)
            }
            ColumnReader::Int64ColumnReader(reader) => {
                let number = |x: &i64| if is_signed { *x as f64 } else { x.cast_unsigned() as f64 };
                read(reader, rows, present, number)
            }
            ColumnReader::FloatColumnReader(reader) => {
                read(reader, rows, present, |value| f64::from(*value))
            }
            ColumnReader::DoubleColumnReader(reader) => read(reader, rows, present, |value| *value),
            _ => Ok(vec![]),
        }
    }
}

fn read<T: DataType>(
    reader: &mut ColumnReaderImpl<T>,
    rows: usize,
    present: i16,
    number: impl Fn(&T::T) -> f64,
) -> parquet::errors::Result<Vec<f64>> {
    let (mut levels, mut values) = (Vec::new(), Vec::new());
    reader.read_records(rows, Some(&mut levels), None, &mut values)?;
    let mut numbers = values.iter().map(number);
    if present == 0 {
        return Ok(numbers.collect());
    }
    let value = |level: &i16| if *level == present { numbers.next() } else { None };
    Ok(levels.iter().map(value).map(|value| value.unwrap_or(f64::NAN)).collect())
}
