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
mod study {
    pub(crate) mod patterns;
    pub(crate) mod orders;
    pub(crate) mod cases;
    pub(crate) mod control;
    pub(crate) mod beyond;
}
mod page;

pub use error::PaperError;
pub(crate) use error::{Result, within};
pub use page::page;
pub use results::{Cell, Claim, ClaimVerdict, Figure, ResultTable, Results, Spread, Study, Timed};
pub use scenario::Settings;
pub use trial::{TrialProgress, TrialWatch};

use study::{beyond, cases, control, orders, patterns};
use trial::Trials;

/// Does every experiment.
///
/// `progress` is called when work begins or is done, from any thread.
///
/// # Errors
/// What kept an experiment from being done.
pub fn reproduce(settings: &Settings, progress: TrialWatch<'_>) -> Result<Results, PaperError> {
    let patterns = patterns::study(settings)?;
    let [levels, lengths] = beyond::points(settings);
    let mut rows = beyond::arm_rows(settings);
    // The longest first, so that no core waits for one at the end.
    rows.reverse();
    rows.extend([cases::rows(settings), beyond::variants(settings), levels, lengths].concat());
    let trials = Trials::run(&cases::timed_rows(settings), &rows, settings.seed, progress)?;
    let (orders, control) = rayon::join(|| orders::study(settings), || control::study(settings));
    let studies = vec![
        patterns,
        orders?,
        cases::cost(settings, &trials),
        cases::terms(settings, &trials)?,
        cases::torque(settings, &trials)?,
        cases::steps(settings, &trials)?,
        control?,
        beyond::ablation(settings, &trials)?,
        beyond::sweeps(settings, &trials)?,
        beyond::arms(settings, &trials)?,
        cases::coefficients(settings, &trials)?,
    ];
    Ok(Results { settings: settings.clone(), studies })
}
