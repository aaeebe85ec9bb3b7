//! Contacts: external torque beyond that of free motion (E16).

mod held;
mod spread;

use crate::score;
use crate::score::JointScore;
use held::{held, held_at_rest};
use serde::Serialize;
use spread::{Follower, Spread};
use torquewise_model::momentum_observer::MomentumObserver;
use torquewise_model::{Model, Torque};
use torquewise_motion::{Motion, ReadError, Recording, quantile};
use torquewise_stepwise::IdentifyError;

/// External torque of a joint beyond which it is taken for a contact: a multiple of the spread that
/// free motion of the kind has.
///
/// The squares of peaks of a free arm beyond a level of their own are taken to fall off
/// exponentially, as those of a normal distribution do: the multiple is where the stated number of
/// them is left in an hour.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Thresholds {
    /// In the free motion as a whole \[N·m\], n.
    pub torque: Vec<f64>,
    /// At rest in the middle of the range of the fit, where dry friction may hold its part \[N·m\], n.
    pub at_rest: Vec<f64>,
    /// False alarms of the whole arm in an hour that they are set for.
    pub false_alarms_per_hour: f64,
    /// Time of free motion that they come from \[s\].
    pub seconds: f64,
    /// Joints of which only a contact tells that is larger than usual torque.
    pub blind: Vec<String>,
    #[serde(skip)]
    spreads: Vec<Spread>,
    /// Of the spread, n.
    #[serde(skip)]
    multiples: Vec<f64>,
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
    found: Vec<Contact>,
    is_open: bool,
}

/// Output of the observer at one time.
#[derive(Clone, Copy, Debug)]
pub struct Observed<'a> {
    /// Trajectory.
    pub trajectory: usize,
    /// The block of the recording that it is in.
    pub block: &'a Motion,
    /// Row of the block.
    pub row: usize,
    /// \[s\].
    pub t: f64,
    /// Time since the row before \[s\]; 0 of the first of a trajectory.
    dt: f64,
    /// External torque \[N·m\], n; NaN during the transient of the observer.
    pub torque: &'a [f64],
    /// What the spread of each joint follows, n.
    followed: &'a [[f64; spread::FOLLOWED]],
    /// What dry friction may hold of it where a joint rests \[N·m\], n.
    held: &'a [f64],
}

impl Observed<'_> {
    /// What friction does not hold of the torque of a joint, and what its spread follows.
    fn beyond_friction(&self, joint: usize) -> spread::Row {
        let (torque, held) = (self.torque[joint], self.held[joint]);
        (torque.signum() * (torque.abs() - held).max(0.0), self.followed[joint])
    }
}

/// Peaks that are closer than this \[s\] are one.
const APART: f64 = 0.2;
/// Part of the rows of a free log below the level that peaks are counted from.
const LEVEL: f64 = 0.95;
/// The mean excess of peaks is taken to be larger than what was seen by so many of its standard errors.
const CERTAINTY: f64 = 3.0;
/// Peaks beyond a threshold are more than expected by at most so many standard deviations of a count.
const BY_CHANCE: f64 = 2.5;
/// Contacts in a log that is not said to be free, at most, but for half of its peaks.
const MOST_CONTACTS: f64 = 10.0;
/// A threshold at a peak is above it, however both are rounded.
const ROUNDED: f64 = 1.0 + 1e-9;
/// Rows that the level is found from at most: more are thinned evenly.
const MOST_ROWS: usize = 65_536;
/// Held-out rows say that other motion is missed by so many times as much at most.
const MOST_UNSEEN: f64 = 3.0;
/// So many half-lives of an observer pass before it is believed.
const SETTLING: f64 = 5.0;
/// A threshold above so many times the spread of the torque that was trained on sees few contacts.
const BLIND: f64 = 2.0;

/// External torques of a recording, row by row.
///
/// - `bandwidth`: of the observer \[Hz\]
///
/// # Errors
/// [`IdentifyError`]: the reader's message, missing torque, or a model of another arm.
pub fn external_torques(
    model: &Model,
    recording: &(impl Recording + ?Sized),
    bandwidth: f64,
    see: &mut dyn FnMut(Observed<'_>) -> Result<(), ReadError>,
) -> Result<(), IdentifyError> {
    model.check_joints(recording.joints())?;
    let gain = std::f64::consts::TAU * bandwidth;
    let mut observer = MomentumObserver::new(model, gain);
    let mut follower = Follower::new(model, gain);
    let torque = Torque::new(model);
    let mut path = torque.path();
    let mut last: Option<(usize, f64)> = None;
    let mut begin = 0.0;
    let settling = vec![f64::NAN; model.n_joints()];
    recording.read(&mut |trajectory, block| {
        let tau = block.require_tau()?;
        let held = held(&torque, &path.follow(trajectory, block))?;
        for (row, &t) in block.t().iter().enumerate() {
            let dt = match last {
                Some((own, before)) if own == trajectory => t - before,
                _ => {
                    observer.reset();
                    follower.reset();
                    begin = t;
                    0.0
                }
            };
            last = Some((trajectory, t));
            let [q, dq, ddq, tau] = [block.q(), block.dq(), block.ddq(), tau]
                .map(|x| x.row(row).iter().copied().collect::<Vec<f64>>());
            let external = observer.step(dt, [&q, &dq, &tau])?;
            let held: Vec<f64> = held.row(row).iter().copied().collect();
            follower.step(dt, [&dq, &ddq, &tau], &held);
            let Follower { followed, held, .. } = &follower;
            let is_settled = t - begin > SETTLING / gain;
            let torque = if is_settled { external } else { &settling };
            see(Observed { trajectory, block, row, t, dt, torque, followed, held })?;
        }
        Ok(())
    })?;
    Ok(())
}

impl Thresholds {
    /// The thresholds that free motion asks for.
    ///
    /// - `is_free`: whether nothing touched the arm, so that its largest peak is no contact either;
    ///   else contacts are taken to be fewer than half of the peaks, or than ten
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
        // First the spreads and levels, from rows thinned evenly, then the peaks beyond them.
        let (sample, rows, seconds) = sample(model, free, bandwidth)?;
        if rows == 0 || seconds <= 0.0 {
            return Err(IdentifyError::TooFewRows { rows, needed: 2, joints: n });
        }
        let spreads: Vec<Spread> = sample.iter().map(|own| Spread::of(own, is_free)).collect();
        let level = |(own, spread): (&Vec<spread::Row>, &Spread)| {
            let mut parts: Vec<f64> = own.iter().map(|row| spread.square(row)).collect();
            quantile(&mut parts, LEVEL)
        };
        let levels: Vec<f64> = sample.iter().zip(&spreads).map(level).collect();
        let mut peaks = vec![Peaks::default(); n];
        external_torques(model, free, bandwidth, &mut |row| {
            for (joint, own) in peaks.iter_mut().enumerate() {
                let part = spreads[joint].square(&row.beyond_friction(joint));
                own.take((row.trajectory, row.t), part - levels[joint]);
            }
            Ok(())
        })?;
        let own_rate = false_alarms_per_hour / n as f64;
        let multiple = |(peaks, level): (&mut Peaks, &f64)| {
            (level + peaks.excess_at(own_rate * seconds / 3_600.0, is_free)).sqrt()
        };
        // Rows that the model was learned from miss less than those of other motion.
        let unseen = model.training.unseen_rms();
        let scores = score(model, free)?;
        let more = |(joint, own): (usize, &JointScore)| {
            unseen.get(joint).map_or(1.0, |unseen| unseen / own.rmse).clamp(1.0, MOST_UNSEEN)
        };
        let more = scores.joints.iter().enumerate().map(more);
        let multiples: Vec<f64> = peaks
            .iter_mut()
            .zip(&levels)
            .map(multiple)
            .zip(more)
            .map(|(k, more)| k * more)
            .collect();
        let times = |of: &dyn Fn(&Spread) -> f64| -> Vec<f64> {
            spreads.iter().zip(&multiples).map(|(spread, k)| k * of(spread)).collect()
        };
        let (torque, at_rest) = (times(&|spread| spread.whole), times(&Spread::at_rest));
        let held = held_at_rest(model)?;
        let at_rest = at_rest.iter().zip(&held).map(|(beyond, held)| beyond + held).collect();
        let trained = model.joints.iter().zip(&model.training.torque_std).zip(&torque);
        let blind = trained.filter(|((_, std), most)| **most > BLIND * **std);
        let blind = blind.map(|((name, _), _)| name.clone()).collect();
        Ok(Self { torque, at_rest, false_alarms_per_hour, seconds, blind, spreads, multiples })
    }

    /// Of each joint \[N·m\], n, in the motion of a row.
    pub fn at(&self, row: Observed<'_>) -> Vec<f64> {
        let own = self.spreads.iter().zip(&self.multiples).zip(row.followed.iter().zip(row.held));
        own.map(|((spread, multiple), (at, held))| multiple * spread.at(at) + held).collect()
    }
}

/// Rows of each joint of a free arm, thinned evenly, n; their number before, and their time \[s\].
fn sample(
    model: &Model,
    free: &(impl Recording + ?Sized),
    bandwidth: f64,
) -> Result<(Vec<Vec<spread::Row>>, usize, f64), IdentifyError> {
    let mut of_joints = vec![Vec::new(); model.n_joints()];
    let (mut rows, mut seconds, mut stride) = (0_usize, 0.0, 1);
    external_torques(model, free, bandwidth, &mut |row| {
        seconds += row.dt;
        if row.torque.iter().any(|x| x.is_nan()) {
            return Ok(());
        }
        if rows.is_multiple_of(stride) {
            let own = of_joints.iter_mut().enumerate();
            own.for_each(|(joint, sample)| sample.push(row.beyond_friction(joint)));
        }
        rows += 1;
        if of_joints[0].len() > MOST_ROWS {
            of_joints.iter_mut().for_each(halve);
            stride *= 2;
        }
        Ok(())
    })?;
    Ok((of_joints, rows, seconds))
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
            halve(&mut self.excess);
            self.left_out = 2 * self.left_out + 1;
        }
    }

    /// The excess that so many peaks of as much other motion are expected to be beyond: peaks are taken to
    /// fall off exponentially. Where contacts may be among them, their mean excess is found by quantiles
    /// that these do not move: the median, and where peaks are many, that of all but some. Where none
    /// are, the peaks that are beyond may be more than expected by chance alone.
    fn excess_at(&mut self, expected: f64, is_free: bool) -> f64 {
        if let Some((_, _, most)) = self.open.take() {
            self.push(most);
        }
        let count = f64::max((self.excess.len() * (self.left_out + 1)) as f64, 1.0);
        let mean = if is_free {
            self.excess.iter().sum::<f64>() / self.excess.len().max(1) as f64
        } else {
            let parts = [0.5, f64::max(0.5, 1.0 - MOST_CONTACTS / count)];
            let means = parts.map(|part| quantile(&mut self.excess, part) / -f64::ln(1.0 - part));
            f64::max(means[0], means[1])
        };
        // Few peaks may not promise too little.
        let told = mean * (1.0 + CERTAINTY / count.sqrt()) * (count / expected).ln().max(0.0);
        if !is_free {
            return told;
        }
        self.excess.sort_by(|a, b| b.total_cmp(a));
        let each = (self.left_out + 1) as f64;
        let allowed = expected + BY_CHANCE * expected.sqrt();
        let beyond = (1..).zip(&self.excess).find(|(rank, _)| each * f64::from(*rank) > allowed);
        told.max(beyond.map_or(0.0, |(_, most)| ROUNDED * most))
    }
}

/// Keeps the first of each two.
fn halve<T>(values: &mut Vec<T>) {
    *values = std::mem::take(values).into_iter().step_by(2).collect();
}

impl ContactDetector {
    /// A detector of the joints of a model.
    pub fn new(model: &Model) -> Self {
        Self { joints: model.joints.clone(), found: Vec::new(), is_open: false }
    }

    /// Takes the external torques at a time, and their thresholds there.
    pub fn take(&mut self, t: f64, external: &[f64], thresholds: &[f64]) {
        let factors = external.iter().zip(thresholds).map(|(x, most)| x.abs() / most);
        let largest = factors.enumerate().filter(|(_, factor)| factor.is_finite());
        let Some((joint, factor)) = largest.max_by(|a, b| a.1.total_cmp(&b.1)) else { return };
        let ends = self.found.last().map_or(f64::NEG_INFINITY, |contact| contact.end);
        self.is_open &= t >= ends && t - ends < APART;
        if factor <= 1.0 {
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
