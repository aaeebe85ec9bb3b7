//! Torque that others put on an arm, and when it is a contact (E16).

use crate::predict::MotionRange;
use crate::{Log, Observer, Prepared, Result, Rows};
use torquewise_identify::contacts::external_torques;
use torquewise_model::Model;
use torquewise_motion::{ReadError, Repairs, Signal};

pub use torquewise_identify::contacts::{Contact, ContactDetector, Thresholds};

/// How external torque is looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExternalOptions {
    /// Bandwidth of the momentum observer \[Hz\].
    pub bandwidth: f64,
    /// False alarms of the whole arm in an hour of free motion.
    pub false_alarms_per_hour: f64,
}

impl Default for ExternalOptions {
    fn default() -> Self {
        Self { bandwidth: 10.0, false_alarms_per_hour: 1.0 }
    }
}

/// What is done with each row: time \[s\], external torque of each joint, NaN while the observer
/// settles, and its thresholds there \[N·m\], n each.
pub type SeeRow<'a> = dyn FnMut(f64, &[f64], &[f64]) -> Result<(), ReadError> + 'a;

/// What was found in a log.
#[derive(Clone, Debug)]
pub struct External {
    /// Beyond which external torque is a contact.
    pub thresholds: Thresholds,
    /// In the order of time.
    pub contacts: Vec<Contact>,
    /// Torques that the filter took for spikes, as which a short blow counts.
    pub spikes: u64,
    /// Where the log leaves the range that the model was fitted on: alarms there may be false.
    pub warnings: Vec<String>,
}

/// External torque of a log, row by row, and the contacts that it shows.
///
/// - `free`: a log of the same arm that nothing touches, which sets the thresholds; without, the log
///   itself sets them, contacts being the exception
/// - `see`: is handed each row
///
/// # Errors
/// `Error::Model` if the log is of another arm, and those of reading it.
pub fn contacts(
    model: &Model,
    log: &Log,
    free: Option<&Log>,
    options: ExternalOptions,
    observer: Observer<'_>,
    see: &mut SeeRow<'_>,
) -> Result<External> {
    let prepared = |log: &Log| -> Result<Prepared> {
        model.check_joints(log.joints())?;
        log.files.require_tau()?;
        log.prepare_as(model.training.filter, Rows::Settled)
    };
    let rows = prepared(log)?;
    let free = free.map(prepared).transpose()?;
    let is_free = free.is_some();
    let calm = free.as_ref().unwrap_or(&rows);
    let watched = calm.watched(observer, "setting thresholds");
    let numbers = (options.bandwidth, options.false_alarms_per_hour);
    let thresholds = Thresholds::of_free_motion(model, &watched, numbers, is_free)?;
    let mut detector = ContactDetector::new(model);
    let watched = rows.watched(observer, "looking for contacts");
    let (mut range, mut last) = (MotionRange::new(model.n_joints()), None);
    external_torques(model, &watched, options.bandwidth, &mut |row| {
        if last.is_some_and(|own| own != row.trajectory) {
            detector.separate();
        }
        last = Some(row.trajectory);
        if row.row == 0 {
            range.add(row.block);
        }
        let most = thresholds.at(row);
        detector.take(row.t, row.torque, &most);
        see(row.t, row.torque, &most)
    })?;
    let repairs: Repairs = rows.repairs().values().sum();
    let spikes = repairs.spikes.get(Signal::Tau.name()).copied().unwrap_or_default();
    let (contacts, warnings) = (detector.contacts().to_vec(), range.warnings(model));
    Ok(External { thresholds, contacts, spikes, warnings })
}
