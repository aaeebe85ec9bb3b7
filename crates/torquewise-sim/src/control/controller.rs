//! Controllers: PID, 1 and 2 of the paper, and two beyond it; the closed loop at a fixed rate.

use crate::control::gains::{Gains, mean_inertia};
use crate::control::moving::{Moving, Slopes};
use crate::control::reference::period;
use crate::{Knowledge, Plant, Result, SimError, State, check_joints, sum};
use faer::Mat;
use rayon::prelude::*;
use torquewise_motion::{Motion, Path};

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
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Pid, Self::Controller1, Self::Controller2, Self::ComputedTorque, Self::HandGuiding];

    /// Name in tables and files.
    pub fn name(self) -> &'static str {
        ["pid", "controller1", "controller2", "computed_torque", "hand_guiding"][self as usize]
    }
}

struct Controller<'a> {
    law: Law,
    known: &'a dyn Knowledge,
    gains: &'a Gains,
    /// Integrals stop at the limits of its drives, velocities are below the cut-off of its sensors.
    plant: &'a Plant,
    period: f64,
    /// The way of the desired motion.
    path: Path,
    integral: Vec<f64>,
    /// Of the error and of the measured position.
    slopes: [Slopes; 2],
}

impl Controller<'_> {
    /// Torque command \[N·m\], n, at a tick where the encoders say `measured` \[rad\], n.
    fn command(&mut self, wanted: &State, measured: &[f64]) -> Result<Vec<f64>> {
        if self.law == Law::HandGuiding {
            let still = vec![0.0; measured.len()];
            return self.known.rigid(measured, &still, &still);
        }
        self.path.step(&wanted.q);
        let error: Vec<f64> = sum(wanted.q.clone(), -1.0, measured);
        let [of_error, of_position] = &mut self.slopes;
        // Differences of the error rather than of the position: a delay of the one is harmless,
        // one of the other an error in proportion to the acceleration.
        let rate = of_error.next(&error).to_vec();
        let dq = of_position.next(measured).to_vec();

        let before = self.integral.clone();
        for (integral, error) in self.integral.iter_mut().zip(&error) {
            *integral += self.period * error;
        }
        let command = if self.law == Law::ComputedTorque {
            let w = self.gains.bandwidth;
            let asked = (0..error.len()).map(|i| {
                let feedback = w * w * self.integral[i] + 3.0 * (w * error[i] + rate[i]);
                wanted.ddq[i] + w * feedback
            });
            let rigid = self.known.rigid(measured, &dq, &asked.collect::<Vec<_>>())?;
            sum(rigid, 1.0, &self.known.friction(&self.path, &wanted.dq)?)
        } else {
            let Gains { proportional: p, integral, derivative, .. } = self.gains;
            let feedback = (0..error.len())
                .map(|i| p[i] * error[i] + integral[i] * self.integral[i] + derivative[i] * rate[i])
                .collect();
            let State { q, dq, ddq } = wanted;
            let forward = match self.law {
                Law::Controller1 => self.known.slow(&self.path, dq)?,
                Law::Controller2 => {
                    sum(self.known.rigid(q, dq, ddq)?, 1.0, &self.known.friction(&self.path, dq)?)
                }
                _ => vec![0.0; error.len()],
            };
            sum(feedback, 1.0, &forward)
        };
        // Where a command is at its limit, the integral does not grow any further.
        for (joint, tau) in command.iter().enumerate() {
            if tau.abs() > self.plant.drive.limit[joint] && tau * error[joint] > 0.0 {
                self.integral[joint] = before[joint];
            }
        }
        Ok(command)
    }
}

/// What a controlled arm did, at each tick.
#[derive(Clone, Debug)]
pub struct Tracking {
    /// Time stamps \[s\], m.
    pub t: Vec<f64>,
    /// True positions \[rad\], m×n.
    pub q: Mat<f64>,
    /// True velocities \[rad/s\], m×n.
    pub dq: Mat<f64>,
    /// Desired less true position \[rad\], m×n.
    pub error: Mat<f64>,
    /// Commanded torque \[N·m\], m×n, held until the next tick.
    pub tau: Mat<f64>,
    /// Torque of the hand that leads the arm \[N·m\], m×n; zeros without one.
    pub hand: Mat<f64>,
    /// Share of the ticks at which a joint is at the limit of its torque, n.
    pub saturated: Vec<f64>,
}

/// Drives the plant along a desired motion, from its first state on.
///
/// With [`Law::HandGuiding`] a hand leads the arm: a spring and a damper with the gains of the
/// controller, pulling at every joint. The torque of the hand says how heavy the arm feels.
///
/// Commands are kept within the limits of the drives, velocities below the cut-off of the sensors.
///
/// # Errors
/// `SimError::JointCount` if they are of different arms; `SimError::Diverged` for a
/// loop that is unstable.
pub fn track(
    plant: &Plant,
    law: Law,
    known: &dyn Knowledge,
    gains: &Gains,
    wanted: &Motion,
) -> Result<Tracking> {
    let (m, n) = (wanted.n_rows(), plant.arm.n_joints());
    gains.check(n)?;
    check_joints("the desired motion", wanted.n_joints(), n)?;
    check_joints("what is known", known.n_joints(), n)?;
    let (period, first) = (period(wanted)?, State::of(wanted, 0));
    let (path, integral) = (known.path(), vec![0.0; n]);
    let slopes = [&integral, &first.dq].map(|x| Slopes::new(period, plant.sensors.cutoff, x));
    let mut controller = Controller { law, known, gains, plant, period, path, integral, slopes };
    let hand = (law == Law::HandGuiding).then_some(gains);
    let mut moving = Moving::new(plant, &first.q, &first.dq)?;
    let [mut q, mut dq, mut error, mut tau, mut led] = std::array::from_fn(|_| Mat::zeros(m, n));
    let mut saturated = vec![0.0; n];
    for row in 0..m {
        let target = State::of(wanted, row);
        let measured = moving.measured();
        let command = controller.command(&target, &measured)?;
        let pulled = |i: usize| {
            let [e, de] = [target.q[i] - moving.q()[i], target.dq[i] - moving.dq()[i]];
            hand.map_or(0.0, |hand| hand.proportional[i] * e + hand.derivative[i] * de)
        };
        let pull: Vec<f64> = (0..n).map(pulled).collect();
        for i in 0..n {
            q[(row, i)] = moving.q()[i];
            dq[(row, i)] = moving.dq()[i];
            error[(row, i)] = target.q[i] - moving.q()[i];
            let limit = plant.drive.limit[i];
            tau[(row, i)] = command[i].clamp(-limit, limit);
            led[(row, i)] = pull[i];
            saturated[i] += f64::from(u8::from(command[i].abs() >= limit));
        }
        if row + 1 < m {
            moving.hold(&command, &pull, period)?;
        }
    }
    let saturated = saturated.into_iter().map(|ticks| ticks / m as f64).collect();
    let t = wanted.t().iter().map(|t| t - wanted.t()[0]).collect();
    Ok(Tracking { t, q, dq, error, tau, hand: led, saturated })
}

/// What a controlled arm did under a law.
#[derive(Clone, Debug)]
pub struct Run {
    /// Name in tables and files: that of the law, `_perfect` where the plant itself was known.
    pub name: String,
    /// How commands came about.
    pub law: Law,
    /// At each tick.
    pub tracking: Tracking,
}

/// What came of each law.
#[derive(Clone, Debug)]
pub struct Runs {
    /// Of all.
    pub gains: Gains,
    /// Those that held the arm.
    pub runs: Vec<Run>,
    /// Names of the others, and when the arm ran away \[s\].
    pub ran_away: Vec<(String, f64)>,
}

/// Lets each law, once, drive the plant along the same desired motion with the same gains, in
/// parallel.
///
/// - `perfect`: whether controllers 1 and 2 also run with perfect knowledge of the plant
/// - `bandwidth`: of the gains \[rad/s\], which are made for `known`
///
/// # Errors
/// Those of [`mean_inertia`], and of [`track`] of the first law that has one; an arm that runs away
/// is an error only if it does so under every law.
pub fn compare(
    plant: &Plant,
    known: &dyn Knowledge,
    (laws, perfect): (&[Law], bool),
    bandwidth: f64,
    wanted: &Motion,
) -> Result<Runs> {
    let gains = Gains::critically_damped(bandwidth, &mean_inertia(known, wanted)?);
    plant.check()?;
    let mut ways: Vec<(Law, &str, &dyn Knowledge)> = Vec::new();
    for &law in laws {
        if ways.iter().all(|way| way.0 != law) {
            ways.push((law, "", known));
        }
    }
    if perfect {
        ways.extend([Law::Controller1, Law::Controller2].map(|law| (law, "_perfect", plant as _)));
    }
    let run =
        |&(law, _, known): &(Law, _, &dyn Knowledge)| track(plant, law, known, &gains, wanted);
    let done: Vec<Result<Tracking>> = ways.par_iter().map(run).collect();
    let (mut runs, mut ran_away) = (Vec::new(), Vec::new());
    for ((law, suffix, _), done) in ways.into_iter().zip(done) {
        let name = format!("{}{suffix}", law.name());
        match done {
            Err(SimError::Diverged { t }) => ran_away.push((name, t)),
            done => runs.push(Run { name, law, tracking: done? }),
        }
    }
    match ran_away.first() {
        Some(&(_, t)) if runs.is_empty() => Err(SimError::Diverged { t }),
        _ => Ok(Runs { gains, runs, ran_away }),
    }
}

impl Tracking {
    /// RMS of the position error from a time \[s\] on, of each joint \[rad\], n.
    pub fn rms_error(&self, from: f64) -> Vec<f64> {
        self.rms(&self.error, from)
    }

    /// Largest position error from a time \[s\] on, of each joint \[rad\], n.
    pub fn peak_error(&self, from: f64) -> Vec<f64> {
        let column = |joint| self.error.col_as_slice(joint)[self.first(from)..].iter();
        let peak = |joint| column(joint).fold(0.0_f64, |peak, e| peak.max(e.abs()));
        (0..self.error.ncols()).map(peak).collect()
    }

    /// RMS of the torque of the hand from a time \[s\] on \[N·m\], n.
    pub fn rms_hand(&self, from: f64) -> Vec<f64> {
        self.rms(&self.hand, from)
    }

    fn rms(&self, x: &Mat<f64>, from: f64) -> Vec<f64> {
        let first = self.first(from);
        let of = |joint| {
            let rows = &x.col_as_slice(joint)[first..];
            (rows.iter().map(|x| x * x).sum::<f64>() / rows.len().max(1) as f64).sqrt()
        };
        (0..x.ncols()).map(of).collect()
    }

    fn first(&self, from: f64) -> usize {
        self.t.partition_point(|t| *t < from)
    }
}
