//! From what a file holds to its bytes and back: versioned, checksummed.

use serde::Serialize;
use serde::de::DeserializeOwned;
use torquewise_stepwise::error::IdentifyError;

/// Raised whenever what is summed, or how it is written, changes.
const VERSION: u32 = 8;
/// Magic, version, length and checksum of what follows.
const HEADER_BYTES: usize = 24;

/// The bytes of a file: what it begins with, version, length, checksum, and what it holds.
pub(crate) fn framed(magic: [u8; 8], holds: &impl Serialize) -> Result<Vec<u8>, IdentifyError> {
    let body = postcard::to_stdvec(holds).map_err(|error| damaged(&error.to_string()))?;
    let mut bytes = Vec::with_capacity(HEADER_BYTES + body.len());
    bytes.extend(magic);
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend((body.len() as u64).to_le_bytes());
    bytes.extend(crc32fast::hash(&body).to_le_bytes());
    bytes.extend(body);
    Ok(bytes)
}

/// What [`framed`] was given.
pub(crate) fn unframed<T: DeserializeOwned>(
    magic: [u8; 8],
    bytes: &[u8],
) -> Result<T, IdentifyError> {
    let body = checked_body(magic, bytes)?;
    postcard::from_bytes(body).map_err(|error| damaged(&error.to_string()))
}

/// What follows the header, if it is whole.
fn checked_body(magic: [u8; 8], bytes: &[u8]) -> Result<&[u8], IdentifyError> {
    let begin = bytes.get(..magic.len()).unwrap_or(bytes);
    if !magic.starts_with(begin) || begin.is_empty() {
        return Err(IdentifyError::Moments("it does not begin as one does".into()));
    }
    let Some((header, body)) = bytes.split_at_checked(HEADER_BYTES) else {
        return Err(damaged("it ends within its header"));
    };
    let number = |from: usize, to: usize| {
        let digits = header.get(from..to).unwrap_or_default();
        digits.iter().rev().fold(0_u64, |number, &byte| (number << 8) | u64::from(byte))
    };
    let [version, length, checksum] = [number(8, 12), number(12, 20), number(20, 24)];
    if version != u64::from(VERSION) {
        let message = format!("it is of version {version}, this program reads {VERSION}");
        return Err(IdentifyError::Moments(message));
    }
    if length != body.len() as u64 {
        let found = body.len();
        return Err(damaged(&format!("{length} bytes should follow its header, {found} do")));
    }
    if checksum != u64::from(crc32fast::hash(body)) {
        return Err(damaged("its checksum is wrong"));
    }
    Ok(body)
}

pub(crate) fn damaged(what: &str) -> IdentifyError {
    IdentifyError::Moments(format!("it is damaged, {what}"))
}
