//! Equations of motion from a log, as in the paper: activation, clusters, a regression of each.
//!
//! Read [`reconstruct`](reconstruct::reconstruct) first; it is the method on one page.

pub mod error;
mod digests;
mod systematic_sample;
pub mod noise;
pub mod survey;
pub mod held_out;
pub mod friction;
pub mod progress;
pub mod activation;
pub mod patterns;
pub mod plan;
pub mod candidates;
pub mod rows;
pub mod step;
mod model_selection;
pub mod library;
mod active_set;
mod refit;
pub mod fit;
pub mod reconstruct;
pub mod orders;

pub use candidates::Candidates;
pub use digests::Digests;
pub use error::IdentifyError;
pub use fit::StepReport;
pub use friction::FrictionKind;
pub use noise::NoiseFloor;
pub use patterns::{PatternPlan, Patterns, find_patterns};
pub(crate) use plan::MOST_CANDIDATES;
pub use plan::{LibraryKind, LibraryOptions, Regression};
pub use progress::Progress;
pub(crate) use rows::{PatternSums, clear_of_reversals, samples_of};
pub use survey::{Survey, survey, thinned};
pub use torquewise_rigid::rows::evenly;
