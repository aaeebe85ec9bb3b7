//! Columns of a table, and where their values go: a temporary file that takes its place when it is
//! whole.

use crate::{CSV_COMMENT, LogError, Result};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use torquewise_motion::whole_file::Output;

/// The name of a column, and what it holds.
#[derive(Clone, Debug)]
pub struct Column {
    /// Name, as it stands in the header.
    pub name: String,
    /// No values, of its kind.
    pub kind: Values<'static>,
}

impl Column {
    /// A column of values such as these.
    pub fn new(name: impl Into<String>, kind: Values<'static>) -> Self {
        Self { name: name.into(), kind }
    }

    /// Columns of numbers.
    pub fn numbers(names: &[String]) -> Vec<Self> {
        names.iter().map(|name| Self::new(name, Values::Numbers(&[]))).collect()
    }

    /// Columns of t and of signals, each of these with the number of each joint from 1 on.
    pub fn of_joints(signals: &[&str], n_joints: usize) -> Vec<Self> {
        let mut names = vec!["t".to_owned()];
        for signal in signals {
            names.extend((1..=n_joints).map(|joint| format!("{signal}{joint}")));
        }
        Self::numbers(&names)
    }
}

/// Some rows of one column.
#[derive(Clone, Copy, Debug)]
pub enum Values<'a> {
    /// Floating-point numbers, read back to the same bits.
    Numbers(&'a [f64]),
    /// Whole numbers, such as a row number.
    Counts(&'a [u64]),
    /// Text, such as the name of a pattern.
    Texts(&'a [&'a str]),
}

impl Values<'_> {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Numbers(_) => "numbers",
            Self::Counts(_) => "counts",
            Self::Texts(_) => "text",
        }
    }

    /// Number of rows.
    pub(crate) fn len(self) -> usize {
        match self {
            Self::Numbers(values) => values.len(),
            Self::Counts(values) => values.len(),
            Self::Texts(values) => values.len(),
        }
    }
}

pub(crate) trait Sink {
    fn append(&mut self, values: &[Values<'_>], rows: usize) -> Result<()>;

    fn finish(self: Box<Self>) -> Result<()>;
}

pub(crate) struct CsvSink {
    file: PathBuf,
    output: BufWriter<Output>,
}

impl CsvSink {
    pub(crate) fn create(file: &Path, columns: &[Column], joints: Option<&str>) -> Result<Self> {
        let names: Vec<_> = columns.iter().map(|column| [column.name.as_str()]).collect();
        let header: Vec<_> = names.iter().map(|name| Values::Texts(name)).collect();
        let create = || {
            let output = BufWriter::new(Output::create(file)?);
            let mut sink = Self { file: file.into(), output };
            if let Some(joints) = joints {
                writeln!(sink.output, "{CSV_COMMENT} {joints}")?;
            }
            sink.write_row(&header, 0)?;
            Ok(sink)
        };
        create().map_err(write_error(file))
    }

    fn write_row(&mut self, values: &[Values<'_>], row: usize) -> io::Result<()> {
        for (place, column) in values.iter().enumerate() {
            if place > 0 {
                self.output.write_all(b",")?;
            }
            match column {
                // The shortest digits that are read back to the same bits.
                Values::Numbers(values) => write!(self.output, "{:?}", values[row])?,
                Values::Counts(values) => write!(self.output, "{}", values[row])?,
                Values::Texts(values) => write_text(&mut self.output, values[row])?,
            }
        }
        writeln!(self.output)
    }
}

/// A field, in quotes where it would not be read back without.
fn write_text(output: &mut impl Write, text: &str) -> io::Result<()> {
    if !text.is_empty() && !text.contains([',', '"', '\n', '\r', '#']) {
        return output.write_all(text.as_bytes());
    }
    write!(output, "\"{}\"", text.replace('"', "\"\""))
}

impl Sink for CsvSink {
    fn append(&mut self, values: &[Values<'_>], rows: usize) -> Result<()> {
        (0..rows).try_for_each(|row| self.write_row(values, row)).map_err(write_error(&self.file))
    }

    fn finish(self: Box<Self>) -> Result<()> {
        let written = self.output.into_inner().map_err(io::IntoInnerError::into_error);
        written.and_then(Output::put_in_place).map_err(write_error(&self.file))
    }
}

pub(crate) fn write_error(file: &Path) -> impl Fn(io::Error) -> LogError {
    move |source| LogError::Write { file: file.into(), source }
}
