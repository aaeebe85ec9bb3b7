//! The load on a link of an arm whose model is known.

use crate::evaluate::prepare;
use crate::{Log, Observer, Result};
use torquewise_model::Model;

pub use torquewise_identify::payload::{DriveGains, LoadPlace, Payload};

/// Estimates the load on a link from a log with it, by a model of the arm without it (E15).
///
/// - `place`: where it is, as [`LoadPlace::named`] says
///
/// # Errors
/// `Error::Model` if the model is no chain of rigid bodies or of another arm,
/// `Error::Identify` if the rows do not suffice, and those of reading.
///
/// ```no_run
/// # fn main() -> Result<(), torquewise::Error> {
/// use torquewise::{Log, Model, observe::NOBODY, payload::{LoadPlace, payload}};
///
/// let arm = Model::load("arm.json")?;
/// let Some(flange) = LoadPlace::named(&arm, None, None) else { return Ok(()) };
/// let load = payload(&arm, &Log::open("with_tool.csv")?, flange, NOBODY)?;
/// println!("{:.3} ± {:.3} kg", load.mass.value, load.mass.std_error);
/// load.added_to(&arm)?.save("arm_with_tool.json")?;
/// # Ok(())
/// # }
/// ```
pub fn payload(
    model: &Model,
    log: &Log,
    place: LoadPlace,
    observer: Observer<'_>,
) -> Result<Payload> {
    let log = prepare(model, log)?;
    let watched = log.watched(observer, "weighing");
    let mut found = Payload::find(model, &watched, place)?;
    found.at_odds = log.at_odds(model, observer)?;
    Ok(found)
}

/// Finds what a unit of each torque column is worth, from a log with a load of known mass and a model
/// of the bare arm that was learned from the same columns (E15).
///
/// - `place`: where the load is
/// - `mass`: \[kg\]
///
/// # Errors
/// Those of [`payload`].
pub fn gains(
    model: &Model,
    log: &Log,
    place: LoadPlace,
    mass: f64,
    observer: Observer<'_>,
) -> Result<DriveGains> {
    let log = prepare(model, log)?;
    let watched = log.watched(observer, "weighing");
    let mut found = DriveGains::find(model, &watched, place, mass)?;
    found.at_odds = log.at_odds(model, observer)?;
    Ok(found)
}
