//! A log as an arm in velocity mode gives it.

use crate::control::gains::mean_inertia;
use crate::control::moving::{Moving, Slopes};
use crate::control::reference::period;
use crate::{Plant, Result, State, check_between, check_joints, sum};
use torquewise_motion::{Motion, Raw};

/// Moves the plant by velocity controllers in its drives and records positions by the encoders and
/// torques of the drives, at even times.
///
/// Each joint has τ = 2 m ω (v_d − v) + m ω² ∫(v_d − v) with its own mean inertia m, as a drive is
/// tuned that knows nothing of the arm; v are differences of the measured position. The torque of
/// a stamp is the mean over the periods before and after it.
///
/// - `wanted`: velocities at each tick, and where to begin
/// - `bandwidth`: ω \[rad/s\]
///
/// # Errors
/// `SimError::JointCount`, `SimError::Setting` or `SimError::Uneven` if these do
/// not belong together; `SimError::Diverged` for a loop that is unstable.
pub fn record(plant: &Plant, wanted: &Motion, bandwidth: f64) -> Result<Raw> {
    let (m, n) = (wanted.n_rows(), plant.arm.n_joints());
    check_joints("the desired motion", wanted.n_joints(), n)?;
    check_between("the bandwidth [rad/s]", bandwidth, [1e-3, 1e4], "0.001 to 10000")?;
    let (period, inertia) = (period(wanted)?, mean_inertia(plant, wanted)?);
    let first = State::of(wanted, 0);
    let mut moving = Moving::new(plant, &first.q, &first.dq)?;
    let mut slopes = Slopes::new(period, plant.sensors.cutoff, &first.dq);
    let mut integral = vec![0.0; n];
    let mut before: Option<Vec<f64>> = None;
    let [mut q, mut tau] = [(); 2].map(|()| vec![Vec::with_capacity(m); n]);
    for row in 0..m {
        let measured = moving.measured();
        let v = slopes.next(&measured);
        let missing = sum(State::of(wanted, row).dq, -1.0, v);
        let torque = |i: usize| {
            let grown = integral[i] + period * missing[i];
            let tau = inertia[i] * bandwidth * (2.0 * missing[i] + bandwidth * grown);
            if tau.abs() <= plant.drive.limit[i] || tau * missing[i] < 0.0 {
                integral[i] = grown;
            }
            tau
        };
        let command: Vec<f64> = (0..n).map(torque).collect();
        let after = moving.hold(&command, &vec![0.0; n], period)?;
        let around = match &before {
            Some(before) => (0..n).map(|i| f64::midpoint(before[i], after[i])).collect(),
            None => after.clone(),
        };
        for (i, reported) in moving.reported(&around).into_iter().enumerate() {
            q[i].push(measured[i]);
            tau[i].push(reported);
        }
        before = Some(after);
    }
    let t = (0..m).map(|row| row as f64 * period).collect();
    let joints = plant.arm.joints().to_vec();
    Ok(Raw { joints, t, signals: [Some(q), None, None, Some(tau)] })
}
