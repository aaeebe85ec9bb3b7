//! Files of every format → recordings, and bad ones → errors that say where.
#![expect(clippy::unwrap_used, reason = "a test stops where its ground gives way")]

mod arrays;
mod bags;
mod hostile_parquet;
mod made_bags;
mod made_mats;
mod profiles;
mod real_robots;
mod recording;
mod round_trip;
mod shared;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use torquewise_logs::{LogError, LogInput, Logs, Options, Profile};
use torquewise_motion::Motion;

/// A folder with text files.
struct Files(tempfile::TempDir);

impl Files {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn add(&self, name: &str, text: &str) -> PathBuf {
        let file = self.0.path().join(name);
        std::fs::write(&file, text).unwrap();
        file
    }
}

/// All rows of a file, which are the same, or refused with the same words, from its bytes in memory;
/// a bag in SQLite is read from a disk alone.
fn read_both(file: &Path, options: &Options) -> Result<Vec<Motion>, LogError> {
    let from_disk = Logs::open_with(&[file.to_owned()], options).and_then(|logs| logs.read_all());
    if file.extension().is_none_or(|ending| ending != "db3") {
        let held = LogInput::held(file, Arc::new(std::fs::read(file).unwrap()));
        let held = Logs::of_inputs(&[held], options).and_then(|logs| logs.read_all());
        assert_eq!(format!("{held:?}"), format!("{from_disk:?}"));
    }
    from_disk
}

/// To read logs by a profile.
fn with(profile: &str) -> Options {
    Options { profile: Some(Profile::from_toml(profile).unwrap()), ..Options::default() }
}
