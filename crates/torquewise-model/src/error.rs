//! Errors of reading and applying a model.
#![expect(missing_docs, reason = "each message explains its fields")]

use std::io;
use std::path::PathBuf;

/// Why a model cannot be read or applied.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum ModelError {
    #[error("{} cannot be read", file.display())]
    #[diagnostic(help("check that it exists and may be read"))]
    Read { file: PathBuf, source: io::Error },
    #[error("{} cannot be written", file.display())]
    #[diagnostic(help("check that its folder exists, may be written and has room"))]
    Write { file: PathBuf, source: io::Error },
    #[error("no model in {}", file.display())]
    #[diagnostic(forward(source))]
    InFile { file: PathBuf, source: Box<ModelError> },
    #[error("the model has {model} joints, the log {log}: it is a model of another arm")]
    JointCount { model: usize, log: usize },
    #[error(
        "the model is of joints {}, the log of {}: it is a model of another arm",
        model.join(", "), log.join(", ")
    )]
    #[diagnostic(help("{}", as_of_model(model, log)))]
    JointNames { model: Vec<String>, log: Vec<String> },
    #[error("{what} has {found} entries, expected {expected}: one per joint")]
    Shape { what: &'static str, found: usize, expected: usize },
    #[error("not a model file: {reason}")]
    #[diagnostic(help("it may be cut off or of another program: fit the model anew"))]
    NotAModel { reason: String },
    #[error("the model file has version {found}, this program reads version {known}")]
    #[diagnostic(help("fit the model anew, or use the program that wrote it"))]
    Version { found: u64, known: u64 },
    #[error("the model has no step {found}: it has {known}")]
    #[diagnostic(help(
        "name a step from 1; a chain has none, a library that is fitted stepwise has"
    ))]
    Step { found: usize, known: usize },
    #[error("the model file is damaged: {reason}")]
    #[diagnostic(help("fit the model anew"))]
    Damaged { reason: String },
    #[error(transparent)]
    #[diagnostic(transparent)]
    Motion(#[from] torquewise_motion::MotionError),
    #[error(
        "the energy of {joints} joints has too many terms to list, those of {most} joints at most"
    )]
    #[diagnostic(help("choose fewer joints by a profile, or the product library"))]
    TooManyJoints { joints: usize, most: usize },
    #[error("the chain of the model cannot be used: {reason}")]
    #[diagnostic(help("take a file that is whole"))]
    Chain { reason: String },
    #[error(
        "the inertia of the model is next to nothing in some direction: it cannot be simulated"
    )]
    #[diagnostic(help("record motion that accelerates every joint, and fit the model anew"))]
    NoInertia,
    #[error("the model has no chain of rigid bodies")]
    #[diagnostic(help("fit the log along a chain, by library chain or a URDF"))]
    NoChain,
}

pub(crate) fn expect(what: &'static str, found: usize, expected: usize) -> Result<(), ModelError> {
    if found == expected { Ok(()) } else { Err(ModelError::Shape { what, found, expected }) }
}

/// How joints of a log become those of a model.
fn as_of_model(model: &[String], log: &[String]) -> &'static str {
    if model.iter().all(|joint| log.contains(joint)) {
        "they are the same in another order: give the columns of the log in that of the model"
    } else {
        "rename the joints of the log if they are the same"
    }
}
