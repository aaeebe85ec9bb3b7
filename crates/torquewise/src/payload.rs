//! The load on a link of an arm whose model is known.

use crate::error::Result;
use crate::evaluate::prepare;
use crate::log::Log;
use crate::observe::{Observer, Watched};
use torquewise_model::Model;

pub use torquewise_identify::payload::{Gains, Payload};

/// Estimates the load on a link from a log with it, by a model of the arm without it (E15).
///
/// - `link`: that carries it, as [`link_named`] finds it; the last if none
///
/// # Errors
/// `Error::Model` if the model is no chain of rigid bodies or of another arm,
/// `Error::Identify` if the rows do not suffice, and those of reading.
///
/// ```no_run
/// # fn main() -> Result<(), torquewise::Error> {
/// use torquewise::{Log, Model, observe::NOBODY, payload::payload};
///
/// let arm = Model::load("arm.json")?;
/// let load = payload(&arm, &Log::open("with_tool.csv")?, None, NOBODY)?;
/// println!("{:.3} ± {:.3} kg", load.mass.value, load.mass.std_error);
/// load.added_to(&arm)?.save("arm_with_tool.json")?;
/// # Ok(())
/// # }
/// ```
pub fn payload(
    model: &Model,
    log: &Log,
    link: Option<usize>,
    observer: Observer<'_>,
) -> Result<Payload> {
    let link = link.unwrap_or(model.n_joints() - 1);
    let log = prepare(model, log)?;
    let watched = Watched::new(log.rows(), observer, "weighing", log.rows_hint());
    Ok(Payload::find(model, &watched, link)?)
}

/// Finds what a unit of each torque column is worth, from a log with a load of known mass and a model
/// of the bare arm that was learned from the same columns (E15).
///
/// - `link`: that carries the load, the last if none
/// - `mass`: \[kg\]
///
/// # Errors
/// Those of [`payload`].
pub fn gains(
    model: &Model,
    log: &Log,
    link: Option<usize>,
    mass: f64,
    observer: Observer<'_>,
) -> Result<Gains> {
    let link = link.unwrap_or(model.n_joints() - 1);
    let log = prepare(model, log)?;
    let watched = Watched::new(log.rows(), observer, "weighing", log.rows_hint());
    Ok(Gains::find(model, &watched, link, mass)?)
}

/// The link of a name, from 0: as the URDF that gave the geometry calls it, or its joint.
#[must_use]
pub fn link_named(model: &Model, name: &str) -> Option<usize> {
    let robot = model.chain.as_ref().and_then(|chain| chain.robot.as_ref());
    let of_robot = robot.and_then(|robot| robot.links.iter().position(|link| link == name));
    of_robot.or_else(|| model.joints.iter().position(|joint| joint == name))
}
