//! From a line typed in an empty folder to what was said and which files appeared.

use assert_cmd::Command;
use serde_json::Value;
use std::fs;
use std::path::PathBuf;
use std::sync::OnceLock;
use tempfile::TempDir;

/// An empty folder to type lines in.
pub(crate) struct Terminal {
    folder: TempDir,
}

#[derive(Debug)]
pub(crate) struct Said {
    pub(crate) code: i32,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Terminal {
    pub(crate) fn new() -> Self {
        Self { folder: TempDir::new().unwrap() }
    }

    /// With a file of this text.
    pub(crate) fn holding(name: &str, text: &str) -> Self {
        let terminal = Self::new();
        terminal.write(name, text);
        terminal
    }

    /// With `log.csv`, two joints that go through all patterns.
    pub(crate) fn with_log() -> Self {
        static LOG: OnceLock<String> = OnceLock::new();
        let line = "simulate planar-2 -o log.csv --seconds 60 --rate 50 --seed 3";
        Self::new().with(&LOG, "log.csv", line)
    }

    /// With `log.csv` and `model.json`, fitted on it.
    pub(crate) fn with_model() -> Self {
        static MODEL: OnceLock<String> = OnceLock::new();
        Self::with_log().with(&MODEL, "model.json", "fit log.csv -o model.json")
    }

    /// With a file that a line makes, once for all tests.
    fn with(self, made: &OnceLock<String>, name: &str, line: &str) -> Self {
        let made = made.get_or_init(|| {
            self.done(line);
            self.read(name)
        });
        self.write(name, made);
        self
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    pub(crate) fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    /// Names of all files, sorted, the hidden ones among them.
    pub(crate) fn files(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// The words after `torquewise`, separated by spaces.
    pub(crate) fn run(&self, line: &str) -> Said {
        let mut command = Command::new(env!("CARGO_BIN_EXE_torquewise"));
        let output =
            command.args(line.split_whitespace()).current_dir(&self.folder).output().unwrap();
        let said = Said {
            code: output.status.code().unwrap(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        };
        assert!(!said.stderr.contains("panicked"), "{line}: {said:?}");
        assert!(!said.stderr.contains('\x1b'), "no colours outside a terminal: {said:?}");
        said
    }

    /// Runs a line that must succeed without warning; returns what stands on stdout.
    pub(crate) fn done(&self, line: &str) -> String {
        let said = self.run(line);
        assert_eq!((said.code, said.stderr.as_str()), (0, ""), "{line}: {said:?}");
        said.stdout
    }

    /// Runs a line with `--json`; one object must be all there is on stdout.
    pub(crate) fn json(&self, line: &str) -> Value {
        let said = self.run(&format!("{line} --json"));
        assert!(matches!(said.code, 0 | 3), "{line}: {said:?}");
        let value: Value = serde_json::from_str(&said.stdout).unwrap();
        assert!(value.is_object(), "{line}: {said:?}");
        value
    }

    /// Runs a line that must fail, say all of `words`, and leave no file behind.
    pub(crate) fn refused(&self, line: &str, words: &[&str]) {
        self.fails(1, line, words);
    }

    /// The same of wrong usage.
    pub(crate) fn misused(&self, line: &str, words: &[&str]) {
        self.fails(2, line, words);
    }

    /// The same with this code to exit with.
    pub(crate) fn fails(&self, code: i32, line: &str, words: &[&str]) {
        let before = self.files();
        let said = self.run(line);
        assert_eq!((said.code, said.stdout.as_str()), (code, ""), "{line}: {said:?}");
        assert!(said.stderr.starts_with("error: "), "{line}: {said:?}");
        for word in words {
            assert!(said.stderr.contains(word), "{line} should say {word:?}: {said:?}");
        }
        assert_eq!(self.files(), before, "{line} left something behind");
    }
}

/// Whether a text has all of `words`.
#[track_caller]
pub(crate) fn assert_says(text: &str, words: &[&str]) {
    for word in words {
        assert!(text.contains(word), "{word:?}: {text}");
    }
}

pub(crate) fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

pub(crate) fn texts(values: &Value, key: &str) -> Vec<String> {
    let objects = values.as_array().unwrap().iter();
    objects.map(|object| object[key].as_str().unwrap().to_owned()).collect()
}

pub(crate) fn each(values: &Value, key: &str) -> Vec<f64> {
    values.as_array().unwrap().iter().map(|object| object[key].as_f64().unwrap()).collect()
}
