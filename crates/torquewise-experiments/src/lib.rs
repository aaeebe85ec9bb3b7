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

pub mod error;
pub mod spread;
pub mod truth;
pub mod scenario;
pub mod method;
pub mod trial;
pub mod agenda;
pub mod settings;
pub mod study;
pub mod results;
pub mod claims;
pub mod reproduce;
pub mod figures;
pub mod page;

pub use agenda::Progress;
pub use error::ExperimentError;
pub use figures::{Figure, figures};
pub use page::page;
pub use reproduce::reproduce;
pub use results::Results;
pub use settings::Settings;
pub use truth::true_energies;
