//! Path → rows: a log file that can be read any number of times.

use crate::csv_rows::CsvRows;
use crate::error::LogError;
use crate::format::Format;
use crate::layout::Layout;
use crate::parquet_rows::ParquetRows;
use crate::rows::Rows;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// Bytes read from a text file at once.
const BUFFER_BYTES: usize = 1 << 16;

/// A log file and what its header says.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    pub(crate) file: PathBuf,
    pub(crate) layout: Layout,
    pub(crate) joints: Option<Vec<String>>,
    format: Format,
}

impl Source {
    /// Reads the header only.
    pub(crate) fn open(file: &Path) -> Result<Self, LogError> {
        let format = Format::of(file)?;
        let rows = rows(file, format)?;
        let joints = rows.joints().map(<[String]>::to_vec);
        Ok(Self { file: file.into(), layout: rows.layout().clone(), joints, format })
    }

    /// The rows, from the first one.
    pub(crate) fn rows(&self) -> Result<Box<dyn Rows>, LogError> {
        let rows = rows(&self.file, self.format)?;
        if *rows.layout() != self.layout {
            return Err(LogError::Changed { file: self.file.clone() });
        }
        Ok(rows)
    }
}

fn rows(file: &Path, format: Format) -> Result<Box<dyn Rows>, LogError> {
    Ok(match format {
        Format::Csv => {
            let input = File::open(file).map_err(LogError::read(file))?;
            Box::new(CsvRows::new(file, BufReader::with_capacity(BUFFER_BYTES, input))?)
        }
        Format::Parquet => Box::new(ParquetRows::open(file)?),
    })
}
