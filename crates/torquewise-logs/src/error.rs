//! Errors of reading and writing logs: file, row and column at fault.
#![expect(missing_docs, reason = "each message explains its fields")]

#[cfg(feature = "formats")]
use crate::Format;
#[cfg(feature = "formats")]
use std::cell::Cell;
use std::error::Error;
use std::fmt;
use std::io;
#[cfg(feature = "formats")]
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use torquewise_motion::MotionError;

/// What fails by [`LogError`].
pub type Result<T, E = LogError> = std::result::Result<T, E>;

/// A row of a log file, as its user counts it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RowPlace {
    /// The log file.
    pub file: PathBuf,
    /// Data row, 1 for the first after the header.
    pub row: u64,
    /// Line of a text file, 1 for the first.
    pub line: Option<u64>,
}

impl fmt::Display for RowPlace {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}, row {}", self.file.display(), self.row)?;
        self.line.map_or(Ok(()), |line| write!(out, " (line {line})"))
    }
}

/// Why a log cannot be read or written.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum LogError {
    #[error("no log file is given")]
    #[diagnostic(help("name at least one"))]
    NoFiles,
    #[error("{}: {extension:?} is no log format known here", file.display())]
    #[diagnostic(help(
        "logs are .csv, .parquet, .db3, .mcap, .npz or .mat files; convert it to one of them, a .bag \
         of ROS 1 with `rosbags-convert`"
    ))]
    UnknownExtension { file: PathBuf, extension: String },
    #[error("{} cannot be read", file.display())]
    #[diagnostic(help("check that it exists and may be read"))]
    Read { file: PathBuf, source: io::Error },
    #[error("{} is empty", file.display())]
    #[diagnostic(help("a log begins with a header: t, q1, …"))]
    Empty { file: PathBuf },
    #[error("{}, trajectory {trajectory}: its signals cannot be conditioned{doubts}", file.display())]
    #[diagnostic(forward(source))]
    Signals { file: PathBuf, trajectory: usize, doubts: String, source: MotionError },
    #[error("{} has a header but no rows", file.display())]
    #[diagnostic(help("record the motion again"))]
    NoRows { file: PathBuf },
    #[error("{}: columns are separated by {found:?}", file.display())]
    #[diagnostic(help("write them with commas and decimal points"))]
    Delimiter { file: PathBuf, found: char },
    #[error("{}, line {line} is not UTF-8 text", file.display())]
    #[diagnostic(help("save the file as UTF-8"))]
    NotUtf8 { file: PathBuf, line: u64 },
    #[error("{}, line {line} holds over {limit} bytes in one {part}", file.display())]
    #[diagnostic(help("is this a CSV file?"))]
    TooLong { file: PathBuf, line: u64, part: &'static str, limit: usize },
    #[error("{}, line {line}: a quoted field does not end in a quote and a comma", file.display())]
    #[diagnostic(help("repair the quotes"))]
    OpenQuote { file: PathBuf, line: u64 },
    #[error("{} has {found} columns, at most {limit} are read", file.display())]
    #[diagnostic(help("drop those that are not needed"))]
    TooManyColumns { file: PathBuf, found: usize, limit: usize },
    #[error("{} has no column {missing}, found {found}", file.display())]
    #[diagnostic(help(
        "name the columns t, q1…qn, dq1…dqn, ddq1…ddqn, tau1…taun, or write a profile that says which \
         column is what: inspect suggests one"
    ))]
    NoColumn { file: PathBuf, missing: &'static str, found: String },
    #[error("{} has column {present} but no {missing}", file.display())]
    #[diagnostic(help(
        "joints are numbered 1…n, or all from 0, and a signal has all of them; add {missing} or drop \
         {present}"
    ))]
    MissingColumn { file: PathBuf, missing: String, present: String },
    #[error("{} has no header: its first line holds numbers alone", file.display())]
    #[diagnostic(help(
        "name the columns in a first line, such as t,q1,q2,dq1,dq2,tau1,tau2, in the order that they \
         stand in"
    ))]
    NoHeader { file: PathBuf },
    #[error("{} has two columns {column}", file.display())]
    #[diagnostic(help("drop or rename one"))]
    DuplicateColumn { file: PathBuf, column: String },
    #[error("{}: column {column} is of type {found}, expected numbers", file.display())]
    #[diagnostic(help("convert it to 64-bit floats"))]
    NotNumeric { file: PathBuf, column: String, found: String },
    #[error("{place} has {found} fields, the header has {expected}")]
    #[diagnostic(help("complete or drop the row"))]
    Ragged { place: RowPlace, found: usize, expected: usize },
    #[error("{place}, column {column}: \"{text}\" is not a number")]
    #[diagnostic(help("repair or drop the row"))]
    NotANumber { place: RowPlace, column: String, text: String },
    #[error("{place}, column {column} is {value}{}", if value.is_nan() { " or empty" } else { "" })]
    #[diagnostic(help("repair or drop the row"))]
    NotFinite { place: RowPlace, column: String, value: f64 },
    #[error("{place}: t = {t:?} s does not follow {before:?} s")]
    #[diagnostic(help(
        "sort the rows and drop repeated ones, or put each trajectory in a file of its own"
    ))]
    TimeOrder { place: RowPlace, t: f64, before: f64 },
    #[error(
        "{place}: {repeated} rows repeat the time stamp before them, {rows} do not: stamps are \
         rounded too far"
    )]
    #[diagnostic(help(
        "record finer ones, or say how many rows there are in a second by a profile with the line \
         `rate = HZ`"
    ))]
    CoarseClock { place: RowPlace, repeated: u64, rows: u64 },
    #[error("{} is a folder without .db3 or .mcap files", file.display())]
    #[diagnostic(help("give the folder of a ROS 2 bag, or log files"))]
    EmptyFolder { file: PathBuf },
    #[error("{} is damaged beyond decoding", file.display())]
    #[diagnostic(help("copy or convert it again"))]
    Damaged { file: PathBuf },
    #[error(
        "{} is no bag of ROS 2 (an SQLite database with tables topics and messages)",
        file.display()
    )]
    #[diagnostic(help("record it again or convert it with ros2 bag convert"))]
    NoBag { file: PathBuf },
    #[error("{place}: the message does not name joint {joint}, only {found}")]
    #[diagnostic(help("list the joints that all messages have as joints = […] in a profile"))]
    JointGone { place: RowPlace, joint: String, found: String },
    #[error("{}, array {array}: {reason}", file.display())]
    #[diagnostic(help("save it again as an array of plain numbers"))]
    Array { file: PathBuf, array: String, reason: &'static str },
    #[error("{profile}: {key} has {found}, expected {expected}")]
    ProfileKey { profile: String, key: String, found: String, expected: String },
    #[error("{} names {found} joints but has {expected}", file.display())]
    #[diagnostic(help("name each joint once"))]
    JointNameCount { file: PathBuf, found: usize, expected: usize },
    #[error("joint name \"{name}\" cannot be kept in a log")]
    #[diagnostic(help(
        "take a name that occurs once, has at most 200 bytes and no comma, control character or \
         outer space"
    ))]
    JointName { name: String },
    #[error("{} has {found} joints, {} has {expected}", file.display(), first.display())]
    #[diagnostic(help("read logs of one arm together"))]
    JointCount { file: PathBuf, found: usize, first: PathBuf, expected: usize },
    #[error("{} has no torque", file.display())]
    #[diagnostic(help("record columns tau1…taun, in a bag effort, or see what inspect suggests"))]
    NoTorque { file: PathBuf },
    #[error(
        "{}, row {row}: only {rows} rows up to the next gap or the end, {needed} are needed to \
         find dq or ddq",
        file.display()
    )]
    #[diagnostic(help("drop them or record dq and ddq"))]
    TooShort { file: PathBuf, row: u64, rows: usize, needed: usize },
    #[error("{} has other columns than when it was opened", file.display())]
    #[diagnostic(help("open it again"))]
    Changed { file: PathBuf },
    #[error("{}, from row {row}: the rows are no motion", file.display())]
    #[diagnostic(forward(source))]
    Motion { file: PathBuf, row: u64, source: MotionError },
    #[error("{} cannot be written", file.display())]
    #[diagnostic(help("check that the folder exists, may be written and has room"))]
    Write { file: PathBuf, source: io::Error },
    #[error("{} is no whole {what}", file.display())]
    #[diagnostic(help("{help}"))]
    Decode {
        file: PathBuf,
        what: &'static str,
        help: &'static str,
        source: Box<dyn Error + Send + Sync>,
    },
    /// Anything else that is wrong with a log.
    #[error("{problem}")]
    #[diagnostic(help("{help}"))]
    Unusable { problem: String, help: &'static str },
}

impl LogError {
    pub(crate) fn read(file: &Path) -> impl Fn(io::Error) -> Self {
        move |source| Self::Read { file: file.into(), source }
    }

    pub(crate) fn unusable(place: impl fmt::Display, problem: &str, help: &'static str) -> Self {
        Self::Unusable { problem: format!("{place}{problem}"), help }
    }

    #[cfg(feature = "formats")]
    pub(crate) fn decode<E: Into<Box<dyn Error + Send + Sync>>>(
        file: &Path,
        format: Format,
    ) -> impl Fn(E) -> Self {
        let (what, help) = match format {
            Format::Csv => ("CSV file", "save it again"),
            Format::Parquet => ("Parquet file", "copy or convert it again"),
            Format::Db3 => ("SQLite bag", "copy it again or repair it"),
            Format::Mcap => ("MCAP file", "copy it again or run mcap recover"),
            Format::Npz => ("NumPy archive", "save it again with numpy.savez"),
            Format::Mat => ("MAT file of version 5", "save it again with -v7"),
        };
        move |source| Self::Decode { file: file.into(), what, help, source: source.into() }
    }
}

/// Work of a decoder of another crate, which may panic on a damaged file: here that is an error like
/// any other.
#[cfg(feature = "formats")]
pub(crate) fn guarded<T>(file: &Path, work: impl FnOnce() -> Result<T>) -> Result<T> {
    let before = DECODES.replace(true);
    let done = catch_unwind(AssertUnwindSafe(work));
    DECODES.set(before);
    done.unwrap_or_else(|_| Err(LogError::Damaged { file: file.into() }))
}

#[cfg(feature = "formats")]
thread_local! {
    static DECODES: Cell<bool> = const { Cell::new(false) };
}

/// Whether this thread is within a decoder whose panic becomes an error: a program's panic hook need
/// print nothing of it.
#[cfg(feature = "formats")]
pub fn decodes() -> bool {
    DECODES.get()
}

/// Names side by side, `most` of them at most.
pub(crate) fn listed(names: &[String], most: usize) -> String {
    let all: Vec<_> = names.iter().take(most).map(|name| shown(name.as_bytes())).collect();
    all.join(", ") + if names.len() > most { ", …" } else { "" }
}

/// At most 40 characters of a text, with whatever does not print escaped.
pub(crate) fn shown(text: &[u8]) -> String {
    const LONGEST: usize = 40;
    // A character has at most four bytes, so this is enough and bounds the work.
    let head = String::from_utf8_lossy(&text[..text.len().min(4 * LONGEST + 4)]);
    let mut shown: String = head.chars().take(LONGEST).flat_map(char::escape_debug).collect();
    if head.chars().count() > LONGEST {
        shown.push('…');
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::shown;

    #[test]
    fn text_is_cut_to_forty_characters_and_escaped() {
        assert_eq!(shown(b"1.5x"), "1.5x");
        assert_eq!(shown(b"a\x1b[2J\n\xff"), "a\\u{1b}[2J\\n\u{fffd}");
        assert_eq!(shown("é".repeat(1_000).as_bytes()), "é".repeat(40) + "…");
    }
}
