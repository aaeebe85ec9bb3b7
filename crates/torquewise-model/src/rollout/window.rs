//! Windows of a trajectory, simulated from a measured state with the measured torque.

use super::Moving;
use crate::{Model, ModelError, Torque};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use torquewise_motion::{LARGEST, Path, ReadError, Recording};

/// Longest step \[s\].
const STEP: f64 = 1e-3;
/// Windows of a trajectory at most.
const WINDOWS: usize = 200;
/// Rows farther apart than so many usual steps are not of one window.
const GAP: f64 = 1.5;

/// Rows of one trajectory without gaps.
#[derive(Default)]
struct Rows {
    t: Vec<f64>,
    q: Vec<Vec<f64>>,
    dq: Vec<Vec<f64>>,
    tau: Vec<Vec<f64>>,
    /// What a model leaves of the torque, where that is asked.
    left: Vec<Vec<f64>>,
}

impl Rows {
    /// A signal at a time after a row, on the line to the next.
    fn between(&self, x: &[Vec<f64>], row: usize, t: f64) -> Vec<f64> {
        let Some(next) = x.get(row + 1) else { return x[row].clone() };
        let share = (t - self.t[row]) / (self.t[row + 1] - self.t[row]);
        x[row].iter().zip(next).map(|(a, b)| a + share * (b - a)).collect()
    }

    /// What the line from a row to the next misses of the mean torque \[N·m\], n, if a torque that
    /// jumps between them does so later than in the middle, by some part of the time between them.
    ///
    /// A torque bends to one side before a jump and to the other after it.
    fn missed(&self, row: usize, late: f64) -> Vec<f64> {
        let Some([a, b, c, d]) =
            row.checked_sub(1).and_then(|first| self.tau.get(first..first + 4))
        else {
            return vec![0.0; self.tau[row].len()];
        };
        let of = |j: usize| {
            let (before, after) = (a[j] - 2.0 * b[j] + c[j], b[j] - 2.0 * c[j] + d[j]);
            let jump = if before * after < 0.0 { before.abs().min(after.abs()) } else { 0.0 };
            -late * jump.copysign(before)
        };
        (0..a.len()).map(of).collect()
    }

    /// The last row at a time or before, from a row on.
    fn before(&self, mut row: usize, t: f64) -> usize {
        while row + 2 < self.t.len() && self.t[row + 1] <= t {
            row += 1;
        }
        row
    }

    /// Windows of some length \[s\].
    fn windows(&self, mut path: Path, longest: f64) -> Vec<Window<'_>> {
        let [first, .., last] = self.t[..] else { return Vec::new() };
        let apart = (0.5 * longest).max((last - first - longest) / WINDOWS as f64);
        let (mut windows, mut next) = (Vec::new(), first);
        for (row, q) in self.q.iter().enumerate() {
            path.step(q);
            if self.t[row] >= next && self.t[row] + longest <= last {
                windows.push(Window { rows: self, path: path.clone(), first: row });
                next = self.t[row] + apart;
            }
        }
        windows
    }

    /// Whether a row goes on after those that are here.
    fn goes_on(&self, t: f64) -> bool {
        match self.t[..] {
            [] => true,
            [before] => t > before,
            [first, second, ..] => {
                let since = t - self.t[self.t.len() - 1];
                since > 0.0 && since < GAP * (second - first)
            }
        }
    }
}

/// A stretch of a trajectory that can be simulated: from a measured state on, with measured torque.
pub struct Window<'r> {
    rows: &'r Rows,
    path: Path,
    /// The row that it begins with.
    pub(super) first: usize,
}

/// What is shown each step of a simulation: the arm after it, and how long it took \[s\].
pub type SeeStep<'s> = dyn FnMut(&Moving, f64) + 's;

impl Window<'_> {
    /// Where it leads at each horizon \[s\], ascending; q, n each.
    ///
    /// # Errors
    /// As [`Torque::step`].
    pub fn simulated(
        &self,
        torque: &Torque,
        horizons: &[f64],
        see: &mut SeeStep<'_>,
    ) -> Result<Vec<Vec<f64>>, ModelError> {
        let start = [&self.rows.q, &self.rows.dq].map(|rows| rows[self.first].clone());
        let nothing = vec![0.0; self.rows.q[self.first].len()];
        self.moved(torque, start, horizons, (&mut |_| nothing.clone(), see))
    }

    /// Where it seems to lead if measured states have noise, torques jump at any instant between two
    /// rows, and the torque misses what it misses at some other time of the trajectory: noise, and what
    /// no model holds, as long as they last.
    pub(super) fn other(
        &self,
        torque: &Torque,
        noise: &[Vec<f64>; 2],
        horizons: &[f64],
        random: &mut ChaCha8Rng,
    ) -> Result<Vec<Vec<f64>>, ModelError> {
        let noisy = |x: &[f64], deviations: &[f64], random: &mut ChaCha8Rng| -> Vec<f64> {
            let with_noise = |(x, deviation): (&f64, &f64)| {
                let unit: f64 = StandardNormal.sample(random);
                x + deviation * unit
            };
            x.iter().zip(deviations).map(with_noise).collect()
        };
        let start = [(&self.rows.q, &noise[0]), (&self.rows.dq, &noise[1])];
        let start = start.map(|(rows, noise)| noisy(&rows[self.first], noise, random));
        let Rows { left, .. } = self.rows;
        let later = random.random_range(0..left.len());
        let mut missed = |row: usize| {
            let jump = self.rows.missed(row, random.random_range(-0.5..0.5));
            let left = &left[(row + later) % left.len()];
            jump.iter().zip(left).map(|(jump, left)| jump - left).collect()
        };
        let ends = self.moved(torque, start, horizons, (&mut missed, &mut |_, _| ()))?;
        Ok(ends.iter().map(|q| noisy(q, &noise[0], random)).collect())
    }

    /// - `missed`: what the line from a row to the next misses of the mean torque \[N·m\], n
    fn moved(
        &self,
        torque: &Torque,
        [q, dq]: [Vec<f64>; 2],
        horizons: &[f64],
        (missed, see): (&mut dyn FnMut(usize) -> Vec<f64>, &mut SeeStep<'_>),
    ) -> Result<Vec<Vec<f64>>, ModelError> {
        let Self { rows, path, first } = self;
        let mut path = path.clone();
        path.step(&q);
        let mut arm = Moving { path, ddq: vec![0.0; dq.len()], dq };
        let (mut row, mut t) = (*first, rows.t[*first]);
        let mut off = missed(row);
        let mut reached = Vec::new();
        for horizon in horizons {
            let end = rows.t[*first] + horizon;
            while t < end - 0.01 * STEP {
                let seconds = STEP.min(end - t);
                let middle = t + 0.5 * seconds;
                let now = rows.before(row, middle);
                if now > row {
                    row = now;
                    off = missed(row);
                }
                let mut tau = rows.between(&rows.tau, row, middle);
                tau.iter_mut().zip(&off).for_each(|(tau, off)| *tau += off);
                torque.step(&mut arm, &tau, seconds)?;
                see(&arm, seconds);
                t += seconds;
            }
            reached.push(arm.path.q().to_vec());
        }
        Ok(reached)
    }

    /// Where the arm was after some time \[s\]; q, n.
    pub fn measured(&self, after: f64) -> Vec<f64> {
        let t = self.rows.t[self.first] + after;
        self.rows.between(&self.rows.q, self.rows.before(self.first, t), t)
    }

    /// Whether a simulated joint was faster than any is, or ends at no number.
    pub(super) fn ran_away(&self, end: &[f64], after: f64) -> bool {
        let may_be = |(end, start): (&f64, &f64)| (end - start).abs() <= LARGEST[1] * after;
        !end.iter().zip(&self.rows.q[self.first]).all(may_be)
    }

    /// Where it would be at the velocity that it had; q, n.
    pub(super) fn held(&self, after: f64) -> Vec<f64> {
        let state = self.rows.q[self.first].iter().zip(&self.rows.dq[self.first]);
        state.map(|(q, dq)| q + after * dq).collect()
    }
}

/// Hands over windows all over a recording, those of a stretch without gaps together; they begin
/// half their length apart or more.
///
/// - `longest`: their length \[s\]
/// - `left_by`: whose torque is taken from the measured one, where drifts of other arms are asked
///
/// # Errors
/// The reader's message; [`ModelError`] if the recording is of another arm or without torque.
pub fn windows(
    model: &Model,
    recording: &(impl Recording + ?Sized),
    (longest, left_by): (f64, Option<&Torque>),
    take: &mut dyn FnMut(&[Window<'_>]) -> Result<(), ReadError>,
) -> Result<(), ReadError> {
    model.check_joints(recording.joints())?;
    let path = Torque::new(model).path();
    let mut followed = path.clone();
    let (mut rows, mut own) = (Rows::default(), None);
    recording.read(&mut |trajectory, block| {
        let tau = block.require_tau()?;
        let predicted = left_by.map(|torque| torque.over(&followed.follow(trajectory, block)));
        let left = predicted.transpose()?.map(|predicted| tau - predicted);
        for row in 0..block.n_rows() {
            if own != Some(trajectory) || !rows.goes_on(block.t()[row]) {
                take(&std::mem::take(&mut rows).windows(path.clone(), longest))?;
                own = Some(trajectory);
            }
            let of = |x: faer::MatRef<'_, f64>| x.row(row).iter().copied().collect::<Vec<f64>>();
            rows.tau.push(of(tau));
            rows.left.extend(left.as_ref().map(|left| of(left.as_ref())));
            rows.t.push(block.t()[row]);
            rows.q.push(of(block.q()));
            rows.dq.push(of(block.dq()));
        }
        Ok(())
    })?;
    take(&rows.windows(path, longest))
}
