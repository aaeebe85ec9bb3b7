//! Bytes of a file that holds sums: what it begins with, a version, a checksum, and what it holds.

use serde::Serialize;
use serde::de::DeserializeOwned;
use torquewise_stepwise::IdentifyError;

/// Version of what is summed and how it is written.
const VERSION: u32 = 1;
/// Magic, version and checksum of what follows.
const HEADER_BYTES: usize = 16;

pub(crate) fn framed(magic: [u8; 8], holds: &impl Serialize) -> Result<Vec<u8>, IdentifyError> {
    let body = postcard::to_stdvec(holds).map_err(|error| damaged(&error.to_string()))?;
    let checksum = crc32fast::hash(&body).to_le_bytes();
    Ok([&magic[..], &VERSION.to_le_bytes(), &checksum, &body].concat())
}

/// What [`framed`] was given.
pub(crate) fn unframed<T: DeserializeOwned>(
    magic: [u8; 8],
    bytes: &[u8],
) -> Result<T, IdentifyError> {
    let begin = bytes.get(..magic.len()).unwrap_or(bytes);
    if !magic.starts_with(begin) || begin.is_empty() {
        return Err(IdentifyError::Moments("it does not begin as one does".into()));
    }
    let Some((header, body)) = bytes.split_first_chunk::<HEADER_BYTES>() else {
        return Err(damaged("it ends within its header"));
    };
    let number = |from: usize| u32::from_le_bytes(std::array::from_fn(|k| header[from + k]));
    let version = number(8);
    if version != VERSION {
        let message = format!("it is of version {version}, this program reads {VERSION}");
        return Err(IdentifyError::Moments(message));
    }
    if number(12) != crc32fast::hash(body) {
        return Err(damaged("its checksum is wrong"));
    }
    postcard::from_bytes(body).map_err(|error| damaged(&error.to_string()))
}

pub(crate) fn damaged(what: &str) -> IdentifyError {
    IdentifyError::Moments(format!("it is damaged, {what}"))
}
