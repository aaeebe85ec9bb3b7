//! Summary → bytes of a file and back: versioned, checksummed, the same for the same logs.

use crate::settings::Settings;
use crate::summary::{Pass, Summary};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use torquewise_regression::row_sums::RowSums;
use torquewise_survey::error::IdentifyError;
use torquewise_survey::noise::NoiseSum;
use torquewise_survey::survey::SurveySum;

/// First bytes of a file.
const MAGIC: &[u8; 8] = b"twmoment";
/// Raised whenever what is summed, or how it is written, changes.
const VERSION: u32 = 3;
/// Magic, version, length and checksum of what follows.
const HEADER_BYTES: usize = 24;

/// A summary as it is written.
#[derive(Serialize, Deserialize)]
struct Saved {
    settings: Settings,
    logs: usize,
    survey: SurveySum,
    still: NoiseSum,
    sums: Vec<SavedSums>,
    pass: Option<Pass>,
}

/// Sums over rows as they are written.
#[derive(Serialize, Deserialize)]
struct SavedSums {
    rows: usize,
    bytes: Vec<u8>,
}

impl Summary {
    /// The summary as the bytes of a file.
    ///
    /// # Errors
    /// [`IdentifyError::Moments`] if it holds friction.
    pub fn to_bytes(&self) -> Result<Vec<u8>, IdentifyError> {
        self.settings.refuse_friction()?;
        let sums = self.sums.iter();
        let saved = Saved {
            settings: self.settings.clone(),
            logs: self.logs,
            survey: self.survey.clone(),
            still: self.still.clone(),
            sums: sums.map(|s| SavedSums { rows: s.rows(), bytes: s.to_bytes() }).collect(),
            pass: self.pass.clone(),
        };
        framed(MAGIC, &saved)
    }

    /// The summary that [`Self::to_bytes`] wrote.
    ///
    /// # Errors
    /// [`IdentifyError::Moments`] if the bytes are not a summary, are of another version, or were
    /// damaged or cut short.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, IdentifyError> {
        let Saved { settings, logs, survey, still, sums, pass } = unframed(MAGIC, bytes)?;
        let n = settings.joints.len();
        let fits = settings.joints == survey.joints()
            && survey.is_sound()
            && still.is_sound(n)
            && sums.len() == settings.parts().len();
        let is_sound = |pass: &Pass| {
            let at = pass.request.linearisation();
            at.is_sound(n) && pass.sums.is_sound(at.n_parameters(), n)
        };
        if !fits || !pass.as_ref().is_none_or(is_sound) {
            return Err(damaged("its parts do not fit each other"));
        }
        let basis = settings.basis()?;
        let read = |saved: &SavedSums| {
            let prepared = &basis.as_ref()?.prepared;
            RowSums::from_bytes(prepared, n, &saved.bytes, saved.rows)
        };
        let sums: Option<Vec<RowSums>> = sums.iter().map(read).collect();
        let sums = sums.ok_or_else(|| damaged("its sums are not those of its library"))?;
        Ok(Self { settings, logs, survey, still, sums, choices: Vec::new(), pass })
    }
}

/// The bytes of a file: what it begins with, version, length, checksum, and what it holds.
pub(crate) fn framed(magic: &[u8; 8], holds: &impl Serialize) -> Result<Vec<u8>, IdentifyError> {
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
    magic: &[u8; 8],
    bytes: &[u8],
) -> Result<T, IdentifyError> {
    let body = checked_body(magic, bytes)?;
    postcard::from_bytes(body).map_err(|error| damaged(&error.to_string()))
}

/// What follows the header, if it is whole.
fn checked_body<'a>(magic: &[u8; 8], bytes: &'a [u8]) -> Result<&'a [u8], IdentifyError> {
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

fn damaged(what: &str) -> IdentifyError {
    IdentifyError::Moments(format!("it is damaged, {what}"))
}
