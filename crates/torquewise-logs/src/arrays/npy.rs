//! Bytes of a NumPy array (.npy) → shape and numbers.

use crate::error::{LogError, shown};
use ndarray::{ArrayD, IxDyn};
use ndarray_npy::npy::header::Header as NpyHeader;
use ndarray_npy::{ReadNpyExt, ReadableElement};
use std::path::Path;

/// What the header of an array of numbers says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) shape: Vec<usize>,
    pub(super) is_fortran: bool,
    /// Kind and size of an element without its byte order, such as f8.
    element: String,
}

const MAGIC: &[u8] = b"\x93NUMPY";

/// Opening brackets that the header of an array of numbers has at most.
const MOST_BRACKETS: usize = 4;

/// The header at the start of `bytes`; `None` for an array of anything but numbers.
pub(super) fn header(file: &Path, name: &str, bytes: &[u8]) -> Result<Option<Header>, LogError> {
    let refused = || LogError::Array {
        file: file.into(),
        array: shown(name.as_bytes()),
        reason: "it is not a whole NumPy array",
    };
    let (start, length) = match bytes.get(..12) {
        Some([magic @ .., 1, _, a, b, _, _]) if magic == MAGIC => {
            (10, u32::from(u16::from_le_bytes([*a, *b])))
        }
        Some([magic @ .., 2 | 3, _, a, b, c, d]) if magic == MAGIC => {
            (12, u32::from_le_bytes([*a, *b, *c, *d]))
        }
        _ => return Err(refused()),
    };
    let length = usize::try_from(length).map_err(|_| refused())?;
    let text = bytes.get(start..).and_then(|rest| rest.get(..length)).ok_or_else(refused)?;
    // The parser of Python literals calls itself for each bracket; structures have many.
    if text.iter().filter(|byte| b"([{".contains(byte)).count() > MOST_BRACKETS {
        return Ok(None);
    }
    let header = NpyHeader::from_reader(&mut &bytes[..]).map_err(|_| refused())?;
    let Some(kind) = header.type_descriptor.as_string() else { return Ok(None) };
    let element = kind.trim_start_matches(['<', '>', '=', '|']);
    let known = ["f8", "f4", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "b1"];
    Ok(known.contains(&element).then(|| Header {
        shape: header.shape.clone(),
        is_fortran: header.layout.is_fortran(),
        element: element.to_owned(),
    }))
}

/// The numbers of an array, as stored.
pub(super) fn values(file: &Path, name: &str, bytes: &[u8]) -> Result<Vec<f64>, LogError> {
    let refused =
        |reason| LogError::Array { file: file.into(), array: shown(name.as_bytes()), reason };
    let header = header(file, name, bytes)?.ok_or_else(|| refused("it holds no numbers"))?;
    let size = header.element[1..].parse().unwrap_or(1);
    let total = header.shape.iter().try_fold(size, |total: usize, n| total.checked_mul(*n));
    // The reader allocates what the header claims.
    if total.is_none_or(|total| total > bytes.len()) {
        return Err(refused("it has fewer numbers than its header says"));
    }
    let values = match header.element.as_str() {
        "f8" => elements(bytes, |x: f64| x),
        "f4" => elements(bytes, |x: f32| f64::from(x)),
        "i1" => elements(bytes, |x: i8| f64::from(x)),
        "i2" => elements(bytes, |x: i16| f64::from(x)),
        "i4" => elements(bytes, |x: i32| f64::from(x)),
        "i8" => elements(bytes, |x: i64| x as f64),
        "u1" => elements(bytes, |x: u8| f64::from(x)),
        "u2" => elements(bytes, |x: u16| f64::from(x)),
        "u4" => elements(bytes, |x: u32| f64::from(x)),
        "u8" => elements(bytes, |x: u64| x as f64),
        _ => elements(bytes, |x: bool| f64::from(u8::from(x))),
    };
    values.ok_or_else(|| refused("it is not a whole NumPy array"))
}

/// Elements in the order of the file.
fn elements<T: ReadableElement + Copy>(
    bytes: &[u8],
    number: impl Fn(T) -> f64,
) -> Option<Vec<f64>> {
    let array = ArrayD::<T>::read_npy(bytes).ok()?;
    let n = array.len();
    let is_by_row = array.is_standard_layout();
    // A Fortran array comes as a transposed view: turned back, it lies as in the file.
    let as_stored = if is_by_row { array } else { array.reversed_axes() };
    let flat = as_stored.into_shape_with_order(IxDyn(&[n])).ok()?;
    Some(flat.iter().map(|value| number(*value)).collect())
}
