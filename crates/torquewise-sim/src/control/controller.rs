//! Controllers: PID, 1 and 2 of the paper, and two beyond it.

use crate::control::gains::Gains;
use crate::control::knowledge::{Knowledge, sum};
use crate::control::moving::Slopes;
use crate::control::plant::Plant;
use crate::control::reference::period;
use crate::error::{Result, check_joints};
use crate::state::State;
use torquewise_motion::Motion;
use torquewise_motion::path::Path;

/// How a command comes about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Law {
    /// Kp e + Ki ∫e + Kd ė.
    Pid,
    /// The same and what is known after step 1, at the desired motion (18).
    Controller1,
    /// The same and all that is known, at the desired motion (19), with friction.
    Controller2,
    /// M̂(q) (q̈_d + 3ω ė + 3ω² e + ω³ ∫e) + Ĉ q̇ + Ĝ at the measured motion, with friction at the
    /// desired velocity: feedback linearisation.
    ComputedTorque,
    /// Ĝ(q) alone: the arm floats, and a hand may lead it.
    HandGuiding,
}

impl Law {
    /// Name in tables and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pid => "pid",
            Self::Controller1 => "controller1",
            Self::Controller2 => "controller2",
            Self::ComputedTorque => "computed_torque",
            Self::HandGuiding => "hand_guiding",
        }
    }
}

/// A controller at work.
pub(crate) struct Controller<'a> {
    law: Law,
    known: &'a dyn Knowledge,
    gains: &'a Gains,
    /// Commands are kept within the limits of its drives, velocities below the cut-off of its sensors.
    plant: &'a Plant,
    pub(crate) period: f64,
    /// The way of the desired motion.
    path: Path,
    integral: Vec<f64>,
    /// Of the error and of the measured position, from the first tick on.
    slopes: Option<[Slopes; 2]>,
}

impl<'a> Controller<'a> {
    /// A controller for a desired motion, whose rows are its ticks.
    pub(crate) fn new(
        law: Law,
        known: &'a dyn Knowledge,
        gains: &'a Gains,
        plant: &'a Plant,
        wanted: &Motion,
    ) -> Result<Self> {
        let n = plant.arm.n_joints();
        gains.check(n)?;
        check_joints("the desired motion", wanted.n_joints(), n)?;
        check_joints("what is known", known.n_joints(), n)?;
        let (period, integral) = (period(wanted)?, vec![0.0; n]);
        let path = known.path();
        Ok(Self { law, known, gains, plant, period, path, integral, slopes: None })
    }

    /// Torque command \[N·m\], n, at a tick where the encoders say `measured` \[rad\], n.
    pub(crate) fn command(&mut self, wanted: &State, measured: &[f64]) -> Result<Vec<f64>> {
        if self.law == Law::HandGuiding {
            let still = vec![0.0; measured.len()];
            return Ok(self.within(self.known.rigid(measured, &still, &still)?));
        }
        self.path.step(&wanted.q);
        let error: Vec<f64> = sum(wanted.q.clone(), -1.0, measured);
        let [of_error, of_position] = self.slopes.get_or_insert_with(|| {
            let still = vec![0.0; measured.len()];
            let slopes = |first: &[f64]| Slopes::new(self.period, self.plant.sensors.cutoff, first);
            [slopes(&still), slopes(&wanted.dq)]
        });
        // Differences of the error rather than of the position: a delay of the one is harmless,
        // one of the other an error in proportion to the acceleration.
        let rate = of_error.next(&error).to_vec();
        let dq = of_position.next(measured).to_vec();

        let before = self.integral.clone();
        for (integral, error) in self.integral.iter_mut().zip(&error) {
            *integral += self.period * error;
        }
        let command = self.unlimited(wanted, [measured, &dq], [&error, &rate])?;
        // Where a command is at its limit, the integral does not grow any further.
        for (joint, tau) in command.iter().enumerate() {
            if tau.abs() > self.plant.drive.limit[joint] && tau * error[joint] > 0.0 {
                self.integral[joint] = before[joint];
            }
        }
        Ok(self.within(command))
    }

    fn unlimited(
        &self,
        wanted: &State,
        [q, dq]: [&[f64]; 2],
        [error, rate]: [&[f64]; 2],
    ) -> Result<Vec<f64>> {
        if self.law == Law::ComputedTorque {
            let w = self.gains.bandwidth;
            let asked = (0..error.len()).map(|i| {
                let feedback = w * w * self.integral[i] + 3.0 * (w * error[i] + rate[i]);
                wanted.ddq[i] + w * feedback
            });
            let rigid = self.known.rigid(q, dq, &asked.collect::<Vec<_>>())?;
            return Ok(sum(rigid, 1.0, &self.known.friction(&self.path, &wanted.dq)?));
        }
        let Gains { proportional, integral, derivative, .. } = self.gains;
        let feedback = (0..error.len()).map(|i| {
            proportional[i] * error[i] + integral[i] * self.integral[i] + derivative[i] * rate[i]
        });
        let State { q, dq, ddq } = wanted;
        let forward = match self.law {
            Law::Controller1 => self.known.slow(&self.path, dq)?,
            Law::Controller2 => {
                sum(self.known.rigid(q, dq, ddq)?, 1.0, &self.known.friction(&self.path, dq)?)
            }
            _ => vec![0.0; error.len()],
        };
        Ok(sum(feedback.collect(), 1.0, &forward))
    }

    fn within(&self, mut command: Vec<f64>) -> Vec<f64> {
        for (tau, &limit) in command.iter_mut().zip(&self.plant.drive.limit) {
            *tau = tau.clamp(-limit, limit);
        }
        command
    }
}
