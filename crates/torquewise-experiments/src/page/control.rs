//! From an arm with friction under control to section: recorded, learned, predicted, tracked.

use crate::page::Drawn;
use crate::page::cells::{columns, joints, table};
use crate::study::control::{ControlResults, DEAD_ZONE};
use torquewise_report::html::number::significant;
use torquewise_report::html::{Item, Section};

/// Fig. 10 and 11 on an arm with friction.
pub(super) fn section(results: &ControlResults, drawn: &Drawn) -> Section {
    let rows: Vec<String> = results.rows.iter().map(usize::to_string).collect();
    let mut items = vec![Item::Text(format!(
        "The second half of the paper, in simulation: an arm with rotors, Stribeck friction, \
         encoders of 20 bits and drives that are 1 ms late is moved by velocity controllers, \
         very slowly in both directions, uniformly, then variably ({} rows once cleaned). From \
         measured positions and torques alone a chain with friction is learned [E8]; its model \
         then drives the arm at 1 kHz.",
        rows.join(" + ")
    ))];
    items.extend(drawn.items("fig10_friction"));
    items.push(friction(results));
    items.extend(drawn.items("fig10_control"));
    items.push(steps(results));
    items.extend(drawn.items("fig11_tracking"));
    items.push(tracking(results));
    Section { heading: "In the controller (Fig. 10 and 11)".into(), items }
}

fn friction(results: &ControlResults) -> Item {
    let row = (results.friction.iter()).map(|curve| significant(curve.worst_percent, 2)).collect();
    let columns = joints("largest error of f(v) [%], joint", results.friction.len());
    table(&format!("From {DEAD_ZONE} rad/s on, both directions."), columns, vec![row])
}

fn steps(results: &ControlResults) -> Item {
    let mut columns = columns("after");
    columns.extend(joints("error [%], joint", results.needed.len()));
    let rows = results.steps.iter().enumerate().map(|(place, step)| {
        let mut row = vec![format!("step {}: {}", place + 1, step.name)];
        row.extend(step.nrmse_percent.iter().map(|percent| significant(*percent, 2)));
        row
    });
    table("RMSE over the spread of the torque.", columns, rows.collect())
}

fn tracking(results: &ControlResults) -> Item {
    let mut columns = columns("controller");
    columns.extend(joints("RMS error [mrad], joint", results.needed.len()));
    columns.extend(joints("of PID [%], joint", results.needed.len()));
    let pid = results.tracking.first().map_or(&[][..], |pid| &pid.rms_error_rad);
    let rows = results.tracking.iter().map(|found| {
        let shares = found.rms_error_rad.iter().zip(pid).map(|(error, pid)| 100.0 * error / pid);
        let errors = found.rms_error_rad.iter().map(|error| 1e3 * error);
        let numbers = errors.chain(shares).map(|x| significant(x, 2));
        std::iter::once(found.name.clone()).chain(numbers).collect()
    });
    let caption = format!(
        "Second period; the same gains for all, critically damped at {} rad/s by the inertia of \
         the learned model.",
        results.bandwidth
    );
    table(&caption, columns, rows.collect())
}
