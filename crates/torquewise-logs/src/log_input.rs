//! A file of a log: on a disk, or bytes that another program holds.

#[cfg(feature = "formats")]
use crate::{LogError, Result};
#[cfg(feature = "formats")]
use parquet::file::reader::{ChunkReader, Length};
use std::fmt::Debug;
use std::fs::File;
use std::io::{self, ErrorKind, Read, Seek, SeekFrom};
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Bytes of a file that are held by whoever implements this, such as those of a file dropped on a page.
///
/// They are read some at a time, and several times over.
pub trait HeldBytes: Debug + Send + Sync {
    /// How many there are.
    fn count(&self) -> u64;

    /// Puts those from `first` on into `into`; how many were put there, 0 at the end alone.
    ///
    /// # Errors
    /// Why they cannot be had.
    fn read(&self, first: u64, into: &mut [u8]) -> io::Result<usize>;
}

impl HeldBytes for Vec<u8> {
    fn count(&self) -> u64 {
        self.len() as u64
    }

    fn read(&self, first: u64, into: &mut [u8]) -> io::Result<usize> {
        let rest = usize::try_from(first).ok().and_then(|first| self.get(first..));
        rest.unwrap_or_default().read(into)
    }
}

impl HeldBytes for File {
    fn count(&self) -> u64 {
        self.metadata().map_or(0, |found| found.len())
    }

    fn read(&self, first: u64, into: &mut [u8]) -> io::Result<usize> {
        let mut file = self;
        file.seek(SeekFrom::Start(first))?;
        Read::read(&mut file, into)
    }
}

/// A file by its path, whose ending says its format, and its bytes where they are not on a disk.
#[derive(Clone, Debug)]
pub struct LogInput {
    path: PathBuf,
    held: Option<Arc<dyn HeldBytes>>,
}

impl LogInput {
    /// Bytes that are called `name` in messages.
    pub fn held(name: impl Into<PathBuf>, bytes: Arc<dyn HeldBytes>) -> Self {
        Self { path: name.into(), held: Some(bytes) }
    }

    pub(crate) fn is_held(&self) -> bool {
        self.held.is_some()
    }

    pub(crate) fn open(&self) -> io::Result<Opened> {
        let bytes = match &self.held {
            Some(bytes) => bytes.clone(),
            None => Arc::new(File::open(&self.path)?),
        };
        Ok(Opened { bytes, at: 0 })
    }

    #[cfg(feature = "formats")]
    pub(crate) fn open_whole(&self) -> Result<Opened> {
        let input = self.open().map_err(LogError::read(self))?;
        if input.count() == 0 { Err(LogError::Empty { file: self.into() }) } else { Ok(input) }
    }
}

impl<P: AsRef<Path>> From<P> for LogInput {
    fn from(path: P) -> Self {
        Self { path: path.as_ref().into(), held: None }
    }
}

impl From<&LogInput> for PathBuf {
    fn from(file: &LogInput) -> Self {
        file.path.clone()
    }
}

impl Deref for LogInput {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.path
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Opened {
    bytes: Arc<dyn HeldBytes>,
    /// Where the next byte stands.
    at: u64,
}

impl Opened {
    pub(crate) fn count(&self) -> u64 {
        self.bytes.count()
    }
}

impl Read for Opened {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let n_read = self.bytes.read(self.at, into)?;
        self.at += n_read as u64;
        Ok(n_read)
    }
}

impl Seek for Opened {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let place = match to {
            SeekFrom::Start(place) => Some(place),
            SeekFrom::End(offset) => self.count().checked_add_signed(offset),
            SeekFrom::Current(offset) => self.at.checked_add_signed(offset),
        };
        self.at = place.ok_or(ErrorKind::InvalidInput)?;
        Ok(self.at)
    }
}

#[cfg(feature = "formats")]
impl Length for Opened {
    fn len(&self) -> u64 {
        self.bytes.count()
    }
}

#[cfg(feature = "formats")]
impl ChunkReader for Opened {
    type T = io::BufReader<Self>;

    fn get_read(&self, start: u64) -> parquet::errors::Result<Self::T> {
        Ok(io::BufReader::new(Self { at: start, ..self.clone() }))
    }

    fn get_bytes(&self, start: u64, length: usize) -> parquet::errors::Result<bytes::Bytes> {
        let mut chunk = Vec::new();
        self.get_read(start)?.take(length as u64).read_to_end(&mut chunk)?;
        if chunk.len() < length {
            return Err(io::Error::from(ErrorKind::UnexpectedEof).into());
        }
        Ok(chunk.into())
    }
}
