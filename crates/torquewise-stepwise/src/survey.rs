//! One look at the whole log, and an even sample of it, in fixed memory.

use crate::noise::NoiseSum;
use crate::systematic_sample::SystematicSample;
use crate::{Digests, IdentifyError, NoiseFloor};
use faer::{Mat, MatRef};
use serde::{Deserialize, Serialize};
use torquewise_model::Training;
use torquewise_motion::motion::Memory;
use torquewise_motion::path::TRAVELS;
use torquewise_motion::{Motion, Path, Recording, Signals};
use torquewise_regression::SparseError;
use torquewise_regression::exact::ExactSums;
use torquewise_rigid::rows::{evenly, spread_above_rounding};

/// What one pass over a log finds.
#[derive(Clone, Debug)]
pub struct Survey {
    /// Joint names, base to tip, n.
    pub joints: Vec<String>,
    /// Rows m.
    pub rows: usize,
    /// Trajectories.
    pub trajectories: usize,
    /// Recorded time \[s\], the gaps between trajectories left out.
    pub seconds: f64,
    /// Least and greatest position of each joint \[rad\], n.
    pub q_range: Vec<[f64; 2]>,
    /// Largest speed of each joint \[rad/s\], n.
    pub dq_peak: Vec<f64>,
    /// Largest acceleration of each joint \[rad/s²\], n.
    pub ddq_peak: Vec<f64>,
    /// Mean torque of each joint \[N·m\], n.
    pub torque_mean: Vec<f64>,
    /// Standard deviation of the torque of each joint \[N·m\], n.
    pub torque_std: Vec<f64>,
    /// RMS of what a filter took from the torque of each joint \[N·m\], n.
    pub removed_rms: Vec<f64>,
    /// Digests of its trajectories.
    pub digests: Vec<u32>,
    /// The white noise in its signals.
    pub noise: NoiseFloor,
    /// Every k-th row of each log, k a power of two, at most [`SAMPLE_ROWS`] of them.
    pub sample: Motion,
}

/// Rows of a sample at most: enough for quantiles and clusters, few enough for any log.
pub const SAMPLE_ROWS: usize = 1 << 14;
/// q, q̇, q̈, τ, and what a filter took from τ.
const SIGNALS: usize = 5;

/// From here on a number, in SI units, is that of a damaged file, not of an arm.
const LARGEST: f64 = 1e9;

impl Survey {
    /// Fails at the first joint with a number that no arm has.
    ///
    /// - `largest`: position \[rad, m\]; infinite where units are not asked about
    ///
    /// # Errors
    /// [`IdentifyError::NoMotion`].
    pub fn check_size(&self, largest: f64) -> Result<(), IdentifyError> {
        let most = |signal: &str| if signal == "q" { largest.min(LARGEST) } else { LARGEST };
        let is_beyond =
            |(signal, found): &(&str, f64)| found.is_nan() || found.abs() >= most(signal);
        for (k, joint) in self.joints.iter().enumerate() {
            let [low, high] = self.q_range[k];
            let tau = self.torque_mean[k].hypot(self.torque_std[k]);
            let all = [("q", low), ("q", high), ("dq", self.dq_peak[k]), ("ddq", self.ddq_peak[k])];
            let mut all = all.into_iter().chain([("tau", tau)]);
            if let Some((signal, found)) = all.find(is_beyond) {
                return Err(IdentifyError::NoMotion { signal, joint: joint.clone(), found });
            }
        }
        Ok(())
    }

    /// What a model keeps of the log it was fitted on; `residual_rms`: what it leaves of the torque
    /// of each joint \[N·m\], n.
    pub fn training(&self, residual_rms: Vec<f64>) -> Training {
        Training {
            rows: self.rows,
            digests: self.digests.clone(),
            residual_rms,
            torque_std: self.torque_std.clone(),
            q_range: self.q_range.clone(),
            dq_peak: self.dq_peak.clone(),
            ddq_peak: self.ddq_peak.clone(),
            ..Training::default()
        }
    }

    /// Rows per second within trajectories \[Hz\]; zero for a single row.
    pub fn rate(&self) -> f64 {
        let steps = self.rows.saturating_sub(self.trajectories);
        if self.seconds > 0.0 { steps as f64 / self.seconds } else { 0.0 }
    }

    /// How far a joint moves \[rad or m\].
    pub fn range(&self, joint: usize) -> f64 {
        let [low, high] = self.q_range[joint];
        high - low
    }

    /// Joints whose position never changes, but for quanta of an encoder.
    pub fn constant_joints(&self) -> Vec<usize> {
        Training::constant_joints(&self.q_range)
    }

    /// Whether no joint moves.
    pub fn stands_still(&self) -> bool {
        self.constant_joints().len() == self.joints.len()
    }
}

/// Looks through a recording once, as if it were one log.
///
/// # Errors
/// [`IdentifyError::Read`] with the reader's message, or [`IdentifyError::Motion`] if the log has
/// no joints.
pub fn survey(recording: &(impl Recording + ?Sized)) -> Result<Survey, IdentifyError> {
    let mut look = SurveySum::new(recording.joints());
    recording
        .read(&mut |trajectory, block| Ok(look.add(trajectory, block)?))
        .map_err(IdentifyError::Read)?;
    look.finish()
}

/// Partial survey: a mergeable accumulator, the same in any order of logs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SurveySum {
    joints: Vec<String>,
    rows: usize,
    trajectories: usize,
    /// Largest −q of each joint, then q, |q̇| and |q̈|.
    largest: [Vec<f64>; 4],
    /// Time, then torques and squared torques of each joint, then squares of what a filter took
    /// from them.
    sums: ExactSums,
    has_torque: bool,
    digests: Digests,
    noise: NoiseSum,
    /// t q₁…qₙ dq₁… ddq₁… tau₁… of each sampled row, what a filter took from tau, then what friction
    /// remembers there.
    sampled: SystematicSample,
    /// What friction remembers of the path.
    #[serde(skip)]
    path: Option<Path>,
    /// The trajectory of the last row, and its time.
    #[serde(skip)]
    last: Option<(usize, f64)>,
}

impl SurveySum {
    /// Nothing yet of logs of these joints.
    pub fn new(joints: &[String]) -> Self {
        let n = joints.len();
        Self {
            joints: joints.to_vec(),
            rows: 0,
            trajectories: 0,
            largest: [f64::NEG_INFINITY, f64::NEG_INFINITY, 0.0, 0.0].map(|x| vec![x; n]),
            sums: ExactSums::zeros(1 + 3 * n),
            has_torque: true,
            digests: Digests::default(),
            noise: NoiseSum::new(n),
            sampled: SystematicSample::new(width(n), SAMPLE_ROWS),
            path: None,
            last: None,
        }
    }

    /// Joint names.
    pub fn joints(&self) -> &[String] {
        &self.joints
    }

    /// Rows seen.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Adds the next block of a log.
    ///
    /// # Errors
    /// [`SparseError`] if its numbers are too large to be summed.
    pub fn add(&mut self, trajectory: usize, block: &Motion) -> Result<(), SparseError> {
        let (Some(&start), Some(&end)) = (block.t().first(), block.t().last()) else {
            return Ok(());
        };
        let same = self.last.filter(|(last, _)| *last == trajectory);
        self.trajectories += usize::from(same.is_none());
        self.sums.add(0, &[end - same.map_or(start, |(_, time)| time)])?;
        self.last = Some((trajectory, end));
        self.digests.add(trajectory, block);
        self.noise.add(block, |_| true);
        for joint in 0..self.joints.len() {
            self.add_joint(block, joint)?;
        }
        let n = self.joints.len();
        let path = self.path.get_or_insert_with(|| Path::new(n, &TRAVELS));
        let block = path.follow(trajectory, block);
        for row in 0..block.n_rows() {
            self.sampled.push((self.rows + row) as u64, || row_of(&block, row));
        }
        self.rows += block.n_rows();
        Ok(())
    }

    fn add_joint(&mut self, block: &Motion, joint: usize) -> Result<(), SparseError> {
        let signals = [block.q(), block.q(), block.dq(), block.ddq()];
        for (place, (largest, signal)) in self.largest.iter_mut().zip(signals).enumerate() {
            let size = |x: f64| match place {
                0 => -x,
                1 => x,
                _ => x.abs(),
            };
            let values = signal.col(joint).iter();
            largest[joint] = values.fold(largest[joint], |most, &x| most.max(size(x)));
        }
        let Some(tau) = block.tau() else {
            self.has_torque = false;
            return Ok(());
        };
        for &tau in tau.col(joint).iter() {
            // The square without rounding, so that no digit is lost to a large mean.
            let square = tau * tau;
            self.sums.add(1 + 2 * joint, &[tau, square])?;
            self.sums.add(2 + 2 * joint, &[tau.mul_add(tau, -square)])?;
        }
        let place = 1 + 2 * self.joints.len() + joint;
        let removed = block.removed_tau().map(|removed| removed.col(joint).squared_norm_l2());
        self.sums.add(place, &[removed.unwrap_or(0.0)])
    }

    /// Adds other logs of the same joints.
    ///
    /// # Errors
    /// As [`Self::add`].
    pub fn merge(&mut self, other: &Self) -> Result<(), SparseError> {
        self.sums.merge(&other.sums)?;
        self.rows += other.rows;
        self.trajectories += other.trajectories;
        for (own, more) in self.largest.iter_mut().zip(&other.largest) {
            own.iter_mut().zip(more).for_each(|(most, other)| *most = most.max(*other));
        }
        self.has_torque &= other.has_torque;
        self.digests.merge(&other.digests);
        self.noise.merge(&other.noise);
        self.sampled.merge(&other.sampled);
        (self.last, self.path) = (None, None);
        Ok(())
    }

    /// Puts what it holds in an order of its own, whatever was merged first.
    pub fn sort(&mut self) {
        self.digests.close();
        self.noise.sort();
        self.sampled.sort();
        (self.last, self.path) = (None, None);
    }

    /// Whether its parts fit each other.
    pub fn is_sound(&self) -> bool {
        let n = self.joints.len();
        n > 0
            && self.largest.iter().all(|largest| largest.len() == n)
            && self.largest[2..].iter().all(|peaks| peaks.iter().all(|peak| peak.is_finite()))
            && self.sums.count() == 1 + 3 * n
            && self.noise.is_sound(n)
            && self.sampled.is_sound(width(n), SAMPLE_ROWS)
    }

    /// What was found in the logs.
    ///
    /// # Errors
    /// [`IdentifyError::Motion`] if there are no joints.
    pub fn finish(&self) -> Result<Survey, IdentifyError> {
        let n = self.joints.len();
        let rows: Vec<&[f64]> = self.sampled.records().collect();
        let columns = |first: usize, count: usize| {
            Mat::from_fn(rows.len(), count, |row, k| rows[row][first + k])
        };
        let [q, dq, ddq, tau, removed] = std::array::from_fn(|signal| columns(1 + signal * n, n));
        let (t, tau) = (rows.iter().map(|row| row[0]).collect(), self.has_torque.then_some(tau));
        let states = columns(1 + SIGNALS * n, TRAVELS.len() * n);
        let memory = Memory::new(TRAVELS.to_vec(), states);
        let joints = self.joints.clone();
        let sample = Motion::new(Signals { joints, t, q, dq, ddq, tau })?;
        let sample = sample.with_memory(Some(memory)).with_removed_tau(Some(removed));
        let (torque_mean, torque_std) = (0..n).map(|joint| self.torque(joint)).unzip();
        let removed = |joint| self.sums.value(1 + 2 * n + joint) / self.rows.max(1) as f64;
        let [low, high, dq_peak, ddq_peak] = self.largest.clone();
        Ok(Survey {
            joints: self.joints.clone(),
            rows: self.rows,
            trajectories: self.trajectories,
            seconds: self.sums.value(0),
            q_range: low.into_iter().zip(high).map(|(low, high)| [-low, high]).collect(),
            dq_peak,
            ddq_peak,
            torque_mean,
            torque_std,
            removed_rms: (0..n).map(|joint| removed(joint).sqrt()).collect(),
            digests: self.digests.least(),
            noise: self.noise.finish(),
            sample,
        })
    }

    /// Mean and standard deviation, zero where it is rounding.
    fn torque(&self, joint: usize) -> (f64, f64) {
        let m = self.rows.max(1) as f64;
        let ([sum, sum_rest], [squares, squares_rest]) =
            (self.sums.pair(1 + 2 * joint), self.sums.pair(2 + 2 * joint));
        let mean = sum / m;
        // Στ² − mean·Στ, each product and difference with its rounding.
        let product = mean * sum;
        let product_rest = mean.mul_add(sum, -product) + mean * sum_rest;
        let difference = (squares - product) + (squares_rest - product_rest);
        (mean, spread_above_rounding((difference / m).max(0.0).sqrt(), mean))
    }
}

/// At most `count` rows, evenly spread.
pub fn thinned(motion: &Motion, count: usize) -> Motion {
    motion.select(&evenly(motion.n_rows(), count))
}

/// Numbers of a sampled row.
fn width(n: usize) -> usize {
    1 + (SIGNALS + TRAVELS.len()) * n
}

fn row_of(block: &Motion, row: usize) -> Vec<f64> {
    let states = [block.q(), block.dq(), block.ddq()].map(Some);
    let signals = states.into_iter().chain([block.tau(), block.removed_tau()]);
    let value = |signal: Option<MatRef<'_, f64>>, joint| signal.map_or(0.0, |x| x[(row, joint)]);
    let joints = 0..block.n_joints();
    let values = signals.flat_map(|x| joints.clone().map(move |joint| value(x, joint)));
    let memory = block.memory().into_iter().flat_map(|memory| memory.row(row));
    std::iter::once(block.t()[row]).chain(values).chain(memory).collect()
}
