//! How well a model predicts the torque of a log.

use crate::predict::{Interval, MotionRange};
use crate::{Error, Log, NOBODY, Observer, Prepared, Result, Rows, Source, Watched};
use serde::{Serialize, Serializer};
use serde_json::json;
use torquewise_identify::score;
use torquewise_identify::score::{JointScore, MOSTLY, note_of_rest, score_along};
use torquewise_identify::verdict::{Verdict, judge_by};
use torquewise_identify::warning::list;
use torquewise_model::Model;
use torquewise_model::rollout::{self, Drift, Others};
use torquewise_motion::{Motion, Recording};
use torquewise_stepwise::{Digests, NoiseFloor};

/// Errors of a model on a log, joint by joint.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Evaluation {
    /// One per joint, n.
    pub joints: Vec<JointEvaluation>,
    /// Rows.
    pub rows: usize,
    /// Part of the torques of each joint, as they were measured, that lies within their interval of
    /// 95 % \[%\], n, on a sample of the rows. None of a model without a covariance, and where the
    /// measured torque is not at hand.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval_coverage_percent: Option<Vec<f64>>,
    /// Whether the model may be used, by what its own fit and this log say.
    #[serde(flatten, serialize_with = "as_of_fit")]
    pub verdict: Verdict,
    /// How far simulated windows of the log drift, where that was asked for.
    #[serde(skip_serializing_if = "Vec::is_empty", rename = "rollout")]
    pub rollouts: Vec<Drift>,
    /// Joints that leave the range the model was fitted on.
    #[serde(skip)]
    pub notes: Vec<String>,
    /// Scores that mean little.
    #[serde(skip)]
    pub warnings: Vec<String>,
}

impl Evaluation {
    /// The same with [`rollouts()`], and a note of joints that are further from the log after some of the
    /// times than an arm that keeps its velocity.
    #[must_use]
    pub fn with_rollouts(mut self, rollouts: Vec<Drift>) -> Self {
        let worse = |own: &Drift| -> Option<String> {
            let is_worse =
                |k: &usize| own.ran_away > 0 || own.rms_drift_rad[*k] >= own.hold_rms_rad[*k];
            let worse = (0..self.joints.len()).filter(is_worse);
            let worse: Vec<&str> = worse.map(|k| self.joints[k].name.as_str()).collect();
            (!worse.is_empty())
                .then(|| format!("of {} after {} s", worse.join(", "), own.horizon_s))
        };
        let worse: Vec<String> = rollouts.iter().filter_map(worse).collect();
        if !worse.is_empty() {
            self.notes.push(format!(
                "simulated, the drift {} is larger than that of an arm that keeps its velocity: the torque \
                 may do for feed-forward, a simulator needs better, as a chain refined by rollouts may be",
                worse.join(", ")
            ));
        }
        let away = rollouts.iter().rfind(|drift| drift.ran_away > 0);
        self.notes.extend(away.map(|Drift { ran_away, windows, horizon_s, .. }| {
            format!(
                "simulated, {ran_away} of {windows} windows ran away within {horizon_s} s and do not \
                 count in the drift"
            )
        }));
        Self { rollouts, ..self }
    }
}

/// Errors of one joint.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointEvaluation {
    /// Joint name.
    pub name: String,
    /// RMSE(τ − τ̂) in the band of the model \[N·m\].
    pub rmse: f64,
    /// RMSE / std(τ) \[%\]; infinite if the torque never changes.
    pub nrmse_percent: f64,
    /// 1 − RMSE²/var(τ).
    pub r2: f64,
    /// NRMSE against torque as it was measured, on a sample of the rows \[%\]; where nothing is
    /// filtered, that of all rows. None where the measured torque is not at hand.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub raw_nrmse_percent: Option<f64>,
    /// White noise in that torque, which no model predicts, of its spread \[%\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise_floor_percent: Option<f64>,
}

/// Compares predicted with measured torque: a log is filtered as those the model was fitted on.
///
/// # Errors
/// `Error::Model` if the log is of another arm, and those of reading it.
///
/// ```
/// # fn main() -> Result<(), torquewise::Error> {
/// use torquewise::dynamics::{Arm, MotionPlan, simulate};
///
/// let arm = Arm::builtin("planar-2").expect("built in");
/// let of = |seed| MotionPlan { seconds: 60.0, rate: 50.0, seed, ..MotionPlan::default() };
/// let [train, test] = [1, 2].map(|seed| simulate(&arm, &of(seed)).expect("a sound plan").motion);
///
/// let fit = torquewise::Fit::new(&train).run()?;
///
/// assert!(fit.evaluate(&test)?.joints.iter().all(|joint| joint.r2 > 0.999));
/// # Ok(())
/// # }
/// ```
pub fn evaluate<'a>(model: &Model, log: impl Into<Source<'a>>) -> Result<Evaluation> {
    match log.into() {
        Source::Log(log) => evaluate_prepared(model, &prepare(model, log)?, NOBODY),
        Source::Recording(recording) => {
            scored(model, &Watched::new(recording, NOBODY, "predicting", None), None)
        }
    }
}

/// The rows of a log to judge a model by.
///
/// # Errors
/// As [`evaluate`].
pub fn prepare(model: &Model, log: &Log) -> Result<Prepared> {
    model.check_joints(log.joints())?;
    log.files.require_tau()?;
    log.prepare_as(model.training.filter, Rows::WithRawTorque)
}

/// The same as [`evaluate`] where the rows are at hand.
///
/// # Errors
/// As [`evaluate`].
pub fn evaluate_prepared(
    model: &Model,
    log: &Prepared,
    observer: Observer<'_>,
) -> Result<Evaluation> {
    let mut evaluation = scored(model, &log.watched(observer, "predicting"), log.raw_torque()?)?;
    evaluation.warnings.extend(log.cut_off().iter().map(ToString::to_string));
    Ok(evaluation)
}

/// Simulates windows of a log from their measured state with the measured torque, and says how far
/// from the measured motion they are after some times \[s\], ascending, beside an arm that keeps its
/// velocity (E23).
///
/// - `samples`: number and seed of arms that are drawn from what the log of the model does not tell,
///   and of the noise of the states they start from, in whose band measured ends should lie
///
/// # Errors
/// As [`evaluate_prepared`]; a setting that cannot be, a model whose inertia is not positive, samples
/// of a model without a covariance.
pub fn rollouts(
    model: &Model,
    log: &Prepared,
    horizons: &[f64],
    samples: Option<(usize, u64)>,
) -> Result<Vec<Drift>> {
    let others = |(count, seed)| -> Result<Others> {
        let models = torquewise_identify::samples(model, count, seed)?;
        Ok(Others { models, noise: noise_of(log.rows(), seed)?, seed })
    };
    let others = samples.map(others).transpose()?;
    Ok(rollout::drifts(model, others.as_ref(), log.rows(), horizons)?)
}

/// Noise in q and q̇ of the rows of a log, filtered or not; n each.
fn noise_of(log: &dyn Recording, seed: u64) -> Result<[Vec<f64>; 2]> {
    let n = log.joints().len();
    let (mut squares, mut rows) = (vec![[0.0; 2]; n], 0_usize);
    for own in 0..log.n_logs() {
        let is_filtered = log.read_log_with_noise(own, seed, &mut |_, _, noise| {
            rows += noise.n_rows();
            for (joint, squares) in squares.iter_mut().enumerate() {
                for (sum, signal) in squares.iter_mut().zip([noise.q(), noise.dq()]) {
                    *sum += signal.col(joint).squared_norm_l2();
                }
            }
            Ok(())
        })?;
        if !is_filtered {
            let NoiseFloor { q, dq, .. } = NoiseFloor::of(log)?;
            return Ok([q, dq]);
        }
    }
    let rms = |k: usize| squares.iter().map(|own| (own[k] / rows.max(1) as f64).sqrt()).collect();
    Ok([rms(0), rms(1)])
}

/// Percentage of torques that bounds are for, and rows of which it is counted, about.
const PERCENT: f64 = 95.0;
const ROWS: usize = 4_000;

/// Bounds of the torque of a log; `None` of a model without a covariance.
pub(crate) fn interval<'a>(model: &'a Model, log: &dyn Recording) -> Result<Option<Interval<'a>>> {
    match Interval::new(model, log, PERCENT) {
        Ok(interval) => Ok(Some(interval)),
        Err(Error::NoCovariance) => Ok(None),
        Err(error) => Err(error),
    }
}

/// Of the rows that a model was fitted to no joint leaves more than this many times what it left, and
/// what rounding is of the spread of a torque.
const MOST_LEFT: f64 = 1.1;
const ROUNDING: f64 = 1e-6;

/// What is said where a model is judged by its own log.
const TRAINED: &str = "the model was fitted to these rows: what is left of them says nothing of \
                       others, judge it by another log";

/// - `raw`: a sample of filtered rows with torque as it was measured, and its white noise \[N·m\], n
fn scored(
    model: &Model,
    recording: &impl Recording,
    raw: Option<(Motion, Vec<f64>)>,
) -> Result<Evaluation> {
    let (mut range, mut digests) = (MotionRange::new(model.n_joints()), Digests::default());
    let scores = score_along(model, recording, &mut |trajectory, block| {
        range.add(block);
        digests.add(trajectory, block);
    })?;
    let is_raw = !recording.is_filtered();
    let unheld: Vec<f64> = scores.joints.iter().map(|joint| joint.unheld_rmse).collect();
    let joint = |JointScore { name, rmse, nrmse_percent, r2, .. }| JointEvaluation {
        name,
        rmse,
        nrmse_percent,
        r2,
        raw_nrmse_percent: is_raw.then_some(nrmse_percent),
        noise_floor_percent: None,
    };
    let mut joints: Vec<JointEvaluation> = scores.joints.into_iter().map(joint).collect();
    let every = scores.rows.div_ceil(ROWS).max(1);
    let coverage = |measured: &dyn Recording, every| {
        let interval = interval(model, recording)?;
        interval.map(|interval| interval.coverage(measured, every)).transpose()
    };
    let mut raw_rmse = Vec::new();
    let covered = match raw {
        Some((motion, noise)) => {
            let raw = score(model, &motion)?.joints.into_iter().zip(noise);
            for (joint, (JointScore { nrmse_percent, std, rmse, .. }, noise)) in
                joints.iter_mut().zip(raw)
            {
                raw_rmse.push(rmse);
                joint.raw_nrmse_percent = Some(nrmse_percent);
                joint.noise_floor_percent = Some(100.0 * noise / std);
            }
            coverage(&motion, 1)?
        }
        None if is_raw => coverage(recording, every)?,
        None => None,
    };
    let rests = range.at_rest(model);
    let still = joints.iter().zip(&rests);
    let still = still.filter(|(joint, rests)| !joint.nrmse_percent.is_finite() && !**rests);
    let still = still.map(|(JointEvaluation { name, .. }, _)| {
        format!("the torque of {name} never changes: look at its RMSE only")
    });
    let is_trained = is_trained(model, &joints, (scores.rows, &digests));
    let by_fit = model.training.verdict.clone().filter(|_| is_trained);
    let mut notes = range.warnings(model);
    notes.extend(is_trained.then(|| TRAINED.to_owned()));
    let held = Held { model, joints: &joints, rests: &rests, unheld: &unheld, raw: &raw_rmse };
    notes.extend(held.remarks());
    let errors = held.errors();
    notes.extend(changed(model, &range, [&errors, &unheld]).filter(|_| !is_trained));
    Ok(Evaluation {
        warnings: still.collect(),
        verdict: by_fit.unwrap_or_else(|| judge_by(model, &errors, covered.as_deref())),
        joints,
        rows: scores.rows,
        interval_coverage_percent: covered,
        rollouts: Vec::new(),
        notes,
    })
}

/// Whether a model was fitted to these rows: the same motion under another torque is another log. One of
/// several may leave all that is left.
fn is_trained(
    model: &Model,
    joints: &[JointEvaluation],
    (rows, digests): (usize, &Digests),
) -> bool {
    let training = &model.training;
    let most = MOST_LEFT * (training.rows as f64 / rows as f64).sqrt().max(1.0);
    let left = training.residual_rms.iter().zip(&training.torque_std);
    let is_known = digests.least().iter().any(|own| training.digests.contains(own));
    is_known
        && joints.iter().zip(left).all(|(own, (rms, std))| own.rmse <= most * rms + ROUNDING * std)
}

/// An arm whose torque is missed by so many times as many \[N·m\] as held-out torque was, and by this part
/// of its spread, may carry another load.
const CHANGED: [f64; 2] = [3.0, 0.1];

/// Joints of a chain that are missed by far more than its fit lets expect, though no faster than there.
///
/// - `errors`: over the spread of the torque, n
/// - `unheld`: RMS \[N·m\], n
fn changed(model: &Model, range: &MotionRange, [errors, unheld]: [&[f64]; 2]) -> Option<String> {
    let training = &model.training;
    let held_out = training.held_out_errors().filter(|_| model.chain.is_some())?;
    let is_missed = |k: &usize| {
        let expected = held_out[*k] * training.torque_std[*k];
        let is_clear = expected > 0.0 && unheld[*k] > CHANGED[0] * expected;
        let [_, is_faster, _] = range.beyond(model, *k);
        is_clear && !is_faster && errors[*k].is_finite() && errors[*k] > CHANGED[1]
    };
    let missed = (0..held_out.len()).filter(is_missed).map(|k| model.joints[k].clone());
    let missed: Vec<String> = missed.collect();
    (!missed.is_empty()).then(|| {
        format!(
            "the torque of {} is missed more than {} times as much as held-out torque of the fit: does the \
             arm carry another load or tool here, as payload would tell, or was it mounted anew?",
            list(&missed),
            CHANGED[0]
        )
    })
}

/// A filter that cuts the motion errs by this \[%\] more than raw torque, and so many times as much.
const CUT: [f64; 2] = [0.5, 1.2];
/// What is missed at rest beyond friction, of the spread that was fitted, is nothing below this.
const LEAST_AT_REST: f64 = 0.1;
/// Where friction at rest leaves less than this part of an error, the verdict is of another figure than
/// the scores.
const VISIBLY: f64 = 0.97;

/// Joints of a log, as far as they rest, where dry friction may hold them with anything.
struct Held<'a> {
    model: &'a Model,
    joints: &'a [JointEvaluation],
    /// Whether they always rest, n.
    rests: &'a [bool],
    /// RMS of what friction at rest cannot make up for \[N·m\], n.
    unheld: &'a [f64],
    /// RMSE of the torque as it was measured \[N·m\], n, where that is at hand.
    raw: &'a [f64],
}

impl Held<'_> {
    /// Errors over the spread of the torque, n, without what friction may hold; of a joint that always
    /// rests over the spread that the model was fitted to, and none where friction may hold it all.
    fn errors(&self) -> Vec<f64> {
        let of = |(k, joint): (usize, &JointEvaluation)| {
            let part = if joint.rmse > 0.0 { self.unheld[k] / joint.rmse } else { 1.0 };
            let std = self.model.training.torque_std.get(k);
            match std.filter(|std| self.rests[k] && **std > 0.0) {
                Some(std) if self.unheld[k] < LEAST_AT_REST * std => f64::NAN,
                Some(std) => self.unheld[k] / std,
                None => 0.01 * joint.nrmse_percent * part,
            }
        };
        self.joints.iter().enumerate().map(of).collect()
    }

    /// What is said of joints that rest, and of those that move: what the filter adds to an error, where
    /// it lets too little of the motion through.
    fn remarks(&self) -> impl Iterator<Item = String> {
        let (mut cut, mut held, errors) = (Vec::new(), Vec::new(), self.errors());
        for (k, JointEvaluation { name, rmse, nrmse_percent, raw_nrmse_percent, .. }) in
            self.joints.iter().enumerate()
        {
            // Noise in the torque makes its RMSE larger.
            let is_less = self.raw.get(k).is_some_and(|raw| raw < rmse);
            if self.rests[k] || self.unheld[k] < VISIBLY * rmse {
                let counts = format!("{name} ({:.2} % counts)", 100.0 * errors[k]);
                held.push(if errors[k].is_nan() { name.clone() } else { counts });
            }
            if !self.rests[k]
                && self.unheld[k] >= MOSTLY * rmse
                && is_less
                && raw_nrmse_percent
                    .is_some_and(|raw| *nrmse_percent > (raw + CUT[0]).max(CUT[1] * raw))
            {
                cut.push(name.clone());
            }
        }
        let cut = (!cut.is_empty()).then(|| {
            format!(
                "of {} less is missed of the raw torque than of the filtered, as where the filter of the fit \
                 cuts a faster motion: go by raw torque",
                list(&cut)
            )
        });
        let held = (!held.is_empty()).then(|| note_of_rest(&held));
        cut.into_iter().chain(held)
    }
}

/// A verdict as in the summary of a fit.
fn as_of_fit<S: Serializer>(verdict: &Verdict, to: S) -> Result<S::Ok, S::Error> {
    json!({ "verdict": verdict.grade, "because": verdict.because }).serialize(to)
}
