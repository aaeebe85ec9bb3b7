//! The shape of, and the kind of numbers in, a NumPy array (.npy, versions 1 to 3).

use crate::arrays::numbers::{Element, Kind};
use crate::error::{LogError, shown};
use std::path::Path;

/// What the header of an array of numbers says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) shape: Vec<usize>,
    pub(super) is_fortran: bool,
    /// Bytes before the first element.
    pub(super) length: usize,
}

const MAGIC: &[u8] = b"\x93NUMPY";
const KINDS: [(&str, Kind); 11] = [
    ("f8", Kind::F8),
    ("f4", Kind::F4),
    ("i1", Kind::I1),
    ("i2", Kind::I2),
    ("i4", Kind::I4),
    ("i8", Kind::I8),
    ("u1", Kind::U1),
    ("u2", Kind::U2),
    ("u4", Kind::U4),
    ("u8", Kind::U8),
    ("b1", Kind::U1),
];

/// The header at the start of `bytes` and what the elements are; `None` for an array of anything but
/// numbers.
pub(super) fn header(
    file: &Path,
    name: &str,
    bytes: &[u8],
) -> Result<Option<(Header, Element)>, LogError> {
    let parts = parts(bytes);
    let (header, element) =
        parts.ok_or_else(|| refused(file, name, "it is not a whole NumPy array"))?;
    Ok(element.map(|element| (header, element)))
}

/// The same; `None` where it is cut or no header, no element where it holds no numbers.
fn parts(bytes: &[u8]) -> Option<(Header, Option<Element>)> {
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
    let own = kind.trim_start_matches(['<', '>', '=', '|']);
    let known = KINDS.into_iter().find(|(name, _)| *name == own);
    let is_big_endian = kind.starts_with('>');
    let element = known.map(|(_, kind)| Element { kind, is_big_endian });
    Some((Header { shape, is_fortran, length: start + length }, element))
}

/// Why an array is not read.
pub(super) fn refused(file: &Path, name: &str, reason: &'static str) -> LogError {
    LogError::Array { file: file.into(), array: shown(name.as_bytes()), reason }
}
