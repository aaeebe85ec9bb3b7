//! Path → format: what a log file is, by its extension.

use crate::error::{LogError, shown};
use std::path::Path;

/// Formats whose readers are still to come.
const PLANNED: [&str; 4] = ["db3", "mcap", "npz", "mat"];

/// A log format that can be read and written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Csv,
    Parquet,
}

impl Format {
    /// The format named by the extension of `file`, in upper or lower case.
    pub(crate) fn of(file: &Path) -> Result<Self, LogError> {
        let extension = file.extension().map(|e| e.to_string_lossy().to_lowercase());
        let extension = extension.unwrap_or_default();
        if let Some(planned) = PLANNED.into_iter().find(|planned| *planned == extension) {
            return Err(LogError::NotYetSupported { file: file.into(), extension: planned });
        }
        match extension.as_str() {
            "csv" => Ok(Self::Csv),
            "parquet" => Ok(Self::Parquet),
            _ => {
                let extension = shown(extension.as_bytes());
                Err(LogError::UnknownExtension { file: file.into(), extension })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Format;
    use crate::error::LogError;
    use std::path::Path;

    #[test]
    fn csv_and_parquet_are_known_in_any_case() {
        assert_eq!(Format::of(Path::new("a/b.csv")).unwrap(), Format::Csv);
        assert_eq!(Format::of(Path::new("B.CSV")).unwrap(), Format::Csv);
        assert_eq!(Format::of(Path::new("x.y.Parquet")).unwrap(), Format::Parquet);
    }

    #[test]
    fn planned_formats_are_told_from_unknown_ones() {
        for planned in ["a.db3", "a.mcap", "a.NPZ", "a.mat"] {
            let refused = Format::of(Path::new(planned));
            assert!(matches!(refused, Err(LogError::NotYetSupported { .. })), "{planned}");
        }
        for unknown in ["a.txt", "a", ".csv", "a.csv.gz"] {
            let refused = Format::of(Path::new(unknown));
            assert!(matches!(refused, Err(LogError::UnknownExtension { .. })), "{unknown}");
        }
    }
}
