//! Every experiment, one after the other on all cores.

use crate::error::PaperError;
use crate::results::{Results, Study};
use crate::scenario::Settings;
use crate::study::{beyond, cases, coefficients, control, cost, orders, patterns};
use crate::trial::{Progress, Trials};

/// Does every experiment.
///
/// `progress` is called when work begins or is done, from any thread.
///
/// # Errors
/// What kept an experiment from being done.
pub fn reproduce(
    settings: &Settings,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<Results, PaperError> {
    let patterns = patterns::study(settings)?;
    // The longest first, so that no core waits for one at the end.
    let [arms, others] = beyond::plans(settings);
    let plans = [arms, cases::plans(settings), others].concat();
    let trials = Trials::run(&cost::plans(settings), &plans, settings.seed, progress)?;
    let (orders, control): (Result<Study, PaperError>, Result<Study, PaperError>) =
        rayon::join(|| orders::study(settings), || control::study(settings));
    let studies = vec![
        patterns,
        orders?,
        cost::study(settings, &trials)?,
        cases::terms(settings, &trials)?,
        cases::torque(settings, &trials)?,
        cases::steps(settings, &trials)?,
        control?,
        beyond::ablation(settings, &trials)?,
        beyond::sweeps(settings, &trials)?,
        beyond::arms(settings, &trials)?,
        coefficients::study(settings, &trials)?,
    ];
    Ok(Results { settings: settings.clone(), studies })
}
