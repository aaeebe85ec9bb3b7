//! From log, model to diagnosis: what the log leaves open, and what the model leaves unexplained.

pub mod rough;
pub mod clipped;
pub mod excitation;
pub mod disagreement;
pub mod drift;
pub mod score;
mod turning;
pub mod diagnose;
pub mod contacts;

pub use diagnose::{Diagnosis, diagnose};
pub use disagreement::{Disagreement, disagreements};
pub use drift::{Drift, drifts};
pub use excitation::findings;
pub use score::{Scores, score};
