//! Parquet files of foreign types, and files that are broken: an error, never a panic.
#![expect(clippy::unwrap_used, reason = "a test stops where its ground gives way")]

use faer::Mat;
use parquet::basic::{Compression, LogicalType, Repetition, TimeUnit, Type as Stored, ZstdLevel};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, FloatType, Int32Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{Type, TypePtr};
use proptest::prelude::*;
use std::fs::File;
use std::path::PathBuf;
use std::sync::{Arc, LazyLock};
use tempfile::TempDir;
use torquewise_logs::{LogError, Logs, write_motion};
use torquewise_motion::{Motion, Signals};

fn read(file: PathBuf) -> Result<Vec<Motion>, LogError> {
    Logs::open(&[file])?.read_all()
}

fn read_bytes(bytes: &[u8]) -> Result<Vec<Motion>, LogError> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("log.parquet");
    std::fs::write(&file, bytes).unwrap();
    read(file)
}

/// A column of a foreign file: its type, and its values, which may be missing.
enum Foreign {
    Double(Vec<Option<f64>>),
    Float(Vec<f32>),
    Int32(LogicalType, Vec<i32>),
    Text(Vec<&'static str>),
    Decimal(Vec<i32>),
}

impl Foreign {
    fn schema(&self, name: &str) -> TypePtr {
        let build = |stored, logical| {
            Type::primitive_type_builder(name, stored)
                .with_repetition(Repetition::OPTIONAL)
                .with_logical_type(logical)
        };
        let column = match self {
            Self::Double(_) => build(Stored::DOUBLE, None),
            Self::Float(_) => build(Stored::FLOAT, None),
            Self::Int32(logical, _) => build(Stored::INT32, Some(logical.clone())),
            Self::Text(_) => build(Stored::BYTE_ARRAY, Some(LogicalType::String)),
            Self::Decimal(_) => build(Stored::INT32, Some(LogicalType::decimal(2, 9)))
                .with_precision(9)
                .with_scale(2),
        };
        Arc::new(column.build().unwrap())
    }

    fn write(&self, mut column: SerializedColumnWriter<'_>) {
        fn all<T: DataType>(column: &mut SerializedColumnWriter<'_>, values: &[T::T]) {
            let levels = vec![1; values.len()];
            column.typed::<T>().write_batch(values, Some(&levels), None).unwrap();
        }
        let bytes = |bytes: &[u8]| ByteArray::from(bytes.to_vec());
        match self {
            Self::Double(values) => {
                let levels: Vec<i16> = values.iter().map(|value| value.is_some().into()).collect();
                let values: Vec<f64> = values.iter().flatten().copied().collect();
                column.typed::<DoubleType>().write_batch(&values, Some(&levels), None).unwrap();
            }
            Self::Float(values) => all::<FloatType>(&mut column, values),
            Self::Int32(_, values) => all::<Int32Type>(&mut column, values),
            Self::Text(values) => {
                let values: Vec<_> = values.iter().map(|text| bytes(text.as_bytes())).collect();
                all::<ByteArrayType>(&mut column, &values);
            }
            Self::Decimal(values) => all::<Int32Type>(&mut column, values),
        }
        column.close().unwrap();
    }
}

fn read_columns(columns: &[(&str, Foreign)]) -> Result<Vec<Motion>, LogError> {
    let folder: TempDir = tempfile::tempdir().unwrap();
    let file = folder.path().join("log.parquet");
    let fields = columns.iter().map(|(name, column)| column.schema(name)).collect();
    let schema = Type::group_type_builder("schema").with_fields(fields).build().unwrap();
    let output = File::create(&file).unwrap();
    let mut writer = SerializedFileWriter::new(output, schema.into(), Arc::default()).unwrap();
    let mut group = writer.next_row_group().unwrap();
    for (_, column) in columns {
        column.write(group.next_column().unwrap().unwrap());
    }
    group.close().unwrap();
    writer.close().unwrap();
    read(file)
}

fn numbers(values: &[f64]) -> Foreign {
    Foreign::Double(values.iter().copied().map(Some).collect())
}

/// A valid file to be damaged.
static VALID: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("log.parquet");
    let wave = |phase: f64| Mat::from_fn(50, 1, |row, _| (row as f64 + phase).sin());
    let motion = Motion::new(Signals {
        joints: vec!["hip".into()],
        t: (0..50).map(f64::from).collect(),
        q: wave(0.0),
        dq: wave(1.0),
        ddq: wave(2.0),
        tau: Some(wave(3.0)),
    });
    write_motion(&file, &motion.unwrap()).unwrap();
    std::fs::read(file).unwrap()
});

#[test]
fn columns_of_any_numeric_type_in_any_order_are_read() {
    let read = read_columns(&[
        ("tau1", Foreign::Float(vec![0.5, 0.25])),
        ("mode", Foreign::Text(vec!["a", "b"])),
        ("ddq1", numbers(&[8.0, -1.0])),
        ("t", Foreign::Int32(LogicalType::integer(32, true), vec![-1, 2])),
        ("dq1", numbers(&[6.0, 7.0])),
        ("q1", Foreign::Int32(LogicalType::integer(32, false), vec![3, -1])),
    ]);

    let motion = &read.unwrap()[0];
    assert_eq!(motion.t(), [-1.0, 2.0]);
    assert_eq!((motion.q()[(1, 0)], motion.dq()[(1, 0)]), (f64::from(u32::MAX), 7.0));
    assert_eq!((motion.ddq()[(0, 0)], motion.ddq()[(1, 0)]), (8.0, -1.0));
    assert_eq!(motion.require_tau().unwrap().col(0), faer::col![0.5, 0.25]);
}

#[test]
fn columns_that_are_not_numbers_are_refused() {
    let time = LogicalType::time(true, TimeUnit::MILLIS);
    for (foreign, name) in [
        (Foreign::Text(vec!["1"]), "of type String"),
        (Foreign::Decimal(vec![1]), "of type Decimal"),
        (Foreign::Int32(time, vec![1]), "of type Time"),
        (Foreign::Int32(LogicalType::Date, vec![1]), "of type Date"),
    ] {
        let refused = read_columns(&[("t", numbers(&[0.0])), ("q1", foreign)]).unwrap_err();

        assert!(matches!(&refused, LogError::NotNumeric { column, .. } if column == "q1"));
        assert!(refused.to_string().contains(name), "{refused}");
    }
}

#[test]
fn nulls_and_numbers_that_are_not_finite_are_named_by_row_and_column() {
    let t = || ("t", numbers(&[0.0, 1.0, 2.0]));
    let holes = Foreign::Double(vec![Some(1.0), Some(1.0), None]);

    let null = read_columns(&[t(), ("q1", holes)]).unwrap_err();
    let nan = read_columns(&[t(), ("q1", numbers(&[0.0, f64::NAN, 0.0]))]).unwrap_err();

    assert!(null.to_string().contains("log.parquet, row 3, column q1 has no value"), "{null}");
    assert!(nan.to_string().contains("log.parquet, row 2, column q1 is NaN"), "{nan}");
}

#[test]
fn files_without_rows_or_content_are_refused() {
    let none = read_columns(&[("t", numbers(&[])), ("q1", numbers(&[]))]);

    assert!(matches!(none, Err(LogError::NoRows { .. })));
    assert!(matches!(read_bytes(b""), Err(LogError::Empty { .. })));
    assert!(matches!(read_bytes(b"t,q1\n0,1\n"), Err(LogError::Decode { .. })));
    assert!(matches!(read_bytes(b"PAR1\0\0\0\0PAR1"), Err(LogError::Damaged { .. })));
}

/// Metadata with elements of a schema: a name, and the number of children.
fn with_schema(elements: &[(&str, Option<u32>)], rest: &[u8]) -> Vec<u8> {
    let mut footer = vec![0x15, 2, 0x19, 0xfc];
    footer.extend(varint(elements.len() as u64));
    for (name, children) in elements {
        // A column: fields 1, a double; 3, required. Then 4, a name; 5, the number of children.
        let head: &[u8] = if children.is_some() { &[0x48] } else { &[0x15, 10, 0x25, 0, 0x18] };
        footer.extend([head, &varint(name.len() as u64), name.as_bytes()].concat());
        let children = children.map(|n| [vec![0x15], varint(2 * u64::from(n))].concat());
        footer.extend(children.unwrap_or_default());
        footer.push(0);
    }
    footer.extend([0x16, 0]);
    footer.extend(rest);
    let length = u32::try_from(footer.len()).unwrap().to_le_bytes();
    [&b"PAR1"[..], &footer, &length, b"PAR1"].concat()
}

fn varint(mut number: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    let lowest = |number: u64| number.to_le_bytes()[0];
    while number > 0x7f {
        bytes.push(lowest(number) | 0x80);
        number >>= 7;
    }
    bytes.push(lowest(number));
    bytes
}

/// No row groups, and the end.
const NO_GROUPS: &[u8] = &[0x19, 0x0c, 0];

#[test]
fn a1_row_groups_that_the_file_cannot_hold_are_refused() {
    let columns = [("schema", Some(2)), ("t", None), ("q1", None)];
    assert!(matches!(read_bytes(&with_schema(&columns, NO_GROUPS)), Err(LogError::NoRows { .. })));

    let many = [&[0x19, 0xfc][..], &varint((1 << 31) - 1), &[0]].concat();
    assert!(matches!(read_bytes(&with_schema(&columns, &many)), Err(LogError::Damaged { .. })));
}

#[test]
fn a2_a_schema_that_is_nested_too_deeply_is_refused() {
    let nested = |depth: usize| {
        let groups = vec![("g", Some(1)); depth];
        with_schema(&[groups, vec![("t", None)]].concat(), NO_GROUPS)
    };
    assert!(matches!(read_bytes(&nested(5_000)), Err(LogError::Damaged { .. })));
    assert!(!matches!(read_bytes(&nested(20)), Err(LogError::Damaged { .. })));
}

#[test]
fn a3_children_that_a_schema_does_not_have_are_refused() {
    let columns = [("schema", Some(1_870_000_000)), ("t", None), ("q1", None)];
    assert!(matches!(read_bytes(&with_schema(&columns, NO_GROUPS)), Err(LogError::Damaged { .. })));
}

/// Columns of one page of zeros each, compressed.
fn zeros(names: &[&str], rows: usize) -> Result<Vec<Motion>, LogError> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("log.parquet");
    let zeros = Foreign::Double(Vec::new());
    let fields = names.iter().map(|name| zeros.schema(name)).collect();
    let schema = Type::group_type_builder("schema").with_fields(fields).build().unwrap();
    let properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .set_dictionary_enabled(false)
        .set_data_page_size_limit(usize::MAX)
        .set_data_page_row_count_limit(usize::MAX)
        .build();
    let output = File::create(&file).unwrap();
    let mut writer = SerializedFileWriter::new(output, schema.into(), properties.into()).unwrap();
    let mut group = writer.next_row_group().unwrap();
    let (values, levels) = (vec![0.0; rows], vec![1; rows]);
    while let Some(mut column) = group.next_column().unwrap() {
        column.typed::<DoubleType>().write_batch(&values, Some(&levels), None).unwrap();
        column.close().unwrap();
    }
    group.close().unwrap();
    writer.close().unwrap();
    read(file)
}

#[test]
fn a4_pages_that_take_more_memory_than_stated_are_refused() {
    let refused = zeros(&["t", "q1", "q2", "q3", "q4", "q5", "q6", "q7", "q8"], 8 << 20);
    let refused = refused.unwrap_err().to_string();
    assert!(refused.contains("576 MB, at most 512 are held"), "{refused}");
}

#[test]
fn a_truncated_file_is_refused_wherever_it_ends() {
    for end in 0..VALID.len() {
        assert!(read_bytes(&VALID[..end]).is_err(), "{end} of {} bytes", VALID.len());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn a_damaged_file_never_panics(
        changes in proptest::collection::vec((any::<proptest::sample::Index>(), any::<u8>()), 1..6),
        to_footer in any::<bool>(),
    ) {
        let mut bytes = VALID.clone();
        let start = if to_footer { bytes.len() * 2 / 3 } else { 0 };
        for (place, value) in changes {
            let place = start + place.index(bytes.len() - start);
            bytes[place] = value;
        }
        if let Ok(parts) = read_bytes(&bytes) {
            prop_assert!(parts.iter().all(|part| part.n_rows() <= 50));
        }
    }

    #[test]
    fn random_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        let framed = [&b"PAR1"[..], &bytes, &b"PAR1"[..]].concat();

        prop_assert!(read_bytes(&bytes).is_err());
        prop_assert!(read_bytes(&framed).is_err());
    }
}
