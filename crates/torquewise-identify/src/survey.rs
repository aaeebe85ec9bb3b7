//! Recording → survey: one look at the whole log, and an even sample of it, in fixed memory.

use crate::error::IdentifyError;
use crate::noise::{NoiseFloor, NoiseSum};
use faer::Mat;
use torquewise_model::Training;
use torquewise_motion::{Motion, Recording, Signals};

/// What one pass over a log tells.
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
    /// The white noise in its signals.
    pub noise: NoiseFloor,
    /// Every k-th row, k a power of two, at most [`SAMPLE_ROWS`] of them.
    pub sample: Motion,
}

/// Rows of a sample at most: enough for quantiles and clusters, few enough for any log.
pub const SAMPLE_ROWS: usize = 1 << 14;

/// Looks through a recording once.
///
/// # Errors
/// [`IdentifyError::Read`] with the reader's message, or [`IdentifyError::Motion`] if the log has
/// no joints.
pub fn survey(recording: &(impl Recording + ?Sized)) -> Result<Survey, IdentifyError> {
    let mut look = Look::new(recording.joints());
    recording
        .read(&mut |trajectory, block| {
            look.add(trajectory, block);
            Ok(())
        })
        .map_err(IdentifyError::Read)?;
    look.finish()
}

struct Look {
    joints: Vec<String>,
    rows: usize,
    trajectory: Option<usize>,
    trajectories: usize,
    seconds: f64,
    last_time: f64,
    q_range: Vec<[f64; 2]>,
    peaks: [Vec<f64>; 2],
    /// First torque, sums of differences to it and of their squares: no digits lost to a large
    /// mean.
    torque: Vec<[f64; 3]>,
    has_torque: bool,
    noise: NoiseSum,
    stride: usize,
    /// t q₁…qₙ dq₁… ddq₁… tau₁… of each sampled row.
    sampled: Vec<Vec<f64>>,
}

impl Look {
    fn new(joints: &[String]) -> Self {
        let n = joints.len();
        Self {
            joints: joints.to_vec(),
            rows: 0,
            trajectory: None,
            trajectories: 0,
            seconds: 0.0,
            last_time: 0.0,
            q_range: vec![[f64::INFINITY, f64::NEG_INFINITY]; n],
            peaks: [vec![0.0; n], vec![0.0; n]],
            torque: vec![[0.0; 3]; n],
            has_torque: true,
            noise: NoiseSum::new(n),
            stride: 1,
            sampled: Vec::new(),
        }
    }

    fn add(&mut self, trajectory: usize, block: &Motion) {
        if self.trajectory != Some(trajectory) {
            self.trajectory = Some(trajectory);
            self.trajectories += 1;
            self.last_time = block.t().first().copied().unwrap_or_default();
        }
        if let Some(&end) = block.t().last() {
            self.seconds += end - self.last_time;
            self.last_time = end;
        }
        self.noise.add(block, |_| true);
        for joint in 0..self.joints.len() {
            self.add_joint(block, joint);
        }
        for row in 0..block.n_rows() {
            if (self.rows + row).is_multiple_of(self.stride) {
                self.sampled.push(row_of(block, row));
            }
            if self.sampled.len() > SAMPLE_ROWS {
                self.thin();
            }
        }
        self.rows += block.n_rows();
    }

    fn add_joint(&mut self, block: &Motion, joint: usize) {
        for &q in block.q().col(joint).iter() {
            let [low, high] = &mut self.q_range[joint];
            (*low, *high) = (low.min(q), high.max(q));
        }
        for (peaks, rates) in self.peaks.iter_mut().zip([block.dq(), block.ddq()]) {
            let peak = rates.col(joint).iter().fold(0.0_f64, |peak, rate| peak.max(rate.abs()));
            peaks[joint] = peaks[joint].max(peak);
        }
        let Some(tau) = block.tau() else {
            self.has_torque = false;
            return;
        };
        let [first, sum, squares] = &mut self.torque[joint];
        if self.rows == 0 {
            *first = tau.col(joint).iter().next().copied().unwrap_or_default();
        }
        for &tau in tau.col(joint).iter() {
            *sum += tau - *first;
            *squares += (tau - *first).powi(2);
        }
    }

    /// Keeps every second sampled row, and half as many from now on.
    fn thin(&mut self) {
        self.stride *= 2;
        let mut place = 0_usize;
        self.sampled.retain(|_| {
            place += 1;
            place % 2 == 1
        });
    }

    fn finish(self) -> Result<Survey, IdentifyError> {
        let m = self.rows.max(1) as f64;
        let moments = |&[first, sum, squares]: &[f64; 3]| {
            (first + sum / m, (squares / m - (sum / m).powi(2)).max(0.0).sqrt())
        };
        let (torque_mean, torque_std) = self.torque.iter().map(moments).unzip();
        let n = self.joints.len();
        let signal = |first: usize| {
            Mat::from_fn(self.sampled.len(), n, |row, joint| {
                self.sampled[row][1 + first * n + joint]
            })
        };
        let sample = Motion::new(Signals {
            joints: self.joints.clone(),
            t: self.sampled.iter().map(|row| row[0]).collect(),
            q: signal(0),
            dq: signal(1),
            ddq: signal(2),
            tau: self.has_torque.then(|| signal(3)),
        })?;
        let [dq_peak, ddq_peak] = self.peaks;
        Ok(Survey {
            joints: self.joints,
            rows: self.rows,
            trajectories: self.trajectories,
            seconds: self.seconds,
            q_range: self.q_range,
            dq_peak,
            ddq_peak,
            torque_mean,
            torque_std,
            noise: self.noise.finish(),
            sample,
        })
    }
}

/// At most `count` rows, evenly spread.
pub(crate) fn thinned(motion: &Motion, count: usize) -> Motion {
    let m = motion.n_rows();
    if m <= count {
        return motion.clone();
    }
    motion.select(&(0..count).map(|k| k * m / count).collect::<Vec<_>>())
}

fn row_of(block: &Motion, row: usize) -> Vec<f64> {
    let signals = [Some(block.q()), Some(block.dq()), Some(block.ddq()), block.tau()];
    let values = signals
        .into_iter()
        .flatten()
        .flat_map(|x| (0..x.ncols()).map(move |joint| x[(row, joint)]));
    std::iter::once(block.t()[row]).chain(values).collect()
}

impl Survey {
    /// What a model keeps of the log it was fitted on; `residual_rms`: what it leaves of the torque
    /// of each joint \[N·m\], n.
    pub(crate) fn training(&self, residual_rms: Vec<f64>) -> Training {
        Training {
            rows: self.rows,
            residual_rms,
            torque_std: self.torque_std.clone(),
            q_range: self.q_range.clone(),
            dq_peak: self.dq_peak.clone(),
            ddq_peak: self.ddq_peak.clone(),
        }
    }

    /// Rows per second within trajectories \[Hz\]; zero for a single row.
    pub fn rate(&self) -> f64 {
        let steps = self.rows.saturating_sub(self.trajectories);
        if self.seconds > 0.0 { steps as f64 / self.seconds } else { 0.0 }
    }

    /// Joints whose position never changes.
    pub fn constant_joints(&self) -> Vec<usize> {
        let still = |joint: &usize| self.q_range[*joint][0] >= self.q_range[*joint][1];
        (0..self.joints.len()).filter(still).collect()
    }
}
