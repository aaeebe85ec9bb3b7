//! The shape and the numbers of a NumPy array (.npy, versions 1 to 3).

use crate::error::{LogError, shown};
use std::path::Path;

/// What the header of an array of numbers says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) shape: Vec<usize>,
    pub(super) is_fortran: bool,
    /// Kind and size of an element without its byte order, such as f8.
    element: String,
    is_big_endian: bool,
    /// Bytes before the first element.
    length: usize,
}

const MAGIC: &[u8] = b"\x93NUMPY";
const ELEMENTS: [&str; 11] = ["f8", "f4", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "b1"];

/// The header at the start of `bytes`; `None` for an array of anything but numbers.
pub(super) fn header(file: &Path, name: &str, bytes: &[u8]) -> Result<Option<Header>, LogError> {
    let header =
        parts(bytes).ok_or_else(|| refused(file, name, "it is not a whole NumPy array"))?;
    Ok(Some(header).filter(|header| ELEMENTS.contains(&header.element.as_str())))
}

/// The same for any kind of element; `None` where it is cut or no header.
fn parts(bytes: &[u8]) -> Option<Header> {
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
    let element = kind.trim_start_matches(['<', '>', '=', '|']).to_owned();
    let is_big_endian = kind.starts_with('>');
    Some(Header { shape, is_fortran, element, is_big_endian, length: start + length })
}

/// The numbers of an array, as stored.
pub(super) fn values(file: &Path, name: &str, bytes: &[u8]) -> Result<Vec<f64>, LogError> {
    let refused = |reason| refused(file, name, reason);
    let header = header(file, name, bytes)?.ok_or_else(|| refused("it holds no numbers"))?;
    let total = header.shape.iter().try_fold(1, |total: usize, n| total.checked_mul(*n));
    let size: usize = header.element[1..].parse().unwrap_or(1);
    let data = bytes.get(header.length..).unwrap_or_default();
    let data = total.and_then(|total| data.get(..total.checked_mul(size)?));
    let data = data.ok_or_else(|| refused("it has fewer numbers than its header says"))?;
    Ok(data.chunks_exact(size).map(|element| number(&header, element)).collect())
}

fn number(header: &Header, stored: &[u8]) -> f64 {
    let mut element = [0; 8];
    for (k, byte) in stored.iter().enumerate() {
        element[if header.is_big_endian { stored.len() - 1 - k } else { k }] = *byte;
    }
    let [a, b, c, d, ..] = element;
    match header.element.as_str() {
        "f8" => f64::from_le_bytes(element),
        "f4" => f64::from(f32::from_le_bytes([a, b, c, d])),
        "i1" => f64::from(a.cast_signed()),
        "i2" => f64::from(i16::from_le_bytes([a, b])),
        "i4" => f64::from(i32::from_le_bytes([a, b, c, d])),
        "i8" => i64::from_le_bytes(element) as f64,
        // Without a sign, the bytes beyond are zero.
        _ => u64::from_le_bytes(element) as f64,
    }
}

fn refused(file: &Path, name: &str, reason: &'static str) -> LogError {
    LogError::Array { file: file.into(), array: shown(name.as_bytes()), reason }
}
