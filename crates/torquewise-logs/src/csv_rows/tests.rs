//! CSV texts that are read, and texts that are refused with a place and a reason.

use super::CsvRows;
use crate::plain::plain;
use crate::signal_rows::SignalRows;
use crate::{LogError, Result, Rows};
use std::io::{BufReader, Read};
use std::path::Path;

/// A text as rows of signals.
pub(crate) fn signal_rows(text: &[u8]) -> Result<SignalRows> {
    let file = Path::new("arm.csv");
    let rows = CsvRows::new(file, std::io::Cursor::new(text.to_vec()))?;
    let mapping = plain(file, rows.names())?;
    SignalRows::new(Box::new(rows), mapping, false, false)
}

fn read(text: &[u8]) -> Result<Vec<Vec<f64>>> {
    let mut rows = signal_rows(text)?;
    let mut row = vec![0.0; rows.mapping.n_slots()];
    let mut read = Vec::new();
    while rows.next(&mut row)?.is_some() {
        read.push(row.clone());
    }
    Ok(read)
}

fn message(text: &[u8]) -> String {
    let error = read(text).unwrap_err();
    format!("{error}: {}", miette::Diagnostic::help(&error).unwrap())
}

#[test]
fn rows_are_read_in_slot_order_whatever_ends_lines_and_stands_between_them() {
    let rows = read(b"tau1,q1,t\n3,2,1\n-6e-1, +5. ,\"4\"\n").unwrap();
    assert_eq!(rows, [[1.0, 2.0, 3.0], [4.0, 5.0, -0.6]]);

    let plain = read(b"t,q1\n1,2\n3,4\n").unwrap();
    for text in ["\u{feff}t,q1\r\n1,2\r\n3,4", "# made today\n\nt,q1\n1,2\n \n#\n3,4\n\n"] {
        assert_eq!(read(text.as_bytes()).unwrap(), plain, "{text:?}");
    }
}

#[test]
fn a_leading_comment_names_the_joints() {
    let file = Path::new("arm.csv");
    let named = CsvRows::new(file, &b"\xef\xbb\xbf# joints: hip , knee\n# x\nt,q1,q2\n"[..]);

    let names = ["hip".to_owned(), "knee".to_owned()];
    assert_eq!(named.unwrap().joints(), Some(&names[..]));
}

#[test]
fn a_bad_number_is_named_by_row_line_column_and_text() {
    let text = b"# x\nt,q1,q2\n0,0,0\n\n0.1,oops\x1b,0\n";

    assert_eq!(
        message(text),
        "arm.csv, row 2 (line 5), column q1: \"oops\\u{1b}\" is not a number: \
         repair or drop the row"
    );
    assert!(matches!(read(b"t,q1\n0,1_0\n"), Err(LogError::NotANumber { .. })));
    assert!(matches!(read(b"t,q1\n0,\xff\n"), Err(LogError::NotANumber { .. })));
}

#[test]
fn numbers_that_are_not_finite_and_ragged_rows_are_refused() {
    for number in ["NaN", "inf", "-Infinity", "1e999", "", " "] {
        let refused = read(format!("t,q1\n0,{number}\n").as_bytes());
        assert!(matches!(refused, Err(LogError::NotFinite { .. })), "{number}");
    }
    assert_eq!(
        message(b"t,q1,tau1\n0,0,nan\n"),
        "arm.csv, row 1 (line 2), column tau1 is NaN or empty: repair or drop the row"
    );
    // A logger that is stopped cuts its last line off.
    assert_eq!(
        message(b"t,q1,tau1\n0,1,2\n0.1,1"),
        "arm.csv, row 2 (line 3), column q1 is NaN or empty: repair or drop the row"
    );
    for row in ["1", "1,2,3", "1,2,"] {
        let refused = read(format!("t,q1\n{row}\n").as_bytes());
        assert!(matches!(refused, Err(LogError::Ragged { expected: 2, .. })), "{row}");
    }
}

#[test]
fn files_that_are_no_comma_separated_text_are_refused_and_long_lines_without_holding_them() {
    assert!(matches!(read(b""), Err(LogError::Empty { .. })));
    assert!(matches!(read(b"\n\n# x\n"), Err(LogError::Empty { .. })));
    assert!(matches!(read(b"t;q1\n0,5;1\n"), Err(LogError::Delimiter { found: ';', .. })));
    assert!(matches!(read(b"t\tq1\n"), Err(LogError::Delimiter { found: '\t', .. })));
    assert!(matches!(read(b"\xff\xfet\0,\0"), Err(LogError::NotUtf8 { line: 1, .. })));
    assert!(matches!(read(b"t,q1\n\"1,2\n"), Err(LogError::OpenQuote { line: 2, .. })));
    assert!(matches!(read(b"0.0,-1.5,2e-3\n"), Err(LogError::NoHeader { .. })));
    assert!(matches!(read(b"\x7fELF\0\0"), Err(LogError::NoColumn { missing: "t", .. })));
    let file = Path::new("arm.csv");
    let endless = BufReader::new((&b"t,q1\n"[..]).chain(std::io::repeat(b'7')));
    let long = "x".repeat(5_000);

    let line = CsvRows::new(file, endless).unwrap().next(&mut []);
    let name = read(format!("t,q1,{long}\n").as_bytes());
    let field = read(format!("t,q1,note\n0,0,{long}\n").as_bytes());

    assert!(matches!(line, Err(LogError::TooLong { part: "line", line: 2, .. })));
    assert!(matches!(name, Err(LogError::TooLong { part: "field", line: 1, .. })));
    assert!(matches!(field, Err(LogError::TooLong { part: "field", line: 2, .. })));
}
