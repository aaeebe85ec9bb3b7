//! Errors of the command line, and those of the library in its words: options are flags.

use miette::Diagnostic;
use std::error::Error;
use std::io;
use std::path::{Path, PathBuf};

pub(crate) type Result<T, E = CliError> = std::result::Result<T, E>;

#[derive(Debug, thiserror::Error, Diagnostic)]
#[non_exhaustive]
pub(crate) enum CliError {
    #[error("{}", .0.message(flag))]
    Library(torquewise::Error),
    #[error("{what}")]
    In { what: String, source: Box<Self> },
    #[error("{0}")]
    Usage(String),
    #[error("{} cannot be read", file.display())]
    #[diagnostic(help("check that it exists and may be read"))]
    Read { file: PathBuf, source: io::Error },
    #[error("{} cannot be written", file.display())]
    #[diagnostic(help("check that its folder may be written and has room"))]
    Write { file: PathBuf, source: io::Error },
    #[error("{} {what}", file.display())]
    #[diagnostic(help("{help}"))]
    Refused { file: PathBuf, what: String, help: &'static str },
    #[error("unsupported extension for this output: {}, expected {expected}", file.display())]
    Ending { file: PathBuf, expected: String },
    #[error("the model is of joints {model}, the arm has {arm}")]
    #[diagnostic(help(
        "give the arm the model was learned on, or --lock the joints that the log did not move"
    ))]
    ModelOfAnotherArm { model: String, arm: String },
    #[error("the experiments cannot be done")]
    #[diagnostic(forward(source))]
    Experiment { source: torquewise_paper::PaperError },
    #[error("this program was built without the page")]
    #[diagnostic(help(
        "that of the Python package has it (pip install torquewise), and `cargo xtask web` builds one"
    ))]
    NoPage,
    #[error("no page can be served at {address}")]
    #[diagnostic(help("choose another --port"))]
    Port { address: String, source: Box<dyn Error + Send + Sync> },
    #[error("the results cannot be written to standard output")]
    #[diagnostic(help("check where it is redirected to"))]
    Stdout { source: io::Error },
}

impl<E: Into<torquewise::Error>> From<E> for CliError {
    fn from(error: E) -> Self {
        Self::Library(error.into())
    }
}

impl CliError {
    pub(crate) fn within(self, what: impl Into<String>) -> Self {
        Self::In { what: what.into(), source: Box::new(self) }
    }

    /// A file or folder that cannot be what it is given as, and what to do.
    pub(crate) fn refused(file: &Path, what: impl Into<String>, help: &'static str) -> Self {
        Self::Refused { file: file.into(), what: what.into(), help }
    }

    /// Whether the line that was typed is wrong, rather than what it reads.
    pub(crate) fn is_usage(&self) -> bool {
        match self {
            Self::Usage(_) => true,
            Self::Library(error) => error.is_usage(),
            Self::In { source, .. } => source.is_usage(),
            _ => false,
        }
    }

    pub(crate) fn advice(&self) -> Option<String> {
        match self {
            Self::Library(error) => error.advice(flag),
            Self::In { source, .. } => source.advice(),
            other => other.help().map(|help| help.to_string()),
        }
    }

    /// What went wrong and what caused it, a line each.
    pub(crate) fn causes(&self) -> Vec<String> {
        let mut messages = vec![self.to_string()];
        let mut cause = match self {
            Self::Library(error) => error.source(),
            Self::In { source, .. } => {
                messages.extend(source.causes());
                None
            }
            other => other.source(),
        };
        while let Some(own) = cause {
            messages.push(own.to_string());
            cause = own.source();
        }
        // A transparent error says what its source says.
        messages.dedup();
        messages
    }
}

fn flag(name: &str, value: Option<&str>) -> String {
    let name = match name {
        "n_bootstrap" => "bootstrap".to_owned(),
        "noise_correction" => "no-noise-correction".to_owned(),
        "binary" => "no-binary".to_owned(),
        other => other.replace('_', "-"),
    };
    value.map_or_else(|| format!("--{name}"), |value| format!("--{name} {value}"))
}
