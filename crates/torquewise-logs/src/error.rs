//! Errors of reading and writing logs: file, row and column at fault.
#![expect(missing_docs, reason = "each message explains its fields")]

#[cfg(feature = "parquet")]
use parquet::errors::ParquetError;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use torquewise_motion::MotionError;

/// A row of a log file, as its user counts it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The log file.
    pub file: PathBuf,
    /// Data row, 1 for the first after the header.
    pub row: u64,
    /// Line of a text file, 1 for the first.
    pub line: Option<u64>,
}

impl fmt::Display for Place {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}, row {}", self.file.display(), self.row)?;
        self.line.map_or(Ok(()), |line| write!(out, " (line {line})"))
    }
}

/// Why a log cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LogError {
    #[error("no log file is given: name at least one")]
    NoFiles,
    #[error(
        "{}: {extension:?} is no log format known here: logs are .csv, .parquet, .db3, .mcap, \
         .npz or .mat files; convert it to one of them",
        file.display()
    )]
    UnknownExtension { file: PathBuf, extension: String },
    #[error("{} cannot be read: check that it exists and may be read", file.display())]
    Read { file: PathBuf, source: io::Error },

    #[error("{} is empty: expected a header with t, q1, …", file.display())]
    Empty { file: PathBuf },
    #[error(
        "{} is a pipe or a device, not a file, and a log is read several times: copy it to a file",
        file.display()
    )]
    NotAFile { file: PathBuf },
    #[error("{}, trajectory {trajectory}: its signals cannot be conditioned", file.display())]
    Signals { file: PathBuf, trajectory: usize, source: torquewise_motion::signals::SignalError },
    #[error(
        "no trajectory is long enough to be filtered at {cutoff:.2} Hz: \
         raise the cut-off, or record longer motions"
    )]
    NothingLeft { cutoff: f64 },
    #[error("{} has a header but no rows: record the motion again", file.display())]
    NoRows { file: PathBuf },
    #[error(
        "{}: columns are separated by {found:?}: write them with commas and decimal points",
        file.display()
    )]
    Delimiter { file: PathBuf, found: char },
    #[error("{}, line {line} is not UTF-8 text: save the file as UTF-8", file.display())]
    NotUtf8 { file: PathBuf, line: u64 },
    #[error(
        "{}, line {line} holds over {limit} bytes in one {part}: is this a CSV file?",
        file.display()
    )]
    TooLong { file: PathBuf, line: u64, part: &'static str, limit: usize },
    #[error(
        "{}, line {line}: a quoted field does not end in a quote and a comma: repair the quotes",
        file.display()
    )]
    OpenQuote { file: PathBuf, line: u64 },
    #[error(
        "{} has {found} columns, at most {limit} are read: drop those that are not needed",
        file.display()
    )]
    TooManyColumns { file: PathBuf, found: usize, limit: usize },

    #[error(
        "{} has no column {missing}, found {found}: name the columns t, q1…qn, dq1…dqn, \
         ddq1…ddqn, tau1…taun",
        file.display()
    )]
    NoColumn { file: PathBuf, missing: &'static str, found: String },
    #[error(
        "{} has column {present} but no {missing}: joints are numbered 1…n and a signal has \
         all of them; add {missing} or drop {present}",
        file.display()
    )]
    MissingColumn { file: PathBuf, missing: String, present: String },
    #[error("{}: column {column} counts joints from 0: count them from 1", file.display())]
    ZeroBased { file: PathBuf, column: String },
    #[error("{} has two columns {column}: drop or rename one", file.display())]
    DuplicateColumn { file: PathBuf, column: String },
    #[error(
        "{}: column {column} is of type {found}, expected numbers: convert it to 64-bit floats",
        file.display()
    )]
    NotNumeric { file: PathBuf, column: String, found: String },

    #[error("{place} has {found} fields, the header has {expected}: complete or drop the row")]
    Ragged { place: Place, found: usize, expected: usize },
    #[error("{place}, column {column}: \"{text}\" is not a number: repair or drop the row")]
    NotANumber { place: Place, column: String, text: String },
    #[error("{place}, column {column} is {value}: repair or drop the row")]
    NotFinite { place: Place, column: String, value: f64 },
    #[error("{place}, column {column} has no value (null): fill it or drop the row")]
    Null { place: Place, column: String },
    #[error(
        "{place}: t = {t} s does not follow {before} s: sort the rows and drop repeated ones, \
         or put each trajectory in a file of its own"
    )]
    TimeOrder { place: Place, t: f64, before: f64 },
    #[error(
        "{place}: {repeated} rows repeat the time stamp before them, {rows} do not: stamps are \
         rounded too far; record finer ones, or say how many rows there are in a second by a \
         profile with the line `rate = HZ`"
    )]
    CoarseClock { place: Place, repeated: u64, rows: u64 },
    #[error(
        "{}: this build of torquewise reads no .{extension}: build it with the feature {feature}",
        file.display()
    )]
    NotBuilt { file: PathBuf, extension: String, feature: &'static str },
    #[error(
        "{} is a folder without .db3 or .mcap files: give the folder of a ROS 2 bag, or log files",
        file.display()
    )]
    EmptyFolder { file: PathBuf },

    #[cfg(feature = "parquet")]
    #[error("{} is not a whole Parquet file: copy or convert it again", file.display())]
    Parquet { file: PathBuf, source: ParquetError },
    #[cfg(feature = "parquet")]
    #[error("{}: a row group cannot be decoded: copy or convert the file again", file.display())]
    RowGroup { file: PathBuf, source: ParquetError },
    #[error(
        "{}: the pages of one row group take {megabytes} MB, at most {limit} are held: write it \
         with pages of 1 MB (data_page_size) or fewer rows in a row group",
        file.display()
    )]
    LargePages { file: PathBuf, megabytes: u64, limit: u64 },
    #[error("{} is damaged beyond decoding: copy or convert it again", file.display())]
    Damaged { file: PathBuf },
    #[error("{} cannot be decoded: copy or convert it again", file.display())]
    Decode { file: PathBuf, source: io::Error },

    #[error(
        "{} is no bag of ROS 2 (an SQLite database with tables topics and messages): record it \
         again or convert it with ros2 bag convert",
        file.display()
    )]
    NoBag { file: PathBuf },
    #[cfg(feature = "bags")]
    #[error("{} cannot be read as an SQLite bag: copy it again or repair it", file.display())]
    Database { file: PathBuf, source: rusqlite::Error },
    #[cfg(feature = "bags")]
    #[error("{} is no whole MCAP file: copy it again or run mcap recover", file.display())]
    Mcap { file: PathBuf, source: Box<mcap::McapError> },
    #[error(
        "{} has no joint states (sensor_msgs/msg/JointState in CDR), its topics are {found}: \
         record /joint_states",
        file.display()
    )]
    NoJointState { file: PathBuf, found: String },
    #[error(
        "{} has several topics of joint states, {found}: choose one with --topic NAME, \
         or topic = \"…\" in a profile",
        file.display()
    )]
    SeveralTopics { file: PathBuf, found: String },
    #[error(
        "{} has no joint states on topic {topic}, its topics are {found}: choose one of type \
         sensor_msgs/msg/JointState that has messages",
        file.display()
    )]
    NoSuchTopic { file: PathBuf, topic: String, found: String },
    #[error(
        "{} has no message of the joints {wanted}, its first names {found}: name joints as the bag \
         does",
        file.display()
    )]
    NoSuchJoints { file: PathBuf, wanted: String, found: String },
    #[error("{place}: the message is no joint state, {reason}: record or convert the bag again")]
    Message { place: Place, reason: &'static str },
    #[error(
        "{place}: the message does not name joint {joint}, only {found}: list the joints that all \
         messages have as joints = […] in a profile"
    )]
    JointGone { place: Place, joint: String, found: String },
    #[cfg(feature = "arrays")]
    #[error("{} is no whole NumPy archive: save it again with numpy.savez", file.display())]
    Npz { file: PathBuf, source: zip::result::ZipError },
    #[error("{}, array {array}: {reason}: save it again with numpy.savez", file.display())]
    Array { file: PathBuf, array: String, reason: &'static str },
    #[error("{} is no whole MAT file of version 5: save it again with -v7", file.display())]
    Mat { file: PathBuf, source: io::Error },
    #[error(
        "{}: column {column} has {found} values, column {first} has {expected}: use arrays with \
         the same number of instants",
        file.display()
    )]
    ArrayLength { file: PathBuf, column: String, found: usize, first: String, expected: usize },

    #[error("{profile}, line {line}: {reason}: see the keys of a profile in profiles/README.md")]
    ProfileText { profile: String, line: usize, reason: String },
    #[error("{profile}: {key} has {found}, expected {expected}")]
    ProfileKey { profile: String, key: String, found: String, expected: String },
    #[error(
        "{} has no column {missing}, which {key} of the profile needs, found {found}: name the \
         columns as the file does",
        file.display()
    )]
    NoProfileColumn { file: PathBuf, key: String, missing: String, found: String },
    #[error(
        "{} has no clock, found {found}: name its column as [t] column = \"…\" or give \
         rate = … (Hz) in the profile",
        file.display()
    )]
    NoClock { file: PathBuf, found: String },
    #[error("{}: the profile leaves out all joints: keep one", file.display())]
    NoJointsLeft { file: PathBuf },
    #[error(
        "{}: no column of it is used: name its columns as NAME.column, or drop it from [beside]",
        file.display()
    )]
    BesideUnused { file: PathBuf },
    #[error(
        "{} has {found} rows, {} has {expected}: files beside each other have the same rows",
        file.display(),
        log.display()
    )]
    RowsDiffer { file: PathBuf, found: u64, log: PathBuf, expected: u64 },
    #[error(
        "{place}: column {column} is {found} s, in the log it is {expected} s: files beside each \
         other have the same clock"
    )]
    ClocksDiffer { place: Place, column: String, found: f64, expected: f64 },
    #[error("{place}, column {column} cannot be read: {reason}")]
    Frame { place: Place, column: String, reason: String },
    #[error(
        "{}: none of its {found} rows is left, {dropped} were not finite: check rows and seconds \
         of the profile, and the columns",
        file.display()
    )]
    NoRowsLeft { file: PathBuf, found: u64, dropped: u64 },

    #[error(
        "{} names {found} joints but has {expected}: name each joint once",
        file.display()
    )]
    JointNameCount { file: PathBuf, found: usize, expected: usize },
    #[error(
        "joint name \"{name}\" cannot be kept in a log: take a name that occurs once, has at most 200 \
         bytes and no comma, control character or outer space"
    )]
    JointName { name: String },
    #[error(
        "{} has {found} joints, {} has {expected}: read logs of one arm together",
        file.display(),
        first.display()
    )]
    JointCount { file: PathBuf, found: usize, first: PathBuf, expected: usize },
    #[error(
        "{} names its joints {found}, {} names them {expected}: read logs of one arm together",
        file.display(),
        first.display()
    )]
    JointNames { file: PathBuf, found: String, first: PathBuf, expected: String },
    #[error("{} has no torque: record columns tau1…taun", file.display())]
    NoTorque { file: PathBuf },
    #[error(
        "{} is to hold torque, but the motion has none: leave tau out of its contents",
        file.display()
    )]
    NoTorqueToWrite { file: PathBuf },
    #[error(
        "{}, row {row}: only {rows} rows up to the next gap or the end, {needed} are needed to \
         find dq or ddq: drop them or record dq and ddq",
        file.display()
    )]
    TooShort { file: PathBuf, row: u64, rows: usize, needed: usize },
    #[error("{} has other columns than when it was opened: open it again", file.display())]
    Changed { file: PathBuf },
    #[error("{}, from row {row}: the rows are no motion", file.display())]
    Motion { file: PathBuf, row: u64, source: MotionError },

    #[error(
        "{} cannot be written: check that the folder exists, may be written and has room",
        file.display()
    )]
    Write { file: PathBuf, source: io::Error },
    #[error("{}: this format is only read: name the output .csv or .parquet", file.display())]
    NotWritten { file: PathBuf },
    #[cfg(feature = "parquet")]
    #[error("{} cannot be written as Parquet: check that the disk has room", file.display())]
    WriteParquet { file: PathBuf, source: ParquetError },
    #[error("{}: {found} columns of values for a table of {expected}", file.display())]
    ValuesCount { file: PathBuf, found: usize, expected: usize },
    #[error(
        "{}: column {column} is to hold {expected}, but {found} is given: give values of the \
         kind it was created with",
        file.display()
    )]
    ValuesKind { file: PathBuf, column: String, found: &'static str, expected: &'static str },
    #[error(
        "{}: column {column} has {found} values, the first column {expected}: give one per row",
        file.display()
    )]
    ValuesLength { file: PathBuf, column: String, found: usize, expected: usize },
}

impl LogError {
    pub(crate) fn read(file: &Path) -> impl Fn(io::Error) -> Self {
        move |source| Self::Read { file: file.into(), source }
    }

    pub(crate) fn damaged(file: &Path) -> impl Fn(io::Error) -> Self {
        move |source| Self::Decode { file: file.into(), source }
    }

    #[cfg(feature = "bags")]
    pub(crate) fn database(file: &Path) -> impl Fn(rusqlite::Error) -> Self {
        move |source| Self::Database { file: file.into(), source }
    }

    #[cfg(feature = "arrays")]
    pub(crate) fn npz(file: &Path) -> impl Fn(zip::result::ZipError) -> Self {
        move |source| Self::Npz { file: file.into(), source }
    }

    #[cfg(feature = "parquet")]
    pub(crate) fn row_group(file: &Path) -> impl Fn(ParquetError) -> Self {
        move |source| Self::RowGroup { file: file.into(), source }
    }

    #[cfg(feature = "parquet")]
    pub(crate) fn parquet(file: &Path) -> impl Fn(ParquetError) -> Self {
        move |source| Self::Parquet { file: file.into(), source }
    }
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
