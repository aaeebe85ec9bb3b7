//! From a motion log to equations of motion.
//!
//! [`reconstruct`](reconstruct::reconstruct) joins the two ways: the steps of the paper over a
//! library, and a chain of rigid bodies that is learned. It reads each log twice, in fixed memory:
//! once to look around, once to sum what a fit needs of it. These sums, a [`Summary`], add up
//! without rounding: those of many logs may be taken apart, saved, merged in any order, and
//! [solved](solve) for the model that fitting all logs together gives, bit for bit.

mod rough;
mod clipped;
mod clustered;
mod torque_kind;
pub mod disagreement;
mod drift;
pub mod score;
mod turning;
pub mod diagnose;
pub mod contacts;
pub mod plan;
mod states;
mod drive_terms;
mod basis;
pub mod warning;
mod excitation;
mod estimate;
mod chain_spec;
mod learn;
mod prune;
mod regions;
mod unseen;
mod library_errors;
pub mod reconstruction;
mod framed;
pub mod samples;
mod few_rows;
mod fitted;
mod torque_sign;
pub mod residual_shape;
pub mod rounds;
pub mod settings;
pub mod summary;
pub mod reconstruct;
pub mod bandwidth;
pub mod payload;
pub mod verdict;

pub(crate) use chain_spec::{ChainSpec, record_worth, trial};
pub use diagnose::{Diagnosis, diagnose};
pub use disagreement::{Disagreement, disagreements};
pub(crate) use drive_terms::{AT_REST, DriveTerm, WEIGHT_AT_REST, chain_rows, columns};
pub(crate) use estimate::{Linearisation, Sizes};
pub(crate) use fitted::Fitted;
pub use learn::kinds::first_look;
pub use plan::{ChainOptions, FrictionKind, LibraryOptions, Method, Plan, Refine, Regression};
pub use reconstruct::{Solution, reconstruct, solve};
pub use reconstruction::Reconstruction;
pub(crate) use reconstruction::{Progress, Watch};
pub use samples::samples;
pub use score::{Scores, score};
pub(crate) use states::States;
pub use summary::{Summary, summarise};
pub use torque_kind::weightless;
pub use torquewise_stepwise::progress::UNWATCHED;
pub use torquewise_stepwise::{
    IdentifyError, LibraryKind, PatternPlan, Patterns, Survey, find_patterns, survey,
};
pub(crate) use unseen::{HeldOut, HeldTo, Unseen, both_ways, even_blocks, geometric_mean, spread};
pub use warning::Warning;
