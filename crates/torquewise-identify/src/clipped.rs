//! Torques that were clipped: a drive at its limit, a sensor at its end.

use torquewise_motion::{Motion, ends};

/// Part of the range of the torque that counts as its end.
const END: f64 = 0.005;
/// Part of the moving rows at the ends: a sine spends a tenth there.
const MANY: f64 = 0.15;
/// Fewer rows are the turning points of any torque.
const LEAST_ROWS: usize = 20;
/// A joint moves above this part of its peak speed.
const MOVING: f64 = 0.05;

/// Part of the rows in motion in which the torque of a joint is at one of its ends, where that is
/// more than a torque which is free to move would be.
///
/// Dry friction alone looks like this too: to be asked of joints that a model misses.
pub(crate) fn clipped(sample: &Motion, joint: usize) -> Option<f64> {
    let tau = sample.tau()?.col(joint);
    let [low, high] = ends(tau.iter().copied());
    let margin = END * (high - low);
    let dq = sample.dq().col(joint);
    let peak = dq.norm_max();
    let moving = || tau.iter().zip(dq.iter()).filter(|(_, dq)| dq.abs() > MOVING * peak);
    let at_end = moving().filter(|(tau, _)| **tau > high - margin || **tau < low + margin).count();
    let share = at_end as f64 / moving().count().max(1) as f64;
    (at_end >= LEAST_ROWS && share > MANY).then_some(share)
}
