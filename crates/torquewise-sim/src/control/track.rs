//! The closed loop at a fixed rate.

use crate::control::controller::{Controller, Law};
use crate::control::gains::Gains;
use crate::control::knowledge::Knowledge;
use crate::control::moving::Moving;
use crate::control::plant::Plant;
use crate::error::Result;
use crate::state::State;
use faer::Mat;
use torquewise_motion::Motion;

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
    let mut controller = Controller::new(law, known, gains, plant, wanted)?;
    let hand = (law == Law::HandGuiding).then_some(gains);
    let (m, n) = (wanted.n_rows(), plant.arm.n_joints());
    let first = State::of(wanted, 0);
    let mut moving = Moving::new(plant, &first.q, &first.dq)?;
    let [mut q, mut dq, mut error, mut tau, mut led] = std::array::from_fn(|_| Mat::zeros(m, n));
    let mut saturated = vec![0.0; n];
    for row in 0..m {
        let target = State::of(wanted, row);
        let measured = moving.measured();
        let command = controller.command(&target, &measured)?;
        let pull: Vec<f64> = (0..n)
            .map(|i| {
                hand.map_or(0.0, |hand| {
                    let [e, de] = [target.q[i] - moving.q()[i], target.dq[i] - moving.dq()[i]];
                    hand.proportional[i] * e + hand.derivative[i] * de
                })
            })
            .collect();
        for i in 0..n {
            q[(row, i)] = moving.q()[i];
            dq[(row, i)] = moving.dq()[i];
            error[(row, i)] = target.q[i] - moving.q()[i];
            tau[(row, i)] = command[i];
            led[(row, i)] = pull[i];
            saturated[i] += f64::from(u8::from(command[i].abs() >= plant.drive.limit[i]));
        }
        if row + 1 < m {
            moving.hold(command, &pull, controller.period)?;
        }
    }
    let saturated = saturated.into_iter().map(|ticks| ticks / m as f64).collect();
    let t = wanted.t().iter().map(|t| t - wanted.t()[0]).collect();
    Ok(Tracking { t, q, dq, error, tau, hand: led, saturated })
}

/// Lets each law drive the plant along the same desired motion with the same gains, each on a
/// thread of its own.
///
/// # Errors
/// Those of [`track`], of the first law that has one.
pub fn compare(
    plant: &Plant,
    known: &dyn Knowledge,
    laws: &[Law],
    gains: &Gains,
    wanted: &Motion,
) -> Result<Vec<Tracking>> {
    plant.check()?;
    let run = |law: Law| track(plant, law, known, gains, wanted);
    std::thread::scope(|scope| {
        let running: Vec<_> = laws.iter().map(|&law| scope.spawn(move || run(law))).collect();
        let done = running
            .into_iter()
            .map(|thread| thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        done.collect()
    })
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
