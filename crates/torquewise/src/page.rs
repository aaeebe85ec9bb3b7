//! The page of a fit: what was found, and how far to trust it.

use crate::evaluate::interval;
use crate::physics::{PhysicsCheck, STATES};
use crate::{Error, Evaluation, FitResult, Observer, Prepared, Result};
use torquewise_export::torque_costs;
use torquewise_identify::{IdentifyError, diagnose};
use torquewise_report::{Findings, fit_report};

pub use torquewise_report::{LogFile, Origin};

/// The report of a fit over its logs, and over those of another motion, as one HTML text; none for a
/// fit to motion at hand, whose rows it did not keep.
///
/// # Errors
/// `Error::Report`, `Error::Export` if its cost cannot be counted, and those of reading.
pub fn page(
    fit: &FitResult,
    test: Option<(&Prepared, &Evaluation)>,
    origin: Origin<'_>,
    observer: Observer<'_>,
) -> Result<Option<String>> {
    let look = |log: &Prepared| {
        let watched = log.watched(observer, "looking at the residuals");
        let mut seen = diagnose(&fit.model, &fit.patterns, &watched)?;
        if let Some(interval) = interval(&fit.model, log.rows())? {
            let bounds = interval.bounds(&seen.trace.motion, &seen.trace.tau_hat);
            seen.trace.bounds = Some(bounds.map_err(IdentifyError::Read)?);
        }
        Ok::<_, Error>(seen)
    };
    let Some(log) = &fit.log else { return Ok(None) };
    let verdict = test.map_or_else(|| fit.verdict(), |(_, scores)| scores.verdict.clone());
    let (diagnosis, test) = (look(log)?, test.map(|(test, _)| look(test)).transpose()?);
    let physics = PhysicsCheck::of(&fit.model, STATES)?;
    Ok(Some(fit_report(&Findings {
        found: fit,
        verdict: &verdict,
        diagnosis: &diagnosis,
        checks: Some(&physics.trained),
        test: test.as_ref(),
        costs: &torque_costs(&fit.model)?,
        origin,
    })?))
}
