//! Controllers: PID, 1 and 2 of the paper, and two beyond it.

use crate::control::gains::Gains;
use crate::control::knowledge::{Knowledge, sum};
use crate::control::moving::Slopes;
use crate::control::reference::period;
use crate::error::{Result, check_above_zero, check_joints};
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
pub struct Controller<'a> {
    pub(crate) law: Law,
    known: &'a dyn Knowledge,
    pub(crate) gains: Gains,
    /// Commands are kept within ± this \[N·m\], n.
    limit: Vec<f64>,
    cutoff: f64,
    pub(crate) period: f64,
    /// The way of the desired motion.
    path: Path,
    integral: Vec<f64>,
    /// Of the error and of the measured position, from the first tick on.
    slopes: Option<[Slopes; 2]>,
}

impl<'a> Controller<'a> {
    /// A controller for a desired motion, whose rows are its ticks. Commands have no limit, and
    /// velocities are plain differences.
    ///
    /// # Errors
    /// `SimError::JointCount` or `SimError::Setting` if these do not belong together;
    /// `SimError::Uneven` or `SimError::TooShort` for a motion without a rate.
    pub fn new(law: Law, known: &'a dyn Knowledge, gains: &Gains, wanted: &Motion) -> Result<Self> {
        let n = known.n_joints();
        gains.check(n)?;
        check_joints("the desired motion", wanted.n_joints(), n)?;
        Ok(Self {
            law,
            known,
            gains: gains.clone(),
            limit: vec![f64::INFINITY; n],
            cutoff: f64::INFINITY,
            period: period(wanted)?,
            path: known.path(),
            integral: vec![0.0; n],
            slopes: None,
        })
    }

    /// The same with commands within ± `limit` \[N·m\], n: where a command is at its limit, the
    /// integral does not grow any further.
    ///
    /// # Errors
    /// `SimError::JointCount` or `SimError::Setting`.
    pub fn with_limit(mut self, limit: &[f64]) -> Result<Self> {
        check_joints("the limit of the torque", limit.len(), self.limit.len())?;
        for &limit in limit {
            check_above_zero("the limit of the torque [N·m]", limit)?;
        }
        self.limit = limit.to_vec();
        Ok(self)
    }

    /// The same with velocities below a cut-off \[Hz\].
    ///
    /// # Errors
    /// `SimError::Setting`.
    pub fn with_cutoff(mut self, cutoff: f64) -> Result<Self> {
        check_above_zero("the cut-off of the velocity [Hz]", cutoff)?;
        self.cutoff = cutoff;
        Ok(self)
    }

    /// Number of joints n.
    pub fn n_joints(&self) -> usize {
        self.limit.len()
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
            let slopes = |first: &[f64]| Slopes::new(self.period, self.cutoff, first);
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
        for (joint, tau) in command.iter().enumerate() {
            if tau.abs() > self.limit[joint] && tau * error[joint] > 0.0 {
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
        let Gains { proportional, integral, derivative, .. } = &self.gains;
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
        for (tau, &limit) in command.iter_mut().zip(&self.limit) {
            *tau = tau.clamp(-limit, limit);
        }
        command
    }
}
