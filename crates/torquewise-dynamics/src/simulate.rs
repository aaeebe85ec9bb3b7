//! Arm, MotionPlan → Simulation: a log free of noise whose truth is known.

use crate::arm::Arm;
use crate::error::DynamicsError;
use crate::plan::MotionPlan;
use crate::trajectory::{State, Trajectory};
use faer::Mat;
use std::ops::Range;
use torquewise_motion::{BLOCK_ROWS, Motion, Pattern, ReadError, Recording, Signals};

/// A simulated log and what is true about it.
#[derive(Clone, Debug)]
pub struct Simulation {
    /// q, q̇, q̈ and τ without noise, m×n.
    pub motion: Motion,
    /// What the arm does at each row, m.
    pub truth: Vec<Pattern>,
}

/// Moves an arm as planned and records torque beside the motion.
///
/// q̇ and q̈ are the exact derivatives of q, τ is [`Arm::inverse_dynamics`] of them. The same arm
/// and plan give the same bits. Checked against: `tests/motions.rs`.
///
/// # Errors
/// [`DynamicsError::Plan`] for a length or rate out of bounds; [`DynamicsError::Motion`] if the
/// arm's numbers are so large that a torque overflows.
pub fn simulate(arm: &Arm, plan: &MotionPlan) -> Result<Simulation, DynamicsError> {
    let trajectory = Trajectory::draw(arm, plan)?;
    record(arm, &trajectory, 0..trajectory.n_rows())
}

/// A simulated log that is made anew, block by block, each time it is read: any length in fixed
/// memory.
#[derive(Clone, Debug)]
pub struct SimulatedLog {
    arm: Arm,
    trajectory: Trajectory,
}

impl SimulatedLog {
    /// The rows [`simulate()`] would make, not yet made.
    ///
    /// # Errors
    /// [`DynamicsError::Plan`] for a length or rate out of bounds.
    pub fn new(arm: &Arm, plan: &MotionPlan) -> Result<Self, DynamicsError> {
        Ok(Self { arm: arm.clone(), trajectory: Trajectory::draw(arm, plan)? })
    }

    /// Number of rows m.
    pub fn n_rows(&self) -> usize {
        self.trajectory.n_rows()
    }
}

impl Recording for SimulatedLog {
    fn joints(&self) -> &[String] {
        self.arm.joints()
    }

    fn read(
        &self,
        visit: &mut dyn FnMut(usize, &Motion) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        let m = self.n_rows();
        (0..m).step_by(BLOCK_ROWS).try_for_each(|first| {
            let rows = first..m.min(first + BLOCK_ROWS);
            visit(0, &record(&self.arm, &self.trajectory, rows)?.motion)
        })
    }
}

/// The named rows of a trajectory, with the torque they take.
fn record(
    arm: &Arm,
    trajectory: &Trajectory,
    rows: Range<usize>,
) -> Result<Simulation, DynamicsError> {
    let (m, n) = (rows.len(), arm.n_joints());
    let [mut q, mut dq, mut ddq, mut tau] = std::array::from_fn(|_| Mat::zeros(m, n));
    let (mut t, mut truth) = (Vec::with_capacity(m), Vec::with_capacity(m));
    let (mut state, mut torque) = (State::zero(n), vec![0.0; n]);
    for (k, row) in rows.enumerate() {
        t.push(trajectory.state_at(row, &mut state));
        truth.push(Pattern::of(&state.dq, &state.ddq));
        arm.inverse_dynamics_into(&state.q, &state.dq, &state.ddq, &mut torque);
        for i in 0..n {
            q[(k, i)] = state.q[i];
            dq[(k, i)] = state.dq[i];
            ddq[(k, i)] = state.ddq[i];
            tau[(k, i)] = torque[i];
        }
    }
    let joints = arm.joints().to_vec();
    let motion = Motion::new(Signals { joints, t, q, dq, ddq, tau: Some(tau) })?;
    Ok(Simulation { motion, truth })
}
