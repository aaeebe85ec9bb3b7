//! From motion to log file.

use crate::columns::{Column, ColumnKind, Values};
use crate::error::LogError;
use crate::joints;
use crate::layout::Signal;
use crate::table::TableWriter;
use faer::MatRef;
use std::path::{Path, PathBuf};
use torquewise_motion::Motion;

/// The signals that a log is to hold besides t and q.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Contents {
    /// Velocities.
    pub dq: bool,
    /// Accelerations.
    pub ddq: bool,
    /// Torques.
    pub tau: bool,
}

impl Default for Contents {
    /// All of them.
    fn default() -> Self {
        Self { dq: true, ddq: true, tau: true }
    }
}

/// A log file that is written block by block; it appears when it is whole.
pub struct LogWriter {
    file: PathBuf,
    contents: Contents,
    table: TableWriter,
}

impl LogWriter {
    /// Starts a `.csv` or `.parquet` log of the named joints.
    ///
    /// A CSV file has a first line with the names only if they are not joint1 … jointn, since not
    /// every program reads comments.
    ///
    /// # Errors
    /// As [`TableWriter::create_with_joints`].
    pub fn create(file: &Path, joints: &[String], contents: Contents) -> Result<Self, LogError> {
        let number = |name: String| Column::new(name, ColumnKind::Number);
        let mut columns = vec![number("t".into())];
        for signal in Signal::ALL.into_iter().filter(|signal| contents.has(*signal)) {
            let names = (1..=joints.len()).map(|joint| format!("{}{joint}", signal.name()));
            columns.extend(names.map(number));
        }
        let table = if joints == joints::numbered(joints.len()) {
            TableWriter::create(file, &columns)?
        } else {
            TableWriter::create_with_joints(file, &columns, joints)?
        };
        Ok(Self { file: file.into(), contents, table })
    }

    /// Writes the rows of a block after those before.
    ///
    /// # Errors
    /// [`LogError::NoTorqueToWrite`] if the log is to hold torques and the motion has none,
    /// [`LogError::ValuesCount`] if it has another number of joints, or what
    /// [`TableWriter::append`] returns.
    pub fn append(&mut self, motion: &Motion) -> Result<(), LogError> {
        let mut columns = vec![motion.t().to_vec()];
        for signal in Signal::ALL.into_iter().filter(|signal| self.contents.has(*signal)) {
            let values: MatRef<'_, f64> = match signal {
                Signal::Q => motion.q(),
                Signal::Dq => motion.dq(),
                Signal::Ddq => motion.ddq(),
                Signal::Tau => motion
                    .tau()
                    .ok_or_else(|| LogError::NoTorqueToWrite { file: self.file.clone() })?,
            };
            columns.extend(values.col_iter().map(|column| column.iter().copied().collect()));
        }
        let values: Vec<_> = columns.iter().map(|column| Values::Numbers(column)).collect();
        self.table.append(&values)
    }

    /// Puts the log in its place.
    ///
    /// # Errors
    /// As [`TableWriter::finish`].
    pub fn finish(self) -> Result<(), LogError> {
        self.table.finish()
    }
}

impl Contents {
    fn has(self, signal: Signal) -> bool {
        match signal {
            Signal::Q => true,
            Signal::Dq => self.dq,
            Signal::Ddq => self.ddq,
            Signal::Tau => self.tau,
        }
    }
}

/// Writes a whole motion as a `.csv` or `.parquet` log that reads back to the same bits.
///
/// # Errors
/// As [`LogWriter::create`], [`LogWriter::append`] and [`LogWriter::finish`].
pub fn write_motion(file: &Path, motion: &Motion) -> Result<(), LogError> {
    let contents = Contents { tau: motion.tau().is_some(), ..Contents::default() };
    let mut writer = LogWriter::create(file, motion.joints(), contents)?;
    writer.append(motion)?;
    writer.finish()
}
