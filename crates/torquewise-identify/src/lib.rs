//! From a motion log to equations of motion.
//!
//! [`reconstruct`](reconstruct::reconstruct) is the method on one page. It reads a recording four
//! times, in fixed memory: once to look around, once to sum the normal equations of every step,
//! twice to fit the terms that were kept.

pub mod error;
pub mod activation;
pub mod noise;
pub mod survey;
mod rough;
pub mod excitation;
pub mod patterns;
pub mod plan;
mod friction;
mod beside;
pub mod candidates;
mod rows;
pub mod evidence;
mod step;
mod held_out;
mod settings;
mod factor;
mod spread;
mod refit;
pub mod form;
pub mod disagreement;
pub mod warning;
mod trial;
mod learn;
mod prune;
pub mod found;
mod chain;
pub mod reconstruct;
pub mod score;
pub mod diagnose;
pub mod orders;

pub use activation::Scaling;
pub use diagnose::{Diagnosis, diagnose};
pub use disagreement::disagreements;
pub use error::IdentifyError;
pub use found::{Progress, Reconstruction};
pub use noise::NoiseFloor;
pub use orders::orders;
pub use patterns::{PatternPlan, Patterns, find_patterns};
pub use plan::{LibraryKind, Method, Plan};
pub use reconstruct::reconstruct;
pub use score::{Scores, score};
pub use survey::{Survey, survey};
pub use warning::Warning;
