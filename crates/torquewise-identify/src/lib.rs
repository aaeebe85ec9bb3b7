//! From a motion log to equations of motion.
//!
//! [`reconstruct`](reconstruct::reconstruct) is the method on one page. It reads each log twice, in
//! fixed memory: once to look around, once to sum what a fit needs of it. These sums, a
//! [`Summary`], add up without rounding: those of many logs may be taken apart, saved, merged in
//! any order, and [solved](solve) for the model that fitting all logs together gives, bit for bit.

pub mod activation;
mod rough;
pub mod excitation;
pub mod patterns;
pub mod plan;
mod states;
mod beside;
pub mod candidates;
mod basis;
mod rows;
pub mod evidence;
mod step;
pub mod cutoff;
mod settle;
mod factor;
mod base;
mod spread;
mod refit;
pub mod form;
pub mod disagreement;
pub mod warning;
pub mod estimate;
mod trial;
mod learn;
mod prune;
mod overlooked;
pub mod found;
mod summary_file;
pub mod rounds;
pub mod settings;
pub mod summary;
pub mod score;
pub mod reconstruct;
pub mod diagnose;
pub mod orders;

pub use diagnose::{Diagnosis, diagnose};
pub use found::{Progress, Reconstruction};
pub use patterns::{PatternPlan, Patterns, find_patterns};
pub use plan::{LibraryKind, Method, Plan};
pub use reconstruct::{Solution, reconstruct, solve};
pub use score::{Scores, score};
pub use summary::{Summary, summarise};
pub use torquewise_survey::{IdentifyError, Survey, survey};
pub use warning::Warning;
