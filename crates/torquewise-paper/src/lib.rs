//! The simulated experiments of the paper, and those beyond it: numbers, claims, figures, one page.
//!
//! [`reproduce()`] runs them all. Every simulated log has a known truth, so each claim can be
//! judged. What is found is a [`Study`] each: tables and claims, which are saved as JSON, and
//! charts; [`page()`] shows all of it.
//!
//! ```no_run
//! use torquewise_paper::{Settings, page, reproduce};
//!
//! let results = reproduce(&Settings::quick(1), &|_| {})?;
//! let html = page(&results)?;
//! # Ok::<(), torquewise_paper::PaperError>(())
//! ```

mod error;
mod truth;
mod scenario;
mod method;
mod results;
mod trial;
mod charts;
mod study {
    pub(crate) mod patterns;
    pub(crate) mod orders;
    pub(crate) mod cost;
    pub(crate) mod cases;
    pub(crate) mod coefficients;
    pub(crate) mod control;
    pub(crate) mod beyond;
}
mod reproduce;
mod page;

pub use error::PaperError;
pub use page::page;
pub use reproduce::reproduce;
pub use results::{Cell, Claim, Figure, Results, Spread, Study, Table, Timed, Verdict};
pub use scenario::Settings;
pub use trial::Progress;
