//! From NumPy archive (.npz) to arrays, read as they are inflated.

use crate::arrays::array::{Array, Arrays, LONGEST_NAME, Order};
use crate::arrays::npy::{self, Header};
use crate::arrays::numbers::{Element, Numbers, pass};
use crate::error::LogError;
use crate::format::Format;
use crate::guarded::guarded;
use flate2::CrcReader;
use flate2::read::DeflateDecoder;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use zip::read::ZipFile;
use zip::{CompressionMethod, ZipArchive};

/// Bytes of a header that are looked at.
const MAX_HEADER: u64 = 1 << 16;

/// An archive and what its headers say.
pub(super) struct Npz {
    file: PathBuf,
    arrays: Vec<Array>,
    /// For each array, where its elements are.
    entries: Vec<Entry>,
}

/// Where the bytes of an array stand in an archive.
struct Entry {
    start: u64,
    stored: u64,
    /// Bytes after inflating at most: as the archive says, and deflate makes up to 1 032 of one.
    plain: u64,
    is_deflated: bool,
    checksum: u32,
    header: Header,
    element: Element,
}

impl Npz {
    /// Reads the headers of all arrays.
    pub(super) fn open(file: &Path) -> Result<Self, LogError> {
        let mut archive = archive(file)?;
        let mut npz = Self { file: file.into(), arrays: Vec::new(), entries: Vec::new() };
        for place in 0..archive.len() {
            let found = guarded(file, || {
                let entry = archive.by_index(place).map_err(LogError::decode(file, Format::Npz))?;
                read_entry(file, entry)
            })?;
            let Some((name, entry)) = found else { continue };
            let array = array(&name, &entry.header);
            if array.is_signal() {
                npz.arrays.push(array);
                npz.entries.push(entry);
            }
        }
        Ok(npz)
    }
}

impl Arrays for Npz {
    fn arrays(&self) -> &[Array] {
        &self.arrays
    }

    fn numbers(&self, array: usize, first: u64) -> Result<Numbers, LogError> {
        let (file, entry) = (&self.file, &self.entries[array]);
        let is_held = self.arrays[array].count().is_some_and(|count| entry.holds(count));
        if !is_held {
            let reason = "it has fewer numbers than its header says";
            return Err(npy::refused(file, &self.arrays[array].name, reason));
        }
        let element = entry.element;
        let before = entry.header.length as u64 + first * element.size() as u64;
        let open = || -> io::Result<Numbers> {
            let mut input = File::open(file)?;
            input.seek(SeekFrom::Start(entry.start))?;
            let stored = BufReader::new(input.take(entry.stored));
            let plain: Box<dyn Read + Send> = if entry.is_deflated {
                Box::new(DeflateDecoder::new(stored))
            } else {
                Box::new(stored)
            };
            let mut checked = Checked { input: CrcReader::new(plain), checksum: entry.checksum };
            pass(&mut checked, before)?;
            Ok(Numbers::new(Box::new(checked), element))
        };
        open().map_err(LogError::decode(file, Format::Npz))
    }
}

impl Entry {
    /// Whether this many elements may follow the header.
    fn holds(&self, count: u64) -> bool {
        let elements = count.checked_mul(self.element.size() as u64);
        let bytes = elements.and_then(|bytes| bytes.checked_add(self.header.length as u64));
        bytes.is_some_and(|bytes| bytes <= self.plain)
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

/// Name and place of an array of numbers; `None` for anything else.
fn read_entry<R: Read>(
    file: &Path,
    mut entry: ZipFile<'_, R>,
) -> Result<Option<(String, Entry)>, LogError> {
    let name = entry.name().strip_suffix(".npy").unwrap_or(entry.name()).to_owned();
    let mut head = Vec::new();
    let n_head = (&mut entry).take(MAX_HEADER).read_to_end(&mut head);
    n_head.map_err(LogError::decode(file, Format::Npz))?;
    if name.len() > LONGEST_NAME {
        return Ok(None);
    }
    let Some((header, element)) = npy::header(file, &name, &head)? else { return Ok(None) };
    let is_deflated = match entry.compression() {
        CompressionMethod::Stored => false,
        CompressionMethod::Deflated => true,
        _ => return Err(npy::refused(file, &name, "it is compressed by another method")),
    };
    let stored = entry.compressed_size();
    let plain = entry.size().min(stored.saturating_mul(if is_deflated { 1_032 } else { 1 }));
    let (start, checksum) = (entry.data_start(), entry.crc32());
    let found = Entry { start, stored, plain, is_deflated, checksum, header, element };
    Ok(Some((name, found)))
}

fn archive(file: &Path) -> Result<ZipArchive<BufReader<File>>, LogError> {
    let input = File::open(file).map_err(LogError::read(file))?;
    if input.metadata().map_err(LogError::read(file))?.len() == 0 {
        return Err(LogError::Empty { file: file.into() });
    }
    guarded(file, || {
        ZipArchive::new(BufReader::new(input)).map_err(LogError::decode(file, Format::Npz))
    })
}

/// An array as its header describes it; a vector counts as one column.
fn array(name: &str, header: &Header) -> Array {
    let (rows, columns) = match header.shape.as_slice() {
        [rows] => (*rows, 1),
        [rows, columns] => (*rows, *columns),
        _ => (0, 0),
    };
    let order = if header.is_fortran { Order::ByColumn } else { Order::ByRow };
    Array { name: name.to_owned(), rows, columns, order }
}
