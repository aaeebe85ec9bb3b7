//! Motion written as a log file.

use crate::error::{LogError, Result};
use crate::joints;
use crate::sink::{Column, Values};
use crate::table::TableWriter;
use faer::MatRef;
use std::path::{Path, PathBuf};
use torquewise_motion::Motion;
use torquewise_motion::signals::Signal;

/// A log file that is written block by block; it appears when it is whole.
pub struct LogWriter {
    file: PathBuf,
    signals: &'static [Signal],
    table: TableWriter,
}

impl LogWriter {
    /// Starts a `.csv` or `.parquet` log of the named joints: t, q, dq, ddq, and tau where it is
    /// wanted.
    ///
    /// A CSV file has a first line with the names only if they are not joint1 … jointn, since not
    /// every program reads comments.
    ///
    /// # Errors
    /// As [`TableWriter::create`], and [`LogError::JointName`] if a name cannot be kept.
    pub fn create(file: &Path, joints: &[String], with_tau: bool) -> Result<Self> {
        let signals = if with_tau { &Signal::ALL[..] } else { &Signal::ALL[..3] };
        let mut names = vec!["t".to_owned()];
        for signal in signals {
            names.extend((1..=joints.len()).map(|joint| format!("{}{joint}", signal.name())));
        }
        let columns = Column::numbers(&names);
        let is_named = joints != joints::numbered(joints.len());
        let kept = is_named.then(|| joints::join(joints)).transpose()?;
        let table = TableWriter::start(file, &columns, kept.as_deref())?;
        Ok(Self { file: file.into(), signals, table })
    }

    /// Writes the rows of a block after those before.
    ///
    /// # Errors
    /// [`LogError::NoTorqueToWrite`] if the log is to hold torques and the motion has none, or what
    /// [`TableWriter::append`] returns.
    pub fn append(&mut self, motion: &Motion) -> Result<()> {
        let no_torque = || LogError::NoTorqueToWrite { file: self.file.clone() };
        let mut columns = vec![motion.t().to_vec()];
        for signal in self.signals {
            let values: MatRef<'_, f64> = match signal {
                Signal::Q => motion.q(),
                Signal::Dq => motion.dq(),
                Signal::Ddq => motion.ddq(),
                Signal::Tau => motion.tau().ok_or_else(no_torque)?,
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
    pub fn finish(self) -> Result<()> {
        self.table.finish()
    }
}

/// Writes a whole motion as a `.csv` or `.parquet` log that reads back to the same bits.
///
/// # Errors
/// As [`LogWriter::create`], [`LogWriter::append`] and [`LogWriter::finish`].
pub fn write_motion(file: &Path, motion: &Motion) -> Result<()> {
    let mut writer = LogWriter::create(file, motion.joints(), motion.tau().is_some())?;
    writer.append(motion)?;
    writer.finish()
}
