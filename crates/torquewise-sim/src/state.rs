//! Positions, velocities and accelerations of n joints: at one instant, and row by row.

use crate::Result;
use faer::Mat;
use torquewise_motion::{Motion, Signals};

/// Where the joints are and how they move at one instant, n each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// Positions \[rad\].
    pub q: Vec<f64>,
    /// Velocities \[rad/s\].
    pub dq: Vec<f64>,
    /// Accelerations \[rad/s²\].
    pub ddq: Vec<f64>,
}

impl State {
    /// At rest.
    pub fn at_rest(q: &[f64]) -> Self {
        Self { q: q.to_vec(), dq: vec![0.0; q.len()], ddq: vec![0.0; q.len()] }
    }

    /// A share of the way from a pose, and its two derivatives.
    pub(crate) fn on_line(from: &[f64], travel: &[f64], [s, ds, dds]: [f64; 3]) -> Self {
        let times = |rate: f64| travel.iter().map(|travel| rate * travel).collect();
        let q = from.iter().zip(travel).map(|(from, travel)| from + s * travel).collect();
        Self { q, dq: times(ds), ddq: times(dds) }
    }

    /// Of the position, velocity and acceleration of each joint.
    pub(crate) fn of_joints(joints: impl Iterator<Item = [f64; 3]>) -> Self {
        let (q, dq, ddq) = joints.map(<(f64, f64, f64)>::from).collect();
        Self { q, dq, ddq }
    }

    pub(crate) fn of(motion: &Motion, row: usize) -> Self {
        let [q, dq, ddq] = motion.state(row);
        Self { q, dq, ddq }
    }
}

/// The motion of joints that are in these states at some times \[s\].
pub(crate) fn motion(
    joints: &[String],
    t: Vec<f64>,
    states: &[State],
    tau: Option<Mat<f64>>,
) -> Result<Motion> {
    let matrix = |of: fn(&State) -> &[f64]| {
        Mat::from_fn(states.len(), joints.len(), |row, joint| of(&states[row])[joint])
    };
    let [q, dq, ddq] = [matrix(|own| &own.q), matrix(|own| &own.dq), matrix(|own| &own.ddq)];
    Ok(Motion::new(Signals { joints: joints.to_vec(), t, q, dq, ddq, tau })?)
}
