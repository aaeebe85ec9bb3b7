//! From bytes to what a reader makes of them.

use std::fs;
use std::path::Path;
use torquewise::dynamics::{Arm, Friction};
use torquewise::exported::{ExportOptions, Target, export};
use torquewise::identify::Summary;
use torquewise::logs::{Logs, Profile};
use torquewise::model::file;

/// What reads files that others wrote; for logs the ending of their files.
pub const READERS: [&str; 12] = [
    "csv", "parquet", "db3", "mcap", "npz", "mat", "model", "moments", "profile", "dh", "friction",
    "urdf",
];

/// Gives an input to the reader that its first byte picks.
///
/// # Panics
/// Where no folder can be made for it.
#[expect(clippy::expect_used, reason = "without a folder there is nothing to try")]
pub fn picked(input: &[u8]) -> bool {
    let Some((first, bytes)) = input.split_first() else { return false };
    let folder = tempfile::tempdir().expect("a temporary folder");
    takes(READERS[usize::from(*first) % READERS.len()], bytes, folder.path())
}

/// Whether a reader takes bytes. It may refuse, but neither panic, abort, wait nor fill the memory.
///
/// - `folder`: where the file of a log is made
pub fn takes(reader: &str, bytes: &[u8], folder: &Path) -> bool {
    match reader {
        "csv" | "parquet" | "db3" | "mcap" | "npz" | "mat" => {
            let file = folder.join(format!("case.{reader}"));
            fs::write(&file, bytes).is_ok()
                && Logs::open(&[file]).and_then(|logs| logs.read_all()).is_ok()
        }
        "moments" => Summary::from_bytes(bytes).is_ok_and(|summary| summary.to_bytes().is_ok()),
        _ => std::str::from_utf8(bytes).is_ok_and(|text| takes_text(reader, text)),
    }
}

fn takes_text(reader: &str, text: &str) -> bool {
    match reader {
        "model" => {
            let Ok(model) = file::from_json(text) else { return false };
            let forced = ExportOptions { force: true, ..ExportOptions::named("arm") };
            // What is taken must be shown, written and compiled as well, or refused.
            let _ = export(&model, Target::C, &forced);
            file::to_json(&model).is_ok()
        }
        "profile" => Profile::from_toml(text).is_ok(),
        "dh" => Arm::from_dh_toml(text).is_ok(),
        "friction" => {
            let joints = ["joint1".to_owned(), "joint2".to_owned()];
            Friction::from_toml(text, &joints).is_ok()
        }
        _ => Arm::from_urdf(text, &[]).is_ok(),
    }
}
