//! Errors of the command line.

use anyhow::anyhow;
use std::io;
use std::path::PathBuf;
use torquewise::Error;
use torquewise::identify::IdentifyError;

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
    #[error("{} is a file: name a folder", .0.display())]
    NotAFolder(PathBuf),
    #[error("{} is read by this command: give the output another name", .0.display())]
    OutputIsInput(PathBuf),
    #[error("{} would be written twice: give each output a name of its own", .0.display())]
    SameOutput(PathBuf),
    #[error("{} would not hold what its name says: expected {expected}", file.display())]
    Ending { file: PathBuf, expected: String },
    #[error(
        "the torque at t = {t} s is beyond all numbers: the positions, velocities and accelerations \
         there are no motion of an arm, check the log"
    )]
    NotFinite { t: f64 },
    #[error("{} exists and is not empty: name a new folder", .0.display())]
    NotEmpty(PathBuf),
    #[error(
        "the model is of joints {model}, the arm has {arm}: give the arm the model was learned \
         on, or --lock the joints that the log did not move"
    )]
    ModelOfAnotherArm { model: String, arm: String },
    #[error("{} does not add to the parts before it", file.display())]
    Part { file: PathBuf, source: IdentifyError },
    #[error("the results cannot be written to standard output: check where it is redirected to")]
    Stdout { source: io::Error },
}

/// An error of the library in the words of the command line: options are flags.
pub(crate) fn in_flags(error: anyhow::Error) -> anyhow::Error {
    match error.downcast_ref() {
        Some(Error::UnusedOption { option, fitted, because, user }) => {
            let user = user.replace("the library ", "--library ");
            let user = user.replace("the method ", "--method ");
            let user = user.replace("an interaction order", "--interaction K");
            CliError::Usage(format!(
                "--{option} is not used by {fitted}, which is fitted because {because}: leave it \
                 out or choose {user}"
            ))
            .into()
        }
        Some(Error::NotPositiveDefinite { .. } | Error::NoCompiler { .. }) => {
            let text = error.to_string();
            let text = text.replace("or force it", "or give --force");
            let text = text.replace("the library chain", "--library chain");
            anyhow!(text.replace("ask for no binary", "give --no-binary"))
        }
        _ => error,
    }
}
