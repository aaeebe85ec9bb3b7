//! Why a model cannot become code.
#![expect(missing_docs, reason = "each message explains its fields")]

use torquewise_model::ModelError;

/// Why a model cannot be exported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    #[error("the model cannot be exported")]
    Model(#[from] ModelError),
    #[error(
        "the code would hold a constant that is not finite: the coefficients of the model are too \
         large to be multiplied; fit it in SI units"
    )]
    NotFinite,
    #[error(
        "the code would hold the constant {constant:e}, which single precision cannot hold: \
         export in double precision"
    )]
    NotSingle { constant: f64 },
    #[error("{name:?} names no function: begin with a letter, then letters, digits and _")]
    Name { name: String },
    #[error("a robot file is made of links: fit the log with --library chain, or with --urdf")]
    NoChain,
    #[error(
        "a joint of the model is turned by the coordinates of several, which a robot file cannot \
         say: log the joint angles themselves"
    )]
    Coupled,
    #[error("the link of {joint} is no body that can be, and no simulator takes it")]
    Infeasible { joint: String },
    #[error("the URDF cannot take up the model")]
    Urdf(#[from] torquewise_sim::SimError),
    #[error(
        "the axis of {joint} lies elsewhere in the URDF than in the model: fit the log with --urdf \
         and this file"
    )]
    OtherGeometry { joint: String },
    #[error("the archive cannot be made")]
    Archive(#[from] zip::result::ZipError),
    #[error("the archive cannot be filled")]
    Fill(#[from] std::io::Error),
    #[error("the code cannot be written")]
    Template(#[from] minijinja::Error),
}
