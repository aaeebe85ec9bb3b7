//! Parquet files of foreign types, and files that are broken: an error, never a panic.

use faer::Mat;
use parquet::basic::{Compression, LogicalType, Repetition, TimeUnit, ZstdLevel};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, FloatType, Int32Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{Type, TypePtr};
use std::fs::File;
use std::path::Path;
use std::sync::LazyLock;
use torquewise_logs::{LogError, Options, write_motion};
use torquewise_motion::{Motion, Signals};

type Read = Result<Vec<Motion>, LogError>;

fn read(file: &Path) -> Read {
    crate::read_both(file, &Options::default())
}

fn read_bytes(bytes: &[u8]) -> Read {
    read(&crate::file_of(".parquet", bytes))
}

/// A column of a foreign file: its type, and what writes its values, which may be missing.
struct Foreign {
    schema: TypePtr,
    write: Box<dyn Fn(&mut SerializedColumnWriter<'_>)>,
}

fn foreign<T: DataType>(
    name: &str,
    logical: Option<LogicalType>,
    values: &[Option<T::T>],
) -> Foreign {
    let column = Type::primitive_type_builder(name, T::get_physical_type())
        .with_repetition(Repetition::OPTIONAL);
    let is_decimal = matches!(logical, Some(LogicalType::Decimal(_)));
    let column = if is_decimal { column.with_precision(9).with_scale(2) } else { column };
    let schema = column.with_logical_type(logical).build().unwrap();
    let levels: Vec<i16> = values.iter().map(|value| value.is_some().into()).collect();
    let values: Vec<T::T> = values.iter().flatten().cloned().collect();
    let write = move |column: &mut SerializedColumnWriter<'_>| {
        column.typed::<T>().write_batch(&values, Some(&levels), None).unwrap();
    };
    Foreign { schema: schema.into(), write: Box::new(write) }
}

fn read_columns(columns: &[Foreign]) -> Read {
    read_written(columns, WriterProperties::default())
}

fn read_written(columns: &[Foreign], properties: WriterProperties) -> Read {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("log.parquet");
    let fields = columns.iter().map(|column| column.schema.clone()).collect();
    let schema = Type::group_type_builder("schema").with_fields(fields).build().unwrap();
    let output = File::create(&file).unwrap();
    let mut writer = SerializedFileWriter::new(output, schema.into(), properties.into()).unwrap();
    let mut group = writer.next_row_group().unwrap();
    for column in columns {
        let mut output = group.next_column().unwrap().unwrap();
        (column.write)(&mut output);
        output.close().unwrap();
    }
    group.close().unwrap();
    writer.close().unwrap();
    read(&file)
}

fn numbers(name: &str, values: &[f64]) -> Foreign {
    let values: Vec<_> = values.iter().copied().map(Some).collect();
    foreign::<DoubleType>(name, None, &values)
}

static VALID: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let file = crate::file_of(".parquet", b"");
    let wave = |phase: f64| Mat::from_fn(50, 1, |row, _| (row as f64 + phase).sin());
    let (joints, t) = (vec!["hip".into()], (0..50).map(f64::from).collect());
    let [q, dq, ddq, tau] = [0.0, 1.0, 2.0, 3.0].map(wave);
    let motion = Motion::new(Signals { joints, t, q, dq, ddq, tau: Some(tau) });
    write_motion(&file, &motion.unwrap()).unwrap();
    std::fs::read(file).unwrap()
});

#[test]
fn columns_of_any_numeric_type_in_any_order_are_read() {
    let [signed, unsigned] = [true, false].map(|signed| Some(LogicalType::integer(32, signed)));
    let texts = ["a", "b"].map(|text| Some(ByteArray::from(text)));
    let read = read_columns(&[
        foreign::<FloatType>("tau1", None, &[Some(0.5), Some(0.25)]),
        foreign::<ByteArrayType>("mode", Some(LogicalType::String), &texts),
        numbers("ddq1", &[8.0, -1.0]),
        foreign::<Int32Type>("t", signed, &[Some(-1), Some(2)]),
        numbers("dq1", &[6.0, 7.0]),
        foreign::<Int32Type>("q1", unsigned, &[Some(3), Some(-1)]),
    ]);

    let motion = &read.unwrap()[0];
    assert_eq!(motion.t(), [-1.0, 2.0]);
    assert_eq!((motion.q()[(1, 0)], motion.dq()[(1, 0)]), (f64::from(u32::MAX), 7.0));
    assert_eq!((motion.ddq()[(0, 0)], motion.ddq()[(1, 0)]), (8.0, -1.0));
    assert_eq!(motion.require_tau().unwrap().col(0), faer::col![0.5, 0.25]);
}

#[test]
fn columns_that_are_not_numbers_are_refused() {
    let whole = |logical| foreign::<Int32Type>("q1", Some(logical), &[Some(1)]);
    let text = [Some(ByteArray::from("1"))];
    for (foreign, name) in [
        (foreign::<ByteArrayType>("q1", Some(LogicalType::String), &text), "of type String"),
        (whole(LogicalType::decimal(2, 9)), "of type Decimal"),
        (whole(LogicalType::time(true, TimeUnit::MILLIS)), "of type Time"),
        (whole(LogicalType::Date), "of type Date"),
    ] {
        let refused = read_columns(&[numbers("t", &[0.0]), foreign]).unwrap_err();

        assert!(matches!(&refused, LogError::NotNumeric { column, .. } if column == "q1"));
        assert!(refused.to_string().contains(name), "{refused}");
    }
}

#[test]
fn nulls_and_numbers_that_are_not_finite_are_named_by_row_and_column() {
    let t = || numbers("t", &[0.0, 1.0, 2.0]);
    let holes = foreign::<DoubleType>("q1", None, &[Some(1.0), Some(1.0), None]);

    let null = read_columns(&[t(), holes]).unwrap_err();
    let nan = read_columns(&[t(), numbers("q1", &[0.0, f64::NAN, 0.0])]).unwrap_err();

    assert!(null.to_string().contains("log.parquet, row 3, column q1 is NaN"), "{null}");
    assert!(nan.to_string().contains("log.parquet, row 2, column q1 is NaN"), "{nan}");
}

#[test]
fn files_without_rows_or_content_are_refused_and_those_cut_short_wherever_they_end() {
    let none = read_columns(&[numbers("t", &[]), numbers("q1", &[])]);

    assert!(matches!(none, Err(LogError::NoRows { .. })));
    assert!(matches!(read_bytes(b""), Err(LogError::Empty { .. })));
    assert!(matches!(read_bytes(b"t,q1\n0,1\n"), Err(LogError::Decode { .. })));
    assert!(matches!(read_bytes(b"PAR1\0\0\0\0PAR1"), Err(LogError::Damaged { .. })));
    for end in 0..VALID.len() {
        assert!(read_bytes(&VALID[..end]).is_err(), "{end} of {} bytes", VALID.len());
    }
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
fn a1_a2_a3_metadata_that_the_file_cannot_hold_is_refused() {
    let columns = |children| [("schema", Some(children)), ("t", None), ("q1", None)];
    let nested = |depth: usize| [vec![("g", Some(1)); depth], vec![("t", None)]].concat();
    let groups = [&[0x19, 0xfc][..], &varint((1 << 31) - 1), &[0]].concat();

    let sound = read_bytes(&with_schema(&columns(2), NO_GROUPS));
    assert!(matches!(sound, Err(LogError::NoRows { .. })));
    let shallow = read_bytes(&with_schema(&nested(20), NO_GROUPS));
    assert!(!matches!(shallow, Err(LogError::Damaged { .. })));
    for hostile in [
        with_schema(&columns(2), &groups),
        with_schema(&nested(5_000), NO_GROUPS),
        with_schema(&columns(1_870_000_000), NO_GROUPS),
    ] {
        assert!(matches!(read_bytes(&hostile), Err(LogError::Damaged { .. })));
    }
}

#[test]
fn a4_pages_that_take_more_memory_than_stated_are_refused() {
    // Columns of one page of zeros each, compressed.
    let properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .set_dictionary_enabled(false)
        .set_data_page_size_limit(usize::MAX)
        .set_data_page_row_count_limit(usize::MAX);
    let zeros = vec![0.0; 8 << 20];
    let names = ["t", "q1", "q2", "q3", "q4", "q5", "q6", "q7", "q8"];
    let columns = names.map(|name| numbers(name, &zeros));

    let refused = read_written(&columns, properties.build()).unwrap_err().to_string();

    assert!(refused.contains("576 MB, at most 512 are held"), "{refused}");
}
