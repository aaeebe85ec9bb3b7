//! Arrays of a file by name, shape and place: what NumPy and MATLAB files are decoded to.

use crate::arrays::numbers::{Element, Numbers};
use crate::{Format, LogError, LogInput, Result, shown};
use flate2::CrcReader;
use flate2::read::{DeflateDecoder, ZlibDecoder};
use std::io::{self, BufReader, Read, Seek, SeekFrom};

/// Series of one array at most; a wider one, such as an image, is no signal of a robot.
const MAX_SERIES: usize = 256;

pub(super) const MAX_COLUMNS: usize = 10_000;

pub(super) const LONGEST_NAME: usize = 4_096;

#[derive(Clone, Debug)]
pub(super) struct Array {
    pub(super) name: String,
    pub(super) rows: usize,
    pub(super) columns: usize,
    /// Whether its columns are stored one after the other, rather than its rows.
    pub(super) is_by_column: bool,
    /// Where its bytes begin, or what they are packed in.
    pub(super) start: u64,
    /// Bytes from there on at most.
    pub(super) stored: u64,
    pub(super) packing: Packing,
    /// Bytes, once unpacked, before the first element.
    pub(super) before: u64,
    /// What is held against all bytes, if anything is.
    pub(super) checksum: Option<u32>,
    /// What an element is, or why it cannot be read.
    pub(super) element: Result<Element, &'static str>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Packing {
    Plain,
    Deflate,
    Zlib,
}

impl Array {
    fn open(&self, file: &LogInput, element: Element, first: u64) -> io::Result<Numbers> {
        let mut input = file.open()?;
        input.seek(SeekFrom::Start(self.start))?;
        let input = BufReader::new(input.take(self.stored));
        let mut input: Box<dyn Read + Send> = match self.packing {
            Packing::Plain => Box::new(input),
            Packing::Deflate => Box::new(DeflateDecoder::new(input)),
            Packing::Zlib => Box::new(ZlibDecoder::new(input)),
        };
        if let Some(checksum) = self.checksum {
            input = Box::new(Checked { input: CrcReader::new(input), checksum });
        }
        let before = self.before + first * element.size as u64;
        let passed = io::copy(&mut input.by_ref().take(before), &mut io::sink())?;
        if passed < before {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        Ok(Numbers::new(input, element))
    }

    /// Whether it holds signals: instants, and no more series than a robot has.
    pub(super) fn is_signal(&self) -> bool {
        let (instants, series) = self.instants_and_series();
        instants > 1 && (1..=MAX_SERIES).contains(&series) && self.name.len() <= LONGEST_NAME
    }

    /// Instants along the longer side, and series along the other; a square has rows of instants.
    pub(super) fn instants_and_series(&self) -> (usize, usize) {
        (self.rows.max(self.columns), self.rows.min(self.columns))
    }

    /// Whether the series of one instant stand side by side, rather than the instants of a series.
    pub(super) fn is_by_instant(&self) -> bool {
        (self.rows >= self.columns) != self.is_by_column
    }

    pub(super) fn n_bytes(&self, element: Element) -> Option<u64> {
        let count = u64::try_from(self.rows.checked_mul(self.columns)?).ok()?;
        count.checked_mul(element.size as u64)
    }

    pub(super) fn numbers(&self, file: &LogInput, first: u64) -> Result<Numbers> {
        let refused = |reason| LogError::Array {
            file: file.into(),
            array: shown(self.name.as_bytes()),
            reason,
        };
        let element = self.element.map_err(refused)?;
        let format = Format::of(file)?;
        self.open(file, element, first).map_err(LogError::decode(file, format))
    }
}

/// Bytes that are held against their checksum at the end.
struct Checked {
    input: CrcReader<Box<dyn Read + Send>>,
    checksum: u32,
}

impl Read for Checked {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let n_read = self.input.read(into)?;
        if n_read == 0 && !into.is_empty() && self.input.crc().sum() != self.checksum {
            return Err(io::Error::new(io::ErrorKind::InvalidData, "its checksum is another"));
        }
        Ok(n_read)
    }
}

#[cfg(test)]
mod tests {
    use super::{Array, Packing};

    #[test]
    fn scalars_images_and_long_names_are_no_signals() {
        let (packing, element) = (Packing::Plain, Err("nothing"));
        let (start, stored, before, checksum, is_by_column) = (0, 0, 0, None, false);
        let array = |name: &str, rows, columns| {
            let name = name.into();
            Array {
                name,
                rows,
                columns,
                is_by_column,
                start,
                stored,
                packing,
                before,
                checksum,
                element,
            }
            .is_signal()
        };
        assert!(array("q", 2, 1) && array("q", 300, 256));
        assert!(!array("q", 1, 1) && !array("q", 0, 5) && !array("q", 300, 300));
        assert!(!array(&"q".repeat(5_000), 2, 1));
    }
}
