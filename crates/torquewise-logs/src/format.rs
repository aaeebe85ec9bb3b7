//! The format of a log file, by its extension.

use crate::{LogError, Result, shown};
use std::path::Path;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Csv,
    Parquet,
    /// Bag of ROS 2 in an SQLite database.
    Db3,
    /// Bag of ROS 2 in an MCAP container.
    Mcap,
    Npz,
    /// Variables of MATLAB, version 5 of the format.
    Mat,
}

impl Format {
    const NAMED: [(&str, Self); 6] = [
        ("csv", Self::Csv),
        ("parquet", Self::Parquet),
        ("db3", Self::Db3),
        ("mcap", Self::Mcap),
        ("npz", Self::Npz),
        ("mat", Self::Mat),
    ];

    fn named(extension: &str) -> Option<Self> {
        let known = Self::NAMED.into_iter().find(|(name, _)| *name == extension);
        known.map(|(_, format)| format)
    }

    /// The format named by the extension of `file`, in upper or lower case.
    pub(crate) fn of(file: &Path) -> Result<Self> {
        let extension = extension(file);
        let Some(format) = Self::named(&extension) else {
            let extension = shown(extension.as_bytes());
            return Err(LogError::UnknownExtension { file: file.into(), extension });
        };
        let (is_built, help) = match format {
            Self::Csv => (true, ""),
            Self::Db3 => (
                cfg!(feature = "sqlite"),
                "convert it to .mcap with `ros2 bag convert`, or read it with a build that has the \
                 feature `sqlite`, such as the command line",
            ),
            _ => (cfg!(feature = "formats"), "build with the feature `formats`"),
        };
        let problem = format!(": this build of torquewise reads no .{extension}");
        let refused = || LogError::unusable(file.display(), &problem, help);
        is_built.then_some(format).ok_or_else(refused)
    }
}

fn extension(file: &Path) -> String {
    file.extension().map(|own| own.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// Whether a file is a log by its name.
pub fn is_log(file: &Path) -> bool {
    Format::named(&extension(file)).is_some()
}

/// Whether a file is a bag of ROS 2 by its name.
pub fn is_bag(file: &Path) -> bool {
    matches!(Format::named(&extension(file)), Some(Format::Db3 | Format::Mcap))
}

#[cfg(test)]
mod tests {
    use super::Format;
    use crate::error::LogError;
    use std::path::Path;

    #[test]
    fn formats_are_known_in_any_case_and_others_refused() {
        for (file, format) in [
            ("a/b.csv", Format::Csv),
            ("x.y.Parquet", Format::Parquet),
            ("a.db3", Format::Db3),
            ("a.MCAP", Format::Mcap),
            ("a.npz", Format::Npz),
            ("a.mat", Format::Mat),
        ] {
            assert_eq!(Format::of(Path::new(file)).unwrap(), format, "{file}");
        }
        for unknown in ["a.txt", "a", ".csv", "a.csv.gz"] {
            let refused = Format::of(Path::new(unknown));
            assert!(matches!(refused, Err(LogError::UnknownExtension { .. })), "{unknown}");
        }
    }
}
