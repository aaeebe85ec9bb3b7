//! What a controller has before it: arm, friction, drives and encoders.

use crate::control::integrate::Integrator;
use crate::error::check_above_zero;
use crate::{Arm, Friction, Result, check_between, check_joints, sum};

/// An arm as it is met: τ + τ_external = M(q) q̈ + C(q, q̇) q̇ + G(q) + F(q̇), method.md (1) (17).
///
/// Rotor inertia is the arm's, [`Arm::with_rotors`]. Friction has the smooth reversal of
/// [`Friction`]: no events to find, and steps as short as it asks for.
#[derive(Clone, Debug)]
pub struct Plant {
    /// Links and rotors.
    pub arm: Arm,
    /// Of the joints.
    pub friction: Friction,
    /// What turns a commanded torque into a torque.
    pub drive: Actuator,
    /// What turns a position into a measured one.
    pub sensors: Sensors,
    /// Error of one step of integration, in rad and rad/s per (1 + size of the number).
    pub tolerance: f64,
}

/// What turns a commanded torque into a torque.
#[derive(Clone, Debug, PartialEq)]
pub struct Actuator {
    /// Largest torque of each joint \[N·m\], n; infinite for none.
    pub limit: Vec<f64>,
    /// Time from the command to the torque \[s\], at most 0.1.
    pub delay: f64,
}

/// What turns a position into a measured one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensors {
    /// Step of the encoders \[rad\]; 0 for none.
    pub step: f64,
    /// Standard deviation of white noise in the position, before quantisation \[rad\].
    pub noise: f64,
    /// The same of the recorded torque \[N·m\].
    pub torque_noise: f64,
    /// Cut-off \[Hz\] of the first-order low-pass on differences of the position, which are the
    /// velocity; infinite for none.
    pub cutoff: f64,
    /// Seed of the noise.
    pub seed: u64,
}

impl Default for Sensors {
    /// An encoder of 20 bits, velocity below 100 Hz, no noise.
    fn default() -> Self {
        let step = std::f64::consts::TAU / f64::from(1 << 20);
        Self { step, noise: 0.0, torque_noise: 0.0, cutoff: 100.0, seed: 0 }
    }
}

impl Actuator {
    /// Drives of n joints.
    ///
    /// - `limits`: largest torques \[N·m\], n or one for all; empty for none
    /// - `delay`: from the command to the torque \[s\]
    pub fn new(n: usize, limits: &[f64], delay: f64) -> Self {
        let limit = if limits.is_empty() { vec![f64::INFINITY; n] } else { each(limits, n) };
        Self { limit, delay }
    }
}

/// One number for all joints, or one each.
pub fn each(given: &[f64], n: usize) -> Vec<f64> {
    if let [all] = given { vec![*all; n] } else { given.to_vec() }
}

impl Sensors {
    /// Encoders of so many counts to a turn, without noise; 0 for exact positions.
    pub fn of_counts(counts: u32) -> Self {
        let step = if counts == 0 { 0.0 } else { std::f64::consts::TAU / f64::from(counts) };
        Self { step, ..Self::default() }
    }

    /// Positions and differences as they are.
    pub const IDEAL: Self =
        Self { step: 0.0, noise: 0.0, torque_noise: 0.0, cutoff: f64::INFINITY, seed: 0 };
}

impl Plant {
    /// An arm without friction, limits, delay or errors of measurement.
    pub fn ideal(arm: Arm) -> Self {
        let n = arm.n_joints();
        let drive = Actuator::new(n, &[], 0.0);
        let (friction, sensors) = (Friction::none(n), Sensors::IDEAL);
        Self { arm, friction, drive, sensors, tolerance: 1e-10 }
    }

    /// Whether all parts are of one arm, and every number can be.
    ///
    /// # Errors
    /// `SimError::JointCount` or `SimError::Setting`, naming what is at fault.
    pub fn check(&self) -> Result<()> {
        let n = self.arm.n_joints();
        check_joints("friction", self.friction.n_joints(), n)?;
        check_joints("the limit of the torque", self.drive.limit.len(), n)?;
        for &limit in &self.drive.limit {
            check_above_zero("the limit of the torque [N·m]", limit)?;
        }
        let Sensors { step, noise, torque_noise, cutoff, .. } = self.sensors;
        let numbers = [
            ("the step of the encoder [rad]", step),
            ("the noise of the position [rad]", noise),
            ("the noise of the torque [N·m]", torque_noise),
        ];
        for (what, found) in numbers {
            check_between(what, found, [0.0, f64::MAX], "0 or more")?;
        }
        check_between("the delay of the torque [s]", self.drive.delay, [0.0, 0.1], "0 to 0.1")?;
        check_above_zero("the cut-off of the velocity [Hz]", cutoff)?;
        check_between("the tolerance", self.tolerance, [1e-13, 1e-3], "1e-13 to 1e-3")
    }

    /// Torque \[N·m\], n, that makes the arm move so: [`Arm::inverse_dynamics`] and friction.
    pub fn needed_torque(&self, q: &[f64], dq: &[f64], ddq: &[f64]) -> Vec<f64> {
        sum(self.arm.inverse_dynamics(q, dq, ddq), 1.0, &self.friction.torques(dq))
    }

    /// q, dq and, where friction has bristles, how far they are bent at first, in one.
    pub(crate) fn state(&self, q: &[f64], dq: &[f64]) -> Vec<f64> {
        let bristles = if self.friction.has_bristles() { q.len() } else { 0 };
        [q, dq, &vec![0.0; bristles]].concat()
    }

    /// Lets a steady torque act on a whole state from a time \[s\] for some seconds, by an integrator
    /// that remembers its step. Limits, delay and sensors have no part in it.
    pub(crate) fn follow(
        &self,
        integrator: &mut Integrator,
        state: &mut [f64],
        times: [f64; 2],
        tau: &[f64],
    ) -> Result<()> {
        integrator.advance(state, times, |x, dx| {
            if x.iter().any(|x| !x.is_finite()) {
                // The integrator takes a shorter step.
                dx.fill(f64::NAN);
                return Ok(());
            }
            let n = tau.len();
            let (q, rest) = x.split_at(n);
            let (dq, bent) = rest.split_at(n);
            dx[..n].copy_from_slice(dq);
            let mut left = tau.to_vec();
            for joint in 0..n {
                let z = bent.get(joint).copied().unwrap_or_default();
                let [rubs, bends] = self.friction.bent(joint, dq[joint], z);
                left[joint] -= rubs;
                if let Some(slope) = dx.get_mut(2 * n + joint) {
                    *slope = bends;
                }
            }
            dx[n..2 * n].copy_from_slice(&self.arm.forward_dynamics(q, dq, &left)?);
            Ok(())
        })
    }
}

#[cfg(test)]
mod tests;
