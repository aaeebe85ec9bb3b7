//! Parquet files of foreign types, and files that are broken: an error, never a panic.
#![expect(clippy::unwrap_used, reason = "a test stops where its ground gives way")]

use arrow_array::{
    ArrayRef, Float32Array, Float64Array, Int32Array, RecordBatch, StringArray, UInt8Array,
};
use faer::Mat;
use parquet::arrow::ArrowWriter;
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

fn read_columns(columns: Vec<(&str, ArrayRef)>) -> Result<Vec<Motion>, LogError> {
    let folder: TempDir = tempfile::tempdir().unwrap();
    let file = folder.path().join("log.parquet");
    let batch = RecordBatch::try_from_iter_with_nullable(
        columns.into_iter().map(|(name, values)| (name, values, true)),
    )
    .unwrap();
    let mut writer =
        ArrowWriter::try_new(File::create(&file).unwrap(), batch.schema(), None).unwrap();
    writer.write(&batch).unwrap();
    writer.close().unwrap();
    read(file)
}

fn numbers(values: &[f64]) -> ArrayRef {
    Arc::new(Float64Array::from(values.to_vec()))
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
    let read = read_columns(vec![
        ("tau1", Arc::new(Float32Array::from(vec![0.5, 0.25]))),
        ("mode", Arc::new(StringArray::from(vec!["a", "b"]))),
        ("ddq1", numbers(&[8.0, 9.0])),
        ("t", Arc::new(Int32Array::from(vec![-1, 2]))),
        ("dq1", numbers(&[6.0, 7.0])),
        ("q1", Arc::new(UInt8Array::from(vec![3, 255]))),
    ]);

    let motion = &read.unwrap()[0];
    assert_eq!(motion.t(), [-1.0, 2.0]);
    assert_eq!((motion.q()[(1, 0)], motion.dq()[(1, 0)]), (255.0, 7.0));
    assert_eq!((motion.ddq()[(0, 0)], motion.require_tau().unwrap()[(1, 0)]), (8.0, 0.25));
}

#[test]
fn columns_that_are_not_numbers_are_refused() {
    let text: ArrayRef = Arc::new(StringArray::from(vec!["1"]));

    let refused = read_columns(vec![("t", numbers(&[0.0])), ("q1", text)]).unwrap_err();

    assert!(matches!(&refused, LogError::NotNumeric { column, .. } if column == "q1"));
    assert!(refused.to_string().contains("of type Utf8"), "{refused}");
}

#[test]
fn nulls_and_numbers_that_are_not_finite_are_named_by_row_and_column() {
    let t = || ("t", numbers(&[0.0, 1.0, 2.0]));
    let holes: ArrayRef = Arc::new(Float64Array::from(vec![Some(1.0), Some(1.0), None]));

    let null = read_columns(vec![t(), ("q1", holes)]).unwrap_err();
    let nan = read_columns(vec![t(), ("q1", numbers(&[0.0, f64::NAN, 0.0]))]).unwrap_err();

    assert!(null.to_string().contains("log.parquet, row 3, column q1 has no value"), "{null}");
    assert!(nan.to_string().contains("log.parquet, row 2, column q1 is NaN"), "{nan}");
}

#[test]
fn files_without_rows_or_content_are_refused() {
    let none = read_columns(vec![("t", numbers(&[])), ("q1", numbers(&[]))]);

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
