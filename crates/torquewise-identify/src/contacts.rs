//! From external torque to contacts: when it is more than a free arm shows (E16).

use serde::Serialize;
use torquewise_model::Model;
use torquewise_model::momentum_observer::MomentumObserver;
use torquewise_motion::{ReadError, Recording};
use torquewise_stepwise::error::IdentifyError;

/// External torque of a joint beyond which it is taken for a contact.
///
/// The peaks of a free arm beyond a level of their own are taken to fall off exponentially, which
/// no tail of a model's error is known to exceed much: the threshold is where the stated number of
/// them is left in an hour.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Thresholds {
    /// \[N·m\], n.
    pub torque: Vec<f64>,
    /// False alarms of the whole arm in an hour that they are set for.
    pub false_alarms_per_hour: f64,
    /// Time of free motion that they come from \[s\].
    pub seconds: f64,
}

/// A time during which the external torque of a joint is beyond its threshold.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Contact {
    /// When it is first beyond \[s\], by the clock of the log.
    pub begin: f64,
    /// When it is last beyond \[s\].
    pub end: f64,
    /// Joint that is beyond by the largest factor.
    pub joint: String,
    /// Its largest external torque \[N·m\], with its sign.
    pub torque: f64,
    /// By what factor of its threshold.
    pub factor: f64,
}

/// Watches external torque for contacts.
#[derive(Clone, Debug)]
pub struct ContactDetector {
    joints: Vec<String>,
    thresholds: Vec<f64>,
    found: Vec<Contact>,
    is_open: bool,
}

/// What is done with each row: trajectory, time \[s\], external torque of each joint \[N·m\], n.
pub type SeeTorque<'a> = dyn FnMut(usize, f64, &[f64]) -> Result<(), ReadError> + 'a;

/// Peaks that are closer than this \[s\] are one.
const APART: f64 = 0.2;
/// Part of the rows of a free log below the level that peaks are counted from.
const LEVEL: f64 = 0.95;
/// Peaks that the tail is made of at most, and one in how many of all: those of a reversal of friction
/// are larger than all others, and few.
const TAIL: (usize, usize) = (100, 3);
/// Rows that the level is found from at most: more are thinned evenly.
const MOST_ROWS: usize = 65_536;
/// So many half-lives of an observer pass before it is believed.
const SETTLING: f64 = 5.0;

/// External torques of a recording, row by row; those of the first moments of a trajectory, while the
/// observer settles, are NaN.
///
/// - `bandwidth`: of the observer \[Hz\]
///
/// # Errors
/// [`IdentifyError`]: the reader's message, missing torque, or a model of another arm.
pub fn external_torques(
    model: &Model,
    recording: &(impl Recording + ?Sized),
    bandwidth: f64,
    see: &mut SeeTorque<'_>,
) -> Result<(), IdentifyError> {
    model.check_joints(recording.joints())?;
    let gain = std::f64::consts::TAU * bandwidth;
    let mut observer = MomentumObserver::new(model, gain);
    let mut last: Option<(usize, f64)> = None;
    let mut begin = 0.0;
    let settling = vec![f64::NAN; model.n_joints()];
    recording
        .read(&mut |trajectory, block| {
            let tau = block.require_tau()?;
            for (row, &t) in block.t().iter().enumerate() {
                let dt = match last {
                    Some((own, before)) if own == trajectory => t - before,
                    _ => {
                        observer.reset();
                        begin = t;
                        0.0
                    }
                };
                last = Some((trajectory, t));
                let [q, dq, tau] = [block.q(), block.dq(), tau]
                    .map(|x| x.row(row).iter().copied().collect::<Vec<f64>>());
                let external = observer.step(dt, [&q, &dq, &tau])?;
                let is_settled = t - begin > SETTLING / gain;
                see(trajectory, t, if is_settled { external } else { &settling })?;
            }
            Ok(())
        })
        .map_err(IdentifyError::Read)
}

impl Thresholds {
    /// The thresholds that free motion asks for.
    ///
    /// - `is_free`: whether nothing touched the arm; else contacts are taken to be fewer than half
    ///   of the peaks, whose median counts then, not their mean
    ///
    /// # Errors
    /// As [`external_torques`]; [`IdentifyError::TooFewRows`] if it is too short to tell.
    pub fn of_free_motion(
        model: &Model,
        free: &(impl Recording + ?Sized),
        (bandwidth, false_alarms_per_hour): (f64, f64),
        is_free: bool,
    ) -> Result<Self, IdentifyError> {
        let n = model.n_joints();
        // First the levels, from rows thinned evenly, then the peaks beyond them.
        let (mut sample, mut stride, mut rows) = (vec![Vec::new(); n], 1_usize, 0_usize);
        let (mut seconds, mut last) = (0.0, None);
        external_torques(model, free, bandwidth, &mut |trajectory, t, external| {
            if let Some((own, before)) = last
                && own == trajectory
            {
                seconds += t - before;
            }
            last = Some((trajectory, t));
            if external.iter().any(|x| x.is_nan()) {
                return Ok(());
            }
            if rows.is_multiple_of(stride) {
                sample.iter_mut().zip(external).for_each(|(own, x)| own.push(x.abs()));
            }
            rows += 1;
            if sample[0].len() > MOST_ROWS {
                for own in &mut sample {
                    let mut keep = false;
                    own.retain(|_| {
                        keep = !keep;
                        keep
                    });
                }
                stride *= 2;
            }
            Ok(())
        })?;
        let levels: Vec<f64> = sample.iter_mut().map(|own| quantile(own, LEVEL)).collect();
        let mut peaks = vec![Peaks::default(); n];
        external_torques(model, free, bandwidth, &mut |trajectory, t, external| {
            for ((own, level), x) in peaks.iter_mut().zip(&levels).zip(external) {
                own.take((trajectory, t), x.abs() - level);
            }
            Ok(())
        })?;
        let hours = seconds / 3_600.0;
        let own_rate = false_alarms_per_hour / n as f64;
        let threshold = |(peaks, level): (&mut Peaks, &f64)| {
            let (begin, count, mean) = peaks.tail(is_free);
            // Its own standard error, that few peaks may not promise too little.
            let mean = mean * (1.0 + 1.0 / count.sqrt());
            level + begin + mean * (count / hours / own_rate).ln().max(0.0)
        };
        if rows == 0 || hours <= 0.0 {
            return Err(IdentifyError::TooFewRows { rows, needed: 2, joints: n });
        }
        let torque = peaks.iter_mut().zip(&levels).map(threshold).collect();
        Ok(Self { torque, false_alarms_per_hour, seconds })
    }
}

/// Largest excess of each run beyond a level.
#[derive(Clone, Debug, Default)]
struct Peaks {
    /// Of runs that are over, thinned where they are many.
    excess: Vec<f64>,
    /// Runs that one of them stands for, less one.
    left_out: usize,
    skipped: usize,
    /// Trajectory, last time beyond, largest excess of the run.
    open: Option<(usize, f64, f64)>,
}

impl Peaks {
    fn take(&mut self, (trajectory, t): (usize, f64), excess: f64) {
        if excess.is_nan() || excess <= 0.0 {
            return;
        }
        self.open = Some(match self.open {
            Some((own, last, most)) if own == trajectory && t - last < APART => {
                (own, t, most.max(excess))
            }
            open => {
                if let Some((_, _, most)) = open {
                    self.push(most);
                }
                (trajectory, t, excess)
            }
        });
    }

    fn push(&mut self, excess: f64) {
        if self.skipped < self.left_out {
            self.skipped += 1;
            return;
        }
        self.skipped = 0;
        self.excess.push(excess);
        if self.excess.len() > MOST_ROWS {
            let mut place = 0_usize;
            self.excess.retain(|_| {
                place += 1;
                place % 2 == 1
            });
            self.left_out = 2 * self.left_out + 1;
        }
    }

    /// The exponential tail of the largest of them: the level that it begins at, how many were
    /// beyond, at least one, and their mean excess.
    fn tail(&mut self, is_free: bool) -> (f64, f64, f64) {
        if let Some((_, _, most)) = self.open.take() {
            self.push(most);
        }
        self.excess.sort_unstable_by(|a, b| b.total_cmp(a));
        let (most, part) = TAIL;
        let kept = (self.excess.len() / part).min(most);
        let level = self.excess.get(kept).copied().unwrap_or(0.0);
        let mut beyond: Vec<f64> = self.excess[..kept].iter().map(|x| x - level).collect();
        let mean = if is_free {
            beyond.iter().sum::<f64>() / (kept as f64).max(1.0)
        } else {
            quantile(&mut beyond, 0.5) / std::f64::consts::LN_2
        };
        (level, (kept * (self.left_out + 1)).max(1) as f64, mean)
    }
}

fn quantile(values: &mut [f64], part: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an index")]
    let place = ((values.len() - 1) as f64 * part) as usize;
    let (_, value, _) = values.select_nth_unstable_by(place, f64::total_cmp);
    *value
}

impl ContactDetector {
    /// A detector of the joints of a model.
    pub fn new(model: &Model, thresholds: &Thresholds) -> Self {
        let (joints, thresholds) = (model.joints.clone(), thresholds.torque.clone());
        Self { joints, thresholds, found: Vec::new(), is_open: false }
    }

    /// Takes the external torques at a time.
    pub fn take(&mut self, t: f64, external: &[f64]) {
        let factors = external.iter().zip(&self.thresholds).map(|(x, most)| x.abs() / most);
        let largest = factors.enumerate().filter(|(_, factor)| factor.is_finite());
        let Some((joint, factor)) = largest.max_by(|a, b| a.1.total_cmp(&b.1)) else { return };
        let is_beyond = factor > 1.0;
        let ends = self.found.last().map_or(f64::NEG_INFINITY, |contact| contact.end);
        self.is_open &= t >= ends && t - ends < APART;
        if !is_beyond {
            return;
        }
        let (name, torque) = (&self.joints[joint], external[joint]);
        match self.found.last_mut() {
            Some(contact) if self.is_open => {
                contact.end = t;
                if factor > contact.factor {
                    (contact.factor, contact.torque) = (factor, torque);
                    contact.joint.clone_from(name);
                }
            }
            _ => self.found.push(Contact { begin: t, end: t, joint: name.clone(), torque, factor }),
        }
        self.is_open = true;
    }

    /// Begins another trajectory.
    pub fn separate(&mut self) {
        self.is_open = false;
    }

    /// The contacts so far, in the order of time.
    pub fn contacts(&self) -> &[Contact] {
        &self.found
    }
}
