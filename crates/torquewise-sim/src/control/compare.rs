//! From plant, knowledge, laws to trackings: the same gains, the same motion, another law each.

use crate::control::controller::{Controller, Law};
use crate::control::gains::Gains;
use crate::control::knowledge::Knowledge;
use crate::control::plant::Plant;
use crate::control::track::{Tracking, lead, track};
use crate::error::SimError;
use torquewise_motion::Motion;

/// Lets each law drive the plant along the same desired motion with the same gains, each on a
/// thread of its own; with [`Law::HandGuiding`] a hand leads it.
///
/// Commands are kept within the limits of the drives, velocities below the cut-off of the sensors.
///
/// # Errors
/// Those of [`track`], of the first law that has one.
pub fn compare(
    plant: &Plant,
    known: &dyn Knowledge,
    laws: &[Law],
    gains: &Gains,
    wanted: &Motion,
) -> Result<Vec<Tracking>, SimError> {
    plant.check()?;
    let run = |law: Law| {
        let controller = Controller::new(law, known, gains, wanted)?;
        let controller = controller.with_limit(&plant.drive.limit)?;
        let mut controller = controller.with_cutoff(plant.sensors.cutoff)?;
        match law {
            Law::HandGuiding => lead(plant, &mut controller, wanted),
            _ => track(plant, &mut controller, wanted),
        }
    };
    std::thread::scope(|scope| {
        let running: Vec<_> = laws.iter().map(|&law| scope.spawn(move || run(law))).collect();
        let done = running
            .into_iter()
            .map(|thread| thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        done.collect()
    })
}
