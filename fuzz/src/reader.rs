//! From bytes to what a reader makes of them.

use clap::ValueEnum;
use std::fs;
use std::path::PathBuf;
use tempfile::TempDir;
use torquewise::dynamics::{Arm, Friction};
use torquewise::exported::{ExportOptions, Target, export};
use torquewise::identify::Summary;
use torquewise::logs::{Logs, Profile};
use torquewise::model::file;

/// What reads files that others wrote.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Reader {
    /// Logs as text.
    Csv,
    /// Logs as Parquet.
    Parquet,
    /// ROS 2 bags in SQLite.
    Db3,
    /// ROS 2 bags in MCAP.
    Mcap,
    /// Arrays of NumPy.
    Npz,
    /// Arrays of MATLAB.
    Mat,
    /// Models.
    Model,
    /// Sums of logs.
    Moments,
    /// Profiles of logs.
    Profile,
    /// Tables of Denavit and Hartenberg.
    Dh,
    /// Friction of a simulated arm.
    Friction,
    /// Robots.
    Urdf,
}

impl Reader {
    /// Its name, which for logs is the ending of their files.
    pub fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }

    fn reads_files(self) -> bool {
        use Reader::{Csv, Db3, Mat, Mcap, Npz, Parquet};
        matches!(self, Csv | Parquet | Db3 | Mcap | Npz | Mat)
    }
}

/// A place where a reader is tried.
#[derive(Debug)]
pub struct Tried {
    reader: Reader,
    file: PathBuf,
    _folder: Option<TempDir>,
}

impl Tried {
    /// In a folder of its own.
    ///
    /// # Panics
    /// Where none can be made.
    #[expect(clippy::expect_used, reason = "without a folder there is nothing to try")]
    pub fn here(reader: Reader) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let file = folder.path().join(format!("case.{}", reader.name()));
        Self { reader, file, _folder: Some(folder) }
    }

    /// With the case in a file that stays when the process ends.
    pub fn at(reader: Reader, file: PathBuf) -> Self {
        Self { reader, file, _folder: None }
    }

    /// Gives bytes to the reader; whether it takes them. It may refuse, but neither panic, abort,
    /// wait nor fill the memory.
    pub fn one(&self, bytes: &[u8]) -> bool {
        if fs::write(&self.file, bytes).is_err() {
            return false;
        }
        if self.reader.reads_files() {
            let logs = Logs::open(std::slice::from_ref(&self.file));
            return logs.and_then(|logs| logs.read_all()).is_ok();
        }
        if self.reader == Reader::Moments {
            return Summary::from_bytes(bytes).is_ok_and(|summary| summary.to_bytes().is_ok());
        }
        let Ok(text) = std::str::from_utf8(bytes) else { return false };
        match self.reader {
            Reader::Model => {
                let Ok(model) = file::from_json(text) else { return false };
                let forced = ExportOptions { force: true, ..ExportOptions::named("arm") };
                // What is taken must be shown, written and compiled as well, or refused.
                let _ = export(&model, Target::C, &forced);
                file::to_json(&model).is_ok()
            }
            Reader::Profile => Profile::from_toml(text).is_ok(),
            Reader::Dh => Arm::from_dh_toml(text).is_ok(),
            Reader::Friction => {
                let joints = ["joint1".to_owned(), "joint2".to_owned()];
                Friction::from_toml(text, &joints).is_ok()
            }
            _ => Arm::from_urdf(text, &[]).is_ok(),
        }
    }
}
