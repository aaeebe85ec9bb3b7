//! The simulated experiments of the paper, and those beyond it: numbers, figures, report.
//!
//! [`reproduce()`] runs them all and returns plain numbers, [`Results`]; [`figures()`] draws them
//! and [`page()`] tells them. Every simulated log has a known truth, so each claim can be judged.
//!
//! ```no_run
//! use torquewise_experiments::{Settings, page, reproduce};
//!
//! let results = reproduce(&Settings::quick(1), &|_| {})?;
//! let html = page(&results)?;
//! # Ok::<(), torquewise_experiments::ExperimentError>(())
//! ```

mod error;
mod spread;
mod truth;
mod scenario;
mod method;
mod trial;
mod agenda;
mod settings;
mod study;
mod results;
mod claims;
mod reproduce;
mod figures;
mod page;

pub use agenda::Progress;
pub use error::ExperimentError;
pub use figures::{Figure, figures};
pub use page::page;
pub use reproduce::reproduce;
pub use results::{Claim, Results, Verdict};
pub use settings::Settings;
pub use truth::true_energies;
