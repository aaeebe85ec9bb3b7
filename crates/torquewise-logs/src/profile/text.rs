//! Profiles as TOML.

use crate::{LogError, Profile, Result};
use std::io::ErrorKind;
use std::path::Path;
use torquewise_motion::bounded_file::read_text;

/// Profiles of public data sets, by name.
const BUILT_IN: [(&str, &str); 8] = [
    ("delan_character", include_str!("../../profiles/delan_character.toml")),
    ("dfki_double_pendulum", include_str!("../../profiles/dfki_double_pendulum.toml")),
    ("dfki_simple_pendulum", include_str!("../../profiles/dfki_simple_pendulum.toml")),
    ("kuka_kr300", include_str!("../../profiles/kuka_kr300.toml")),
    ("panda", include_str!("../../profiles/panda.toml")),
    ("staubli_tx40", include_str!("../../profiles/staubli_tx40.toml")),
    ("tiago_arm", include_str!("../../profiles/tiago_arm.toml")),
    ("ur10", include_str!("../../profiles/ur10.toml")),
];

impl Profile {
    /// Reads a profile from a `.toml` file, or one that is built in by its name, such as `ur10`.
    ///
    /// # Errors
    /// [`LogError::Read`], or as [`from_toml`](Self::from_toml) with the name of the file.
    pub fn read(file: &Path) -> Result<Self> {
        let built_in = BUILT_IN.iter().find(|(name, _)| file == *name);
        if let Some((name, text)) = built_in.filter(|_| !file.exists()) {
            return Self::parse(text, name);
        }
        let text = read_text(file).map_err(|source| {
            let is_word = file.components().count() == 1 && file.extension().is_none();
            if source.kind() != ErrorKind::NotFound || !is_word {
                return LogError::read(file)(source);
            }
            let names = BUILT_IN.map(|(name, _)| name).join(", ");
            let problem = format!(": no such file, and the built-in profiles are {names}");
            LogError::unusable(file.display(), &problem, "name one of these, or a file")
        })?;
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
            let line = source.span().map_or(1, |span| 1 + text[..span.start].matches('\n').count());
            let problem = format!(", line {line}: {}", source.message());
            LogError::unusable(from, &problem, "profiles/README.md lists the keys of a profile")
        })?;
        profile.check(from)?;
        Ok(profile)
    }
}
