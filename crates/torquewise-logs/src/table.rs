//! Columns of values, and motion, as CSV or Parquet, written whole or not at all.

#[cfg(feature = "formats")]
use crate::parquet_sink::ParquetSink;
use crate::sink::{CsvSink, Sink};
use crate::{Column, Format, LogError, Result, Values, joints};
use std::path::{Path, PathBuf};
use torquewise_motion::{Motion, Signal};

/// A table that is written block by block, in fixed memory.
///
/// The rows go to a temporary file in the same folder, which [`finish`](Self::finish) renames. A
/// writer dropped before that leaves nothing behind, and an older file of that name as it was.
pub struct TableWriter {
    file: PathBuf,
    columns: Vec<Column>,
    sink: Box<dyn Sink>,
}

impl TableWriter {
    /// Starts a `.csv` or `.parquet` file.
    ///
    /// # Errors
    /// [`LogError`] if the extension is another one or the folder cannot be written to.
    pub fn create(file: &Path, columns: &[Column]) -> Result<Self> {
        Self::start(file, columns, None)
    }

    /// Starts a `.csv` or `.parquet` log of the named joints: t, q, dq, ddq, and tau where it is
    /// wanted.
    ///
    /// The names are kept in the metadata of a `.parquet` file. A `.csv` file has a first line with
    /// them (`# joints: …`) only if they are not joint1 … jointn, since not every program reads
    /// comments.
    ///
    /// # Errors
    /// As [`create`](Self::create), and [`LogError::JointName`] if a name cannot be kept.
    pub fn log(file: &Path, joints: &[String], with_tau: bool) -> Result<Self> {
        let signals = if with_tau { &Signal::ALL[..] } else { &Signal::ALL[..3] };
        let names: Vec<&str> = signals.iter().map(|signal| signal.name()).collect();
        let is_named = joints != joints::numbered(joints.len());
        if is_named {
            joints::check(joints)?;
        }
        let kept = is_named.then(|| joints.join(","));
        Self::start(file, &Column::of_joints(&names, joints.len()), kept.as_deref())
    }

    fn start(file: &Path, columns: &[Column], joints: Option<&str>) -> Result<Self> {
        let sink: Box<dyn Sink> = match Format::of(file)? {
            Format::Csv => Box::new(CsvSink::create(file, columns, joints)?),
            #[cfg(feature = "formats")]
            Format::Parquet => Box::new(ParquetSink::create(file, columns, joints)?),
            _ => {
                let problem = ": this format is only read";
                let help = "name the output .csv or .parquet";
                return Err(LogError::unusable(file.display(), problem, help));
            }
        };
        Ok(Self { file: file.into(), columns: columns.to_vec(), sink })
    }

    /// Writes some rows: one slice per column, all of the same length.
    ///
    /// # Errors
    /// [`LogError::Unusable`] if the values do not fit the columns; [`LogError::Write`].
    pub fn append(&mut self, values: &[Values<'_>]) -> Result<()> {
        let misfit = |problem: String| {
            let help = "give values for the columns it was created with, one per row";
            Err(LogError::unusable(self.file.display(), &format!(": {problem}"), help))
        };
        let (found, expected) = (values.len(), self.columns.len());
        if found != expected {
            return misfit(format!("{found} columns of values for a table of {expected}"));
        }
        let rows = values.first().map_or(0, |first| first.len());
        for (Column { name, kind }, values) in self.columns.iter().zip(values) {
            let (found, expected) = (values.name(), kind.name());
            if found != expected {
                let problem = format!("column {name} is to hold {expected}, but {found} is given");
                return misfit(problem);
            }
            let found = values.len();
            if found != rows {
                return misfit(format!("column {name} has {found} values, the first {rows}"));
            }
        }
        if rows == 0 { Ok(()) } else { self.sink.append(values, rows) }
    }

    /// Writes the rows of a block of motion to a [`log`](Self::log), which is to hold torque only if
    /// the motion has it.
    ///
    /// # Errors
    /// As [`append`](Self::append).
    pub fn append_motion(&mut self, motion: &Motion) -> Result<()> {
        let mut signals = vec![motion.q(), motion.dq(), motion.ddq()];
        signals.extend(motion.tau());
        let mut columns = vec![motion.t().to_vec()];
        for column in signals.iter().flat_map(|signal| signal.col_iter()) {
            columns.push(column.iter().copied().collect());
        }
        columns.truncate(self.columns.len());
        let values: Vec<_> = columns.iter().map(|column| Values::Numbers(column)).collect();
        self.append(&values)
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// [`LogError::Write`]; the temporary file is then removed.
    pub fn finish(self) -> Result<()> {
        self.sink.finish()
    }
}

/// Writes a whole motion as a `.csv` or `.parquet` log that reads back to the same bits.
///
/// # Errors
/// As [`TableWriter::log`], [`TableWriter::append_motion`] and [`TableWriter::finish`].
pub fn write_motion(file: &Path, motion: &Motion) -> Result<()> {
    let mut writer = TableWriter::log(file, motion.joints(), motion.tau().is_some())?;
    writer.append_motion(motion)?;
    writer.finish()
}
