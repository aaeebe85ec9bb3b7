//! A column of a Parquet row group as numbers, page by page.

use parquet::basic::{ConvertedType, LogicalType, Type};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::Result;
use parquet::schema::types::ColumnDescriptor;

/// Whole numbers with a sign, as older writers name them.
const SIGNED: [ConvertedType; 4] =
    [ConvertedType::INT_8, ConvertedType::INT_16, ConvertedType::INT_32, ConvertedType::INT_64];
/// The same without.
const UNSIGNED: [ConvertedType; 4] =
    [ConvertedType::UINT_8, ConvertedType::UINT_16, ConvertedType::UINT_32, ConvertedType::UINT_64];

/// Whether whole numbers of a column have a sign; `None` if it does not hold one number a row.
fn is_signed(column: &ColumnDescriptor) -> Option<bool> {
    if column.max_rep_level() > 0 || column.path().parts().len() != 1 {
        return None;
    }
    let is_signed = match (column.logical_type_ref(), column.converted_type()) {
        (Some(LogicalType::Integer(int)), _) => int.is_signed,
        (None, ConvertedType::NONE) => true,
        (None, converted) if SIGNED.contains(&converted) => true,
        (None, converted) if UNSIGNED.contains(&converted) => false,
        _ => return None,
    };
    match column.physical_type() {
        Type::FLOAT | Type::DOUBLE => is_signed.then_some(true),
        Type::INT32 | Type::INT64 => Some(is_signed),
        _ => None,
    }
}

/// The type of a column that cannot be read as numbers; `None` if it can.
pub(crate) fn foreign_type(column: &ColumnDescriptor) -> Option<String> {
    if is_signed(column).is_some() {
        return None;
    }
    Some(match column.logical_type_ref() {
        _ if column.path().parts().len() > 1 || column.max_rep_level() > 0 => "nested".to_owned(),
        Some(logical) => format!("{logical:?}"),
        None => column.physical_type().to_string(),
    })
}

/// A numeric column of a row group.
pub(crate) struct NumberColumn {
    reader: ColumnReader,
    is_signed: bool,
    /// Definition level of a value that is there.
    present: i16,
}

impl NumberColumn {
    /// `reader` as a column of numbers; `None` if it is none, see [`foreign_type`].
    pub(crate) fn new(column: &ColumnDescriptor, reader: ColumnReader) -> Option<Self> {
        Some(Self { reader, is_signed: is_signed(column)?, present: column.max_def_level() })
    }

    /// The next values, at most `rows`; none of a null.
    pub(crate) fn read(&mut self, rows: usize) -> Result<Vec<Option<f64>>> {
        let (is_signed, present) = (self.is_signed, self.present);
        match &mut self.reader {
            ColumnReader::Int32ColumnReader(reader) => {
                let unsigned = |value: &i32| f64::from(value.cast_unsigned());
                let signed = |value: &i32| f64::from(*value);
                read(reader, rows, present, if is_signed { signed } else { unsigned })
            }
            ColumnReader::Int64ColumnReader(reader) => {
                let unsigned = |value: &i64| value.cast_unsigned() as f64;
                let signed = |value: &i64| *value as f64;
                read(reader, rows, present, if is_signed { signed } else { unsigned })
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
) -> Result<Vec<Option<f64>>> {
    let (mut levels, mut values) = (Vec::new(), Vec::new());
    reader.read_records(rows, Some(&mut levels), None, &mut values)?;
    let mut numbers = values.iter().map(number);
    if present == 0 {
        return Ok(numbers.map(Some).collect());
    }
    Ok(levels.iter().map(|&level| if level == present { numbers.next() } else { None }).collect())
}
