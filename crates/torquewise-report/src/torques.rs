//! The torque that a motion takes beside what models predict of it, over time.

use crate::{Axis, Chart, Colour, Mark, Series};
use faer::{Mat, MatRef};
use torquewise_motion::{Motion, MotionError, ends};

/// Space beyond the torque that is needed, as a share of its range.
const SPACE: f64 = 0.15;

/// A chart of each joint: the torque of a motion under a label, and what is predicted of it, m×n
/// \[N·m\], every so many rows.
///
/// The axis is that of the torque of the motion, so that a bad prediction does not flatten it.
///
/// - `linked`: charts with the same word share the cursor
///
/// # Errors
/// [`MotionError`] if the motion has no torque.
pub fn torque_charts(
    (label, motion): (&str, &Motion),
    stride: usize,
    predicted: &[(String, Colour, Mat<f64>)],
    linked: Option<&str>,
) -> Result<Vec<Chart>, MotionError> {
    let needed = motion.require_tau()?;
    let of_joint = |joint: usize| {
        let over_time = |tau: MatRef<'_, f64>| -> Vec<[f64; 2]> {
            let rows = motion.t().iter().zip(tau.col(joint).iter()).step_by(stride);
            rows.map(|(&t, &tau)| [t, tau]).collect()
        };
        let needed = over_time(needed);
        let [low, high] = ends(needed.iter().map(|point| point[1]));
        let space = (SPACE * (high - low)).max(1e-6);
        let range = Some([low - space, high + space]);
        let mut series = vec![Series::new(label, Mark::BroadLine, Colour::Measured, needed)];
        series.extend(predicted.iter().map(|(label, colour, torque)| {
            Series::new(label, Mark::Line, *colour, over_time(torque.as_ref()))
        }));
        let axes = [Axis::named("time [s]"), Axis { range, ..Axis::named("torque [N·m]") }];
        let linked = linked.map(str::to_owned);
        Chart { linked, ..Chart::new(format!("Joint {}", joint + 1), axes, series) }
    };
    Ok((0..motion.n_joints()).map(of_joint).collect())
}
