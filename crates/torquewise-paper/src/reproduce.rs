//! Every experiment, one after the other on all cores.

use crate::error::PaperError;
use crate::results::{Results, Study};
use crate::settings::Settings;
use crate::study::{ablation, arms, cases, coefficients, control, cost, orders, patterns, sweeps};
use crate::trial::{Progress, Trials};

/// Does every experiment.
///
/// `progress` is called when work begins or is done, from any thread.
///
/// # Errors
/// [`PaperError::Setting`] for settings that ask for nothing, else what kept an experiment from
/// being done.
pub fn reproduce(
    settings: &Settings,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<Results, PaperError> {
    settings.check()?;
    let patterns = patterns::study(settings)?;
    // The longest first, so that no core waits for one at the end.
    let plans = [
        arms::plans(settings),
        cases::plans(settings),
        ablation::plans(settings),
        sweeps::plans(settings),
    ];
    let trials = Trials::run(&cost::plans(settings), &plans.concat(), settings.seed, progress)?;
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
        ablation::study(settings, &trials)?,
        sweeps::study(settings, &trials)?,
        arms::study(settings, &trials)?,
        coefficients::study(settings, &trials)?,
    ];
    Ok(Results { settings: settings.clone(), studies })
}
