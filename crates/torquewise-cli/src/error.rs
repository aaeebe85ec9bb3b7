//! What can be wrong with what the command line is asked.

use std::io;
use std::path::PathBuf;

/// Why a command cannot be carried out, beyond what the library says.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum CliError {
    #[error("{0}")]
    Usage(String),
    #[error("{} cannot be read: check that it exists and may be read", file.display())]
    Read { file: PathBuf, source: io::Error },
    #[error(
        "{} cannot be written: check that its folder may be written and has room",
        file.display()
    )]
    Write { file: PathBuf, source: io::Error },
    #[error(
        "{} cannot be written, there is no folder {}: create it or name another",
        file.display(),
        folder.display()
    )]
    NoFolder { file: PathBuf, folder: PathBuf },
    #[error("{} is a folder: name a file in it", .0.display())]
    OutputIsFolder(PathBuf),
    #[error("{} is read by this command: give -o another name", .0.display())]
    OutputIsInput(PathBuf),
    #[error("the results cannot be written to standard output: check where it is redirected to")]
    Stdout { source: io::Error },
}
