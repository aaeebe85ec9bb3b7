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
use torquewise_motion::{Motion, Recording};

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

/// A file of some ending with these bytes; gone once it is dropped.
fn file_of(ending: &str, bytes: &[u8]) -> tempfile::TempPath {
    let file = tempfile::Builder::new().suffix(ending).tempfile().unwrap();
    std::fs::write(&file, bytes).unwrap();
    file.into_temp_path()
}

/// What there is to see of each block of a recording, and of the number of its trajectory.
fn seen<T>(recording: &impl Recording, of: impl Fn(usize, &Motion) -> T) -> Vec<T> {
    let mut seen = Vec::new();
    let read = recording.read(&mut |trajectory, block| {
        seen.push(of(trajectory, block));
        Ok(())
    });
    read.unwrap();
    seen
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

fn with(profile: &str) -> Options {
    Options { profile: Some(Profile::from_toml(profile).unwrap()), ..Options::default() }
}
