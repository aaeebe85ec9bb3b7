//! From TOML text to profile and back.

use crate::error::{LogError, Result};
use crate::profile::Profile;
use std::path::Path;
use torquewise_motion::bounded_file::read_text;

impl Profile {
    /// Reads a profile from a `.toml` file.
    ///
    /// # Errors
    /// [`LogError::Read`], or as [`from_toml`](Self::from_toml) with the name of the file.
    pub fn read(file: &Path) -> Result<Self> {
        let text = read_text(file).map_err(LogError::read(file))?;
        Self::parse(&text, &file.display().to_string())
    }

    /// Reads a profile from text.
    ///
    /// # Errors
    /// [`LogError::Unusable`] with the line of what is not understood, [`LogError::ProfileKey`]
    /// if a value cannot be right or values contradict each other.
    pub fn from_toml(text: &str) -> Result<Self> {
        Self::parse(text, "profile")
    }

    /// Text that [`from_toml`](Self::from_toml) reads back.
    pub fn to_toml(&self) -> String {
        // A profile is made of what TOML has: text, numbers, lists and tables.
        toml::to_string(self).unwrap_or_default()
    }

    fn parse(text: &str, from: &str) -> Result<Self> {
        let profile: Self = toml::from_str(text).map_err(|source| {
            let line = source.span().map_or(1, |span| line_of(text, span.start));
            let problem = format!(", line {line}: {}", source.message());
            LogError::unusable(from, &problem, "profiles/README.md lists the keys of a profile")
        })?;
        profile.check(from)?;
        Ok(profile)
    }
}

fn line_of(text: &str, at: usize) -> usize {
    1 + text.bytes().take(at).filter(|byte| *byte == b'\n').count()
}
