//! The arrays of a NumPy archive (.npz of .npy, versions 1 to 3), read as they are inflated.

use crate::arrays::array::{Array, LONGEST_NAME, Packing};
use crate::arrays::numbers::{Element, Kind};
use crate::{Format, LogError, LogInput, Result, guarded, shown};
use std::io::{BufReader, Read};
use std::path::Path;
use zip::read::ZipFile;
use zip::{CompressionMethod, ZipArchive};

/// Bytes of a header that are looked at.
const MAX_HEADER: u64 = 1 << 16;

/// Bytes that deflate makes of one at most.
const MOST_INFLATED: u64 = 1_032;

const MAGIC: &[u8] = b"\x93NUMPY";
/// Kinds of numbers with the bytes that each may have; a truth is a number of one byte.
const KINDS: [(&str, Kind, &str); 4] = [
    ("f", Kind::Float, "48"),
    ("i", Kind::Signed, "1248"),
    ("u", Kind::Unsigned, "1248"),
    ("b", Kind::Unsigned, "1"),
];

pub(super) fn arrays(file: &LogInput) -> Result<Vec<Array>> {
    let input = BufReader::new(file.open_whole()?);
    guarded(file, || {
        let damaged = LogError::decode(file, Format::Npz);
        let mut archive = ZipArchive::new(input).map_err(&damaged)?;
        let mut arrays = Vec::new();
        for place in 0..archive.len() {
            let entry = archive.by_index(place).map_err(&damaged)?;
            arrays.extend(array(file, entry)?.filter(Array::is_signal));
        }
        Ok(arrays)
    })
}

/// An array of numbers; `None` for anything else.
fn array<R: Read>(file: &Path, mut entry: ZipFile<'_, R>) -> Result<Option<Array>> {
    let name = entry.name().strip_suffix(".npy").unwrap_or(entry.name()).to_owned();
    let refused = |reason| {
        let array = shown(name.as_bytes());
        Err(LogError::Array { file: file.into(), array, reason })
    };
    let mut head = Vec::new();
    let n_head = (&mut entry).take(MAX_HEADER).read_to_end(&mut head);
    n_head.map_err(LogError::decode(file, Format::Npz))?;
    if name.len() > LONGEST_NAME {
        return Ok(None);
    }
    let Some(header) = header(&head) else {
        return refused("it is not a whole NumPy array");
    };
    let Some(element) = header.element else { return Ok(None) };
    let (packing, growth) = match entry.compression() {
        CompressionMethod::Stored => (Packing::Plain, 1),
        CompressionMethod::Deflated => (Packing::Deflate, MOST_INFLATED),
        _ => return refused("it is compressed by another method"),
    };
    let (rows, columns) = match header.shape.as_slice() {
        [rows] => (*rows, 1),
        [rows, columns] => (*rows, *columns),
        _ => (0, 0),
    };
    let mut array = Array {
        name,
        rows,
        columns,
        is_by_column: header.is_fortran,
        start: entry.data_start(),
        stored: entry.compressed_size(),
        packing,
        before: header.length as u64,
        checksum: Some(entry.crc32()),
        element: Ok(element),
    };
    let plain = entry.size().min(array.stored.saturating_mul(growth));
    let n_bytes = array.n_bytes(element).and_then(|bytes| bytes.checked_add(array.before));
    if n_bytes.is_none_or(|bytes| bytes > plain) {
        array.element = Err("it has fewer numbers than its header says");
    }
    Ok(Some(array))
}

struct Header {
    shape: Vec<usize>,
    is_fortran: bool,
    length: usize,
    /// What the elements are, if they are numbers.
    element: Option<Element>,
}

/// The header at the start of `bytes`; `None` where it is cut or no header.
fn header(bytes: &[u8]) -> Option<Header> {
    let (start, length) = match bytes.get(..12)? {
        [magic @ .., 1, _, a, b, _, _] if magic == MAGIC => {
            (10, u32::from(u16::from_le_bytes([*a, *b])))
        }
        [magic @ .., 2 | 3, _, a, b, c, d] if magic == MAGIC => {
            (12, u32::from_le_bytes([*a, *b, *c, *d]))
        }
        _ => return None,
    };
    let length = usize::try_from(length).ok()?;
    let text = std::str::from_utf8(bytes.get(start..)?.get(..length)?).ok()?;
    let field = |key: &str| {
        let (_, after) = text.split_once(key)?;
        Some(after.trim_start().strip_prefix(':')?.trim_start())
    };
    let is_fortran = match field("'fortran_order'")? {
        value if value.starts_with("True") => true,
        value if value.starts_with("False") => false,
        _ => return None,
    };
    let (shape, _) = field("'shape'")?.strip_prefix('(')?.split_once(')')?;
    let lengths = shape.split(',').map(str::trim).filter(|length| !length.is_empty());
    let shape = lengths.map(|length| length.parse().ok()).collect::<Option<Vec<usize>>>()?;
    // A structure is a list of names and kinds in place of one kind.
    let kind = field("'descr'")?.strip_prefix('\'').unwrap_or("list'");
    let (kind, _) = kind.split_once('\'')?;
    let is_big_endian = kind.starts_with('>');
    let own = kind.trim_start_matches(['<', '>', '=', '|']).split_at_checked(1);
    let element = own.and_then(|(letter, size)| {
        let known = KINDS.into_iter().find(|(own, ..)| *own == letter);
        let (_, kind, _) = known.filter(|(.., sizes)| size.len() == 1 && sizes.contains(size))?;
        Some(Element { kind, size: size.parse().ok()?, is_big_endian })
    });
    Some(Header { shape, is_fortran, length: start + length, element })
}
