//! Why a model cannot become code.
#![expect(missing_docs, reason = "each message explains its fields")]

use torquewise_model::ModelError;

/// What fails by [`ExportError`].
pub type Result<T, E = ExportError> = std::result::Result<T, E>;

/// Why a model cannot be exported.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum ExportError {
    #[error("the model cannot be exported")]
    #[diagnostic(forward(0))]
    Model(#[from] ModelError),
    #[error("coefficients of the model are so large that a constant of the code is not finite")]
    #[diagnostic(help("fit the model in SI units"))]
    NotFinite,
    #[error("the constant {constant:e} of the code is too large for single precision")]
    #[diagnostic(help("export in double precision"))]
    NotSingle { constant: f64 },
    #[error("{name:?} cannot name functions of C")]
    #[diagnostic(help("begin with a letter, then letters, digits and _"))]
    Name { name: String },
    #[error("the model has no links, of which a robot file is made")]
    #[diagnostic(help("fit the log along a chain, by library chain or a URDF"))]
    NoChain,
    #[error("several coordinates turn one joint of the model, for which robot files have no word")]
    #[diagnostic(help("log the joint angles themselves"))]
    Coupled,
    #[error(
        "the link of {joint} has a mass or inertia that no body has, and no simulator takes it"
    )]
    #[diagnostic(help("fit the log anew on more motion"))]
    Infeasible { joint: String },
    #[error("the URDF cannot take up the model")]
    #[diagnostic(forward(0))]
    Urdf(#[from] torquewise_sim::SimError),
    #[error("the axis of {joint} lies elsewhere in the URDF than in the model")]
    #[diagnostic(help("fit the log along the chain of this file"))]
    OtherGeometry { joint: String },
    #[error("the archive cannot be made")]
    Archive(#[from] zip::result::ZipError),
    #[error("the code cannot be written")]
    Template(#[from] minijinja::Error),
}
