//! Parquet files of foreign types, and files that are broken: an error, never a panic.
#![expect(clippy::unwrap_used, reason = "a test stops where its ground gives way")]

use faer::Mat;
use parquet::basic::{LogicalType, Repetition, TimeUnit, Type as Stored};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, FloatType, Int32Type};
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
    Decimal(i32, Vec<Vec<u8>>),
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
            Self::Decimal(scale, _) => {
                build(Stored::BYTE_ARRAY, Some(LogicalType::decimal(*scale, 9)))
                    .with_precision(9)
                    .with_scale(*scale)
            }
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
            Self::Decimal(_, values) => {
                let values: Vec<_> = values.iter().map(|value| bytes(value)).collect();
                all::<ByteArrayType>(&mut column, &values);
            }
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
        ("ddq1", Foreign::Decimal(2, vec![vec![3, 32], vec![0xff, 0x9c]])),
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
    assert!(matches!(read_bytes(b"t,q1\n0,1\n"), Err(LogError::Parquet { .. })));
    assert!(matches!(read_bytes(b"PAR1\0\0\0\0PAR1"), Err(LogError::Parquet { .. })));
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
