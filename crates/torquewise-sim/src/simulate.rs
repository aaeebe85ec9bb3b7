//! A log free of noise whose truth is known.

use crate::friction::Bent;
use crate::state::motion;
use crate::trajectory::Trajectory;
use crate::{Arm, Friction, MotionPlan, Result, check_joints};
use faer::Mat;
use std::ops::Range;
use torquewise_motion::{BLOCK_ROWS, Motion, Pattern, ReadResult, Recording, Visit};
use torquewise_rigid::{MotionState, Moved};

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
/// `SimError::Setting` for a length or rate out of bounds; `SimError::Motion` if the
/// arm's numbers are so large that a torque overflows.
pub fn simulate(arm: &Arm, plan: &MotionPlan) -> Result<Simulation> {
    SimulatedLog::new(arm, plan)?.whole()
}

/// A simulated log that is made anew, block by block, each time it is read: any length in fixed
/// memory.
#[derive(Clone, Debug)]
pub struct SimulatedLog {
    arm: Arm,
    n_rows: usize,
    rate: f64,
    trajectory: Trajectory,
    friction: Friction,
}

impl SimulatedLog {
    /// The rows [`simulate()`] would make, not yet made.
    ///
    /// # Errors
    /// `SimError::Setting` for a length or rate out of bounds.
    pub fn new(arm: &Arm, plan: &MotionPlan) -> Result<Self> {
        let (n_rows, rate, friction) = (plan.n_rows()?, plan.rate, Friction::none(arm.n_joints()));
        let trajectory = Trajectory::draw(arm, plan)?;
        Ok(Self { arm: arm.clone(), n_rows, rate, trajectory, friction })
    }

    /// The same log of an arm that rubs: friction adds to its torque.
    ///
    /// # Errors
    /// `SimError::JointCount` for friction of another number of joints.
    pub fn with_friction(self, friction: Friction) -> Result<Self> {
        check_joints("friction", friction.n_joints(), self.arm.n_joints())?;
        Ok(Self { friction, ..self })
    }

    /// All rows at once.
    ///
    /// # Errors
    /// `SimError::Motion` if a torque overflows.
    pub fn whole(&self) -> Result<Simulation> {
        self.record(0..self.n_rows(), &mut Bent::default())
    }

    /// Number of rows m.
    pub fn n_rows(&self) -> usize {
        self.n_rows
    }

    /// The named rows of the trajectory, with the torque they take.
    ///
    /// - `bent`: what the rows before have left of the bristles
    fn record(&self, rows: Range<usize>, bent: &mut Bent) -> Result<Simulation> {
        let Self { arm, trajectory, friction, rate, .. } = self;
        let (m, n) = (rows.len(), arm.n_joints());
        let (mut states, mut tau) = (Vec::with_capacity(m), Mat::zeros(m, n));
        let (mut t, mut truth) = (Vec::with_capacity(m), Vec::with_capacity(m));
        let (mut torque, mut moved) = (vec![0.0; n], Moved::default());
        let step = 1.0 / rate;
        for (k, row) in rows.enumerate() {
            let (time, state) = trajectory.state_at(row, *rate);
            t.push(time);
            truth.push(Pattern::of(&state.dq, &state.ddq));
            let moving = MotionState { q: &state.q, dq: &state.dq, ddq: &state.ddq };
            arm.load(moving, &mut moved, &mut torque);
            for i in 0..n {
                tau[(k, i)] = torque[i] + friction.next(i, state.dq[i], step, bent);
            }
            states.push(state);
        }
        Ok(Simulation { motion: motion(arm.joints(), t, &states, Some(tau))?, truth })
    }
}

impl Recording for SimulatedLog {
    fn joints(&self) -> &[String] {
        self.arm.joints()
    }

    fn read(&self, visit: Visit<'_>) -> ReadResult {
        let (m, mut bent) = (self.n_rows(), Bent::default());
        (0..m).step_by(BLOCK_ROWS).try_for_each(|first| {
            let rows = first..m.min(first + BLOCK_ROWS);
            visit(0, &self.record(rows, &mut bent)?.motion)
        })
    }
}
