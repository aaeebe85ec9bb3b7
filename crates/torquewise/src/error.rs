//! What can go wrong between a log and its model.
#![expect(missing_docs, reason = "each message explains its fields")]

use torquewise_logs::LogError;
use torquewise_model::ModelError;
use torquewise_motion::ReadError;
use torquewise_stepwise::IdentifyError;

/// Why a log cannot be read, fitted or predicted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    #[error(transparent)]
    Log(#[from] LogError),
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    #[error(transparent)]
    Model(#[from] ModelError),
    #[error(transparent)]
    Read(#[from] ReadError),
    #[cfg(feature = "simulation")]
    #[error("the arm could not be built")]
    Arm(#[from] torquewise_sim::SimError),
    #[cfg(feature = "figures")]
    #[error(transparent)]
    Report(#[from] torquewise_report::ReportError),
    #[cfg(feature = "figures")]
    #[error(transparent)]
    Export(#[from] torquewise_export::ExportError),
    #[error(
        "{option} is not used by {fitted}, which is fitted because {because}: leave it out or \
         choose {user}"
    )]
    UnusedOption { option: &'static str, fitted: &'static str, because: String, user: &'static str },
    #[error("SINDy fits a library, not a chain: choose the product library")]
    SindyOfChain,
    #[error(
        "a chain is not compared with one-shot SINDy: choose the energy or the product library"
    )]
    CompareChain,
    #[error(
        "the laws of friction follow from all logs together, so that parts with friction do not \
         add up: fit all logs at once, or a chain"
    )]
    FrictionOfSums,
    #[error("a delay is for filtered signals: give a cut-off too")]
    DelayWithoutFilter,
    #[error(
        "the log is of another arm, its joints are {found}, expected {expected}: give logs of one \
         arm"
    )]
    OtherArm { found: String, expected: String },
    #[error(
        "the model keeps no covariance of its parameters, so its torque has no interval: fit a \
         chain"
    )]
    NoCovariance,
    #[cfg(feature = "figures")]
    #[error(
        "{flaw}: a controller or simulation with this model goes wrong there; fit anew on more \
         motion or with the library chain, or force it to export it all the same"
    )]
    NotPositiveDefinite { flaw: String },
    #[cfg(feature = "figures")]
    #[error(
        "there is no C compiler {compiler:?}, and a unit holds a binary: install one, name it in \
         the variable CC, or ask for no binary and compile the sources where it is used"
    )]
    NoCompiler { compiler: String, source: std::io::Error },
    #[cfg(feature = "figures")]
    #[error("{compiler:?} did not compile the unit, {complaint}: try another in the variable CC")]
    Compiler { compiler: String, complaint: String },
    #[error("interrupted, no file was written: run it again")]
    Interrupted,
}

impl Error {
    /// Whether options contradict each other or the log, rather than the log being at fault.
    pub fn is_usage(&self) -> bool {
        matches!(
            self,
            Self::UnusedOption { .. }
                | Self::SindyOfChain
                | Self::CompareChain
                | Self::FrictionOfSums
                | Self::DelayWithoutFilter
                | Self::NoCovariance
        )
    }
}
