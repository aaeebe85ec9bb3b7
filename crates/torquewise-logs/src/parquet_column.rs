//! A column of a Parquet row group as numbers, page by page.

use parquet::basic::{ConvertedType, LogicalType, Type};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{ByteArray, DataType};
use parquet::errors::Result;
use parquet::schema::types::ColumnDescriptor;

/// Whole numbers with a sign, as older writers name them.
const SIGNED: [ConvertedType; 4] =
    [ConvertedType::INT_8, ConvertedType::INT_16, ConvertedType::INT_32, ConvertedType::INT_64];
/// The same without.
const UNSIGNED: [ConvertedType; 4] =
    [ConvertedType::UINT_8, ConvertedType::UINT_16, ConvertedType::UINT_32, ConvertedType::UINT_64];

/// How values of a column become numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// As they are.
    Signed,
    /// Whole numbers without a sign.
    Unsigned,
    /// Whole numbers over this.
    Decimal(f64),
    /// Two bytes each.
    Half,
}

impl Kind {
    /// How a column is read; `None` if it does not hold one number a row.
    fn of(column: &ColumnDescriptor) -> Option<Self> {
        if column.max_rep_level() > 0 || column.path().parts().len() != 1 {
            return None;
        }
        let decimal = Self::Decimal(10_f64.powi(column.type_scale()));
        let kind = match (column.logical_type_ref(), column.converted_type()) {
            (Some(LogicalType::Integer(int)), _) if int.is_signed => Self::Signed,
            (Some(LogicalType::Integer(_)), _) => Self::Unsigned,
            (Some(LogicalType::Decimal(_)), _) | (None, ConvertedType::DECIMAL) => decimal,
            (Some(LogicalType::Float16), _) => Self::Half,
            (None, ConvertedType::NONE) => Self::Signed,
            (None, converted) if SIGNED.contains(&converted) => Self::Signed,
            (None, converted) if UNSIGNED.contains(&converted) => Self::Unsigned,
            _ => return None,
        };
        let fits = match column.physical_type() {
            Type::FLOAT | Type::DOUBLE => kind == Self::Signed,
            Type::INT32 | Type::INT64 => kind != Self::Half,
            Type::FIXED_LEN_BYTE_ARRAY => kind == decimal || kind == Self::Half,
            Type::BYTE_ARRAY => kind == decimal,
            Type::BOOLEAN | Type::INT96 => false,
        };
        fits.then_some(kind)
    }

    fn of_int32(self, value: i32) -> f64 {
        match self {
            Self::Unsigned => f64::from(value.cast_unsigned()),
            _ => self.scaled(f64::from(value)),
        }
    }

    fn of_int64(self, value: i64) -> f64 {
        match self {
            Self::Unsigned => value.cast_unsigned() as f64,
            _ => self.scaled(value as f64),
        }
    }

    /// A decimal is big-endian and signed, half a float little-endian.
    fn of_bytes(self, bytes: &ByteArray) -> f64 {
        let bytes = bytes.data();
        match (self, bytes) {
            (Self::Half, [low, high]) => half(u16::from_le_bytes([*low, *high])),
            (Self::Decimal(_), [first, rest @ ..]) => {
                let first = f64::from(first.cast_signed());
                self.scaled(rest.iter().fold(first, |sum, byte| 256.0 * sum + f64::from(*byte)))
            }
            _ => f64::NAN,
        }
    }

    fn scaled(self, value: f64) -> f64 {
        if let Self::Decimal(unit) = self { value / unit } else { value }
    }
}

/// The number of a half-precision float.
fn half(bits: u16) -> f64 {
    let [exponent, fraction] = [bits >> 10 & 0x1f, bits & 0x3ff].map(f64::from);
    let size = match bits >> 10 & 0x1f {
        0 => fraction * (-24_f64).exp2(),
        0x1f if fraction == 0.0 => f64::INFINITY,
        0x1f => f64::NAN,
        _ => (1024.0 + fraction) * (exponent - 25.0).exp2(),
    };
    if bits >> 15 == 0 { size } else { -size }
}

/// The type of a column that cannot be read as numbers; `None` if it can.
pub(crate) fn foreign_type(column: &ColumnDescriptor) -> Option<String> {
    if Kind::of(column).is_some() {
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
    kind: Kind,
    /// Definition level of a value that is there.
    present: i16,
}

impl NumberColumn {
    /// `reader` as a column of numbers; `None` if it is none, see [`foreign_type`].
    pub(crate) fn new(column: &ColumnDescriptor, reader: ColumnReader) -> Option<Self> {
        Some(Self { reader, kind: Kind::of(column)?, present: column.max_def_level() })
    }

    /// The next values, at most `rows`; none of a null.
    pub(crate) fn read(&mut self, rows: usize) -> Result<Vec<Option<f64>>> {
        let (kind, present) = (self.kind, self.present);
        match &mut self.reader {
            ColumnReader::Int32ColumnReader(reader) => {
                read(reader, rows, present, |value| kind.of_int32(*value))
            }
            ColumnReader::Int64ColumnReader(reader) => {
                read(reader, rows, present, |value| kind.of_int64(*value))
            }
            ColumnReader::FloatColumnReader(reader) => {
                read(reader, rows, present, |value| f64::from(*value))
            }
            ColumnReader::DoubleColumnReader(reader) => read(reader, rows, present, |value| *value),
            ColumnReader::ByteArrayColumnReader(reader) => {
                read(reader, rows, present, |value| kind.of_bytes(value))
            }
            ColumnReader::FixedLenByteArrayColumnReader(reader) => {
                read(reader, rows, present, |value| kind.of_bytes(value))
            }
            ColumnReader::BoolColumnReader(_) | ColumnReader::Int96ColumnReader(_) => Ok(vec![]),
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

#[cfg(test)]
mod tests {
    use super::half;

    #[test]
    fn half_floats_are_read() {
        for (bits, expected) in
            [(0x3c00, 1.0), (0xc000, -2.0), (0x7bff, 65504.0), (1, 2_f64.powi(-24)), (0x8000, -0.0)]
        {
            assert_eq!(half(bits).to_bits(), f64::to_bits(expected), "{bits:x}");
        }
        assert!(half(0x7e00).is_nan() && half(0xfc00) == f64::NEG_INFINITY);
    }
}
