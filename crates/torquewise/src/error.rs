//! What can go wrong between a log and its model.
#![expect(missing_docs, reason = "each message explains its fields")]

use crate::keywords::names;
use miette::Diagnostic;
use torquewise_logs::LogError;
use torquewise_model::ModelError;
use torquewise_motion::{MotionError, ReadError};
use torquewise_stepwise::IdentifyError;

/// How a front end words an option of a fit or an export by its name, or one with its value.
pub type Wording = fn(&str, Option<&str>) -> String;

/// What to choose in place of an option that is not used, in the words of a front end.
pub type Remedy = fn(Wording) -> String;

/// The neutral wording: the name, and a value after a space.
fn plain(name: &str, value: Option<&str>) -> String {
    value.map_or_else(|| name.to_owned(), |value| format!("{name} {value}"))
}

fn unused(setting: &str, fitted: &str, because: &str) -> String {
    format!("{setting} is not used by {fitted}, which is fitted because {because}")
}

/// What fails by [`Error`].
pub(crate) type Result<T, E = Error> = std::result::Result<T, E>;

/// Why a log cannot be read, fitted or predicted; [`Diagnostic::help`] says what to do.
#[derive(Debug, thiserror::Error, Diagnostic)]
#[non_exhaustive]
pub enum Error {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Log(#[from] LogError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Motion(#[from] MotionError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Identify(IdentifyError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Model(#[from] ModelError),
    #[error(transparent)]
    Read(ReadError),
    #[cfg(feature = "simulation")]
    #[error(transparent)]
    #[diagnostic(transparent)]
    Arm(#[from] torquewise_sim::SimError),
    #[cfg(feature = "figures")]
    #[error(transparent)]
    #[diagnostic(transparent)]
    Report(#[from] torquewise_report::ReportError),
    #[cfg(feature = "figures")]
    #[error(transparent)]
    #[diagnostic(transparent)]
    Export(#[from] torquewise_export::ExportError),
    #[error("{}", unused(setting, fitted, because))]
    #[diagnostic(help("leave it out or choose {}", remedy(plain)))]
    UnusedOption { setting: &'static str, fitted: &'static str, because: String, remedy: Remedy },
    #[error("{setting}: {reason}")]
    WrongValue { setting: &'static str, reason: String },
    #[error("{name} is no option of a fit")]
    #[diagnostic(help("choose among {}", names().join(", ")))]
    NoOption { name: String },
    #[error("SINDy fits a library, not a chain")]
    #[diagnostic(help("choose the product library"))]
    SindyOfChain,
    #[error("a chain is not compared with one-shot SINDy")]
    #[diagnostic(help("choose the energy or the product library"))]
    CompareChain,
    #[error(
        "the laws of friction follow from all logs together, so that parts with friction do not \
         add up"
    )]
    #[diagnostic(help("fit all logs at once, or a chain"))]
    FrictionOfSums,
    #[error("a delay is for filtered signals")]
    #[diagnostic(help("give a cut-off too"))]
    DelayWithoutFilter,
    #[error("the log is of another arm, its joints are {found}, expected {expected}")]
    #[diagnostic(help("give logs of one arm"))]
    OtherArm { found: String, expected: String },
    #[error("the model keeps no covariance of its parameters, so its torque has no interval")]
    #[diagnostic(help("fit the log with library chain"))]
    NoCovariance,
    #[error("the predicted torque overflows at t = {t} s")]
    #[diagnostic(help(
        "check the positions, velocities and accelerations of the log there: they are no motion \
         of an arm"
    ))]
    NotFinite { t: f64 },
    #[cfg(feature = "figures")]
    #[error("{flaw}: a controller or simulation with this model goes wrong there")]
    #[diagnostic(help("{}", not_definite(plain)))]
    NotPositiveDefinite { flaw: String },
    #[cfg(feature = "figures")]
    #[error("there is no C compiler {compiler:?}, and a unit holds a binary")]
    #[diagnostic(help("{}", no_compiler(plain)))]
    NoCompiler { compiler: String, source: std::io::Error },
    #[cfg(feature = "figures")]
    #[error("{compiler:?} did not compile the unit, {complaint}")]
    #[diagnostic(help("try another in the variable CC"))]
    Compiler { compiler: String, complaint: String },
    #[error("interrupted, no file was written")]
    #[diagnostic(help("run it again"))]
    Interrupted,
}

impl From<ReadError> for Error {
    /// What was handed through a reader comes out as it went in.
    fn from(source: ReadError) -> Self {
        let own = source.downcast::<Self>().map(|own| *own);
        own.or_else(|source| source.downcast::<LogError>().map(|own| Self::Log(*own)))
            .or_else(|source| source.downcast::<ModelError>().map(|own| Self::Model(*own)))
            .or_else(|source| source.downcast::<MotionError>().map(|own| Self::Motion(*own)))
            .or_else(|source| source.downcast::<IdentifyError>().map(|own| Self::from(*own)))
            .unwrap_or_else(Self::Read)
    }
}

impl From<IdentifyError> for Error {
    fn from(source: IdentifyError) -> Self {
        match source {
            IdentifyError::Read(inner) => inner.into(),
            IdentifyError::Stopped => Self::Interrupted,
            own => Self::Identify(own),
        }
    }
}

impl Error {
    /// Whether options contradict each other or the log, rather than the log being at fault.
    pub fn is_usage(&self) -> bool {
        matches!(
            self,
            Self::UnusedOption { .. }
                | Self::NoOption { .. }
                | Self::SindyOfChain
                | Self::CompareChain
                | Self::FrictionOfSums
                | Self::DelayWithoutFilter
                | Self::NoCovariance
        )
    }

    /// What went wrong, its options in the words of a front end.
    pub fn message(&self, word: Wording) -> String {
        match self {
            Self::UnusedOption { setting, fitted, because, .. } => {
                unused(&word(setting, None), fitted, because)
            }
            Self::WrongValue { setting, reason } => format!("{}: {reason}", word(setting, None)),
            other => other.to_string(),
        }
    }

    /// What to do about it, if that is known, its options in the words of a front end.
    pub fn advice(&self, word: Wording) -> Option<String> {
        match self {
            Self::UnusedOption { remedy, .. } => {
                Some(format!("leave it out or choose {}", remedy(word)))
            }
            #[cfg(feature = "figures")]
            Self::NotPositiveDefinite { .. } => Some(not_definite(word)),
            #[cfg(feature = "figures")]
            Self::NoCompiler { .. } => Some(no_compiler(word)),
            other => other.help().map(|help| help.to_string()),
        }
    }
}

#[cfg(feature = "figures")]
fn not_definite(word: Wording) -> String {
    let [chain, force] = [word("library", Some("chain")), word("force", None)];
    format!("fit anew on more motion or with {chain}, or give {force} to export it all the same")
}

#[cfg(feature = "figures")]
fn no_compiler(word: Wording) -> String {
    let sources = word("binary", None);
    format!("install one, name it in the variable CC, or export sources alone ({sources})")
}
