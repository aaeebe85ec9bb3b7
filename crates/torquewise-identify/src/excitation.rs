//! What the motion of a log cannot determine, in words a person can act on.

use crate::drift::logs;
use crate::learn::kinds::is_kind_untold;
use crate::rough::unexplained_part;
use crate::{Warning, spread};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use std::ops::Range;
use torquewise_model::{Model, Torque, Training};
use torquewise_motion::{LARGEST, Motion, quantile};
use torquewise_stepwise::{IdentifyError, Survey, thinned};

/// Below these a joint is hardly excited: rad, rad/s, rad/s².
pub(crate) const LEAST_RANGE: f64 = 0.35;
const LEAST_SPEED: f64 = 0.2;
const LEAST_ACCELERATION: f64 = 0.5;
/// Part of the rows that a peak exceeds: one start or stop tells little.
const PEAK: f64 = 0.99;
/// A direction with less of the way than this is missing.
const LEAST_SHARE: f64 = 0.05;
/// Speeds of higher correlation are one motion.
const MOST_CORRELATION: f64 = 0.98;
/// A torque that position explains but for this share is no measurement of a moving joint.
const LEAST_RESIDUAL: f64 = 0.005;
/// Nor is one that it explains but for this share, where a model leaves no less than this part of it: of
/// joints of 20 real arms position alone left 0.038 at least.
const LITTLE_RESIDUAL: f64 = 0.03;
const AS_MUCH: f64 = 0.9;
/// A torque is a velocity where it is as large, but for this part: no drive has nothing but viscous
/// friction of 1 N·m·s/rad.
const SAME: f64 = 0.05;

/// A torque that a rough model explains no better than this is none of the motion.
const MOST_RESIDUAL: f64 = 0.85;
/// Rows by which a command is recognised.
const COMMAND_ROWS: usize = 2_000;
/// Fewer rows may be alike by chance, as of an arm at rest.
const TOLD_ROWS: usize = 8;

/// What the motion of a log leaves open, joint by joint; joints that never move are left to the
/// warnings of the survey.
fn findings(survey: &Survey) -> Vec<Warning> {
    let motion = &survey.sample;
    let still = survey.constant_joints();
    let joints: Vec<usize> =
        (0..motion.n_joints()).filter(|joint| !still.contains(joint)).collect();
    let peaks: Vec<[f64; 2]> = joints.iter().map(|&joint| peaks(survey, joint)).collect();
    let mut found: Vec<Warning> =
        joints.iter().flat_map(|&joint| of_joint(survey, joint)).collect();
    let lame = |derivative: usize, least: f64| {
        let each = joints.iter().zip(&peaks).map(|(&joint, peaks)| (joint, peaks[derivative]));
        let (lame, peaks): (Vec<usize>, Vec<f64>) = each.filter(|(_, peak)| *peak < least).unzip();
        let names: Vec<String> = lame.iter().map(|&joint| survey.joints[joint].clone()).collect();
        (!names.is_empty()).then(|| (names, peaks.into_iter().fold(0.0, f64::max)))
    };
    let slow = lame(0, LEAST_SPEED).map(|(joints, peak)| Warning::Speed { joints, peak });
    let gentle = lame(1, LEAST_ACCELERATION);
    let gentle = gentle.map(|(joints, peak)| Warning::Acceleration { joints, peak });
    found.extend(slow.into_iter().chain(gentle));
    found.extend(together(survey, &joints));
    let moving = moving(survey);
    found.extend(commanded(survey, &moving, &|_| LEAST_RESIDUAL).unwrap_or_default());
    let is_velocity = |joint: usize| {
        let tau = motion.tau().map(|tau| tau.col(joint));
        tau.is_some_and(|tau| (tau - motion.dq().col(joint)).norm_l2() < SAME * tau.norm_l2())
    };
    let velocities = moving.iter().filter(|joint| is_velocity(**joint));
    let joints: Vec<String> = velocities.map(|&joint| survey.joints[joint].clone()).collect();
    found.extend((!joints.is_empty()).then_some(Warning::Velocity { joints }));
    found.extend(moving.iter().filter_map(|&joint| {
        let residual = unexplained_part(motion, joint).filter(|left| *left > MOST_RESIDUAL)?;
        Some(Warning::Unrelated { joint: survey.joints[joint].clone(), residual })
    }));
    found
}

/// Groups of joints of which each moves together with another one of its group.
fn together(survey: &Survey, joints: &[usize]) -> Vec<Warning> {
    let mut groups: Vec<(Vec<usize>, f64)> = Vec::new();
    for &joint in joints {
        let with = |group: &(Vec<usize>, f64)| {
            let each = group.0.iter().map(|&other| correlation(&survey.sample, other, joint));
            each.max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or_default()
        };
        match groups.iter_mut().find(|group| with(group).abs() > MOST_CORRELATION) {
            Some(group) => {
                let own = with(group);
                group.1 = if own.abs() < group.1.abs() { own } else { group.1 };
                group.0.push(joint);
            }
            None => groups.push((vec![joint], f64::INFINITY)),
        }
    }
    let several = groups.into_iter().filter(|(joints, _)| joints.len() > 1);
    several
        .map(|(joints, correlation)| {
            let joints = joints.into_iter().map(|joint| survey.joints[joint].clone()).collect();
            Warning::Together { joints, correlation }
        })
        .collect()
}

fn of_joint(survey: &Survey, joint: usize) -> Vec<Warning> {
    let name = || survey.joints[joint].clone();
    let mut found = Vec::new();
    let range = survey.range(joint);
    if range < LEAST_RANGE {
        found.push(Warning::Range { joint: name(), range });
    }
    let speeds = survey.sample.dq().col(joint);
    let [forward, backward] =
        [1.0, -1.0].map(|way| speeds.iter().map(|dq| (way * dq).max(0.0)).sum::<f64>());
    if forward.min(backward) < LEAST_SHARE * (forward + backward) {
        found.push(Warning::OneWay { joint: name(), forward: forward > backward });
    }
    found
}

/// Joints that move at all, under a torque that changes; an arm that does so gently must not escape what
/// is looked for.
fn moving(survey: &Survey) -> Vec<usize> {
    let still = survey.constant_joints();
    let moves = |&joint: &usize| {
        !still.contains(&joint)
            && survey.dq_peak[joint] > LEAST_SPEED
            && survey.ddq_peak[joint] > LEAST_ACCELERATION
            && survey.torque_std[joint] > 0.0
    };
    (0..survey.joints.len()).filter(moves).collect()
}

/// Speed and acceleration of a joint that [`PEAK`] of the rows do not exceed.
fn peaks(survey: &Survey, joint: usize) -> [f64; 2] {
    [survey.sample.dq(), survey.sample.ddq()].map(|values| {
        let mut sizes: Vec<f64> = values.col(joint).iter().map(|value| value.abs()).collect();
        quantile(&mut sizes, PEAK)
    })
}

fn correlation(motion: &Motion, first: usize, second: usize) -> f64 {
    let (a, b) = (motion.dq().col(first), motion.dq().col(second));
    let across: f64 = a.iter().zip(b.iter()).map(|(a, b)| a * b).sum();
    let size = a.norm_l2() * b.norm_l2();
    if size > 0.0 { across / size } else { 0.0 }
}

/// Torques that position, or the gravity of a model, explains nearly, and what moves and rubs in the
/// model no better.
pub(crate) fn commanded_by(survey: &Survey, model: &Model) -> Result<Vec<Warning>, IdentifyError> {
    // One that misses more is no witness.
    let most = |joint: usize| {
        let left = model.training.residual_rms[joint] / survey.torque_std[joint];
        if left < LITTLE_RESIDUAL { LITTLE_RESIDUAL.min(left / AS_MUCH) } else { 0.0 }
    };
    let moving = moving(survey);
    let mut found = commanded(survey, &moving, &most).unwrap_or_default();
    if found.is_empty() && survey.torque_std.iter().any(|std| *std > 0.0) {
        let motion = thinned(&survey.sample, COMMAND_ROWS);
        let rest = motion.require_tau()? - Torque::new(model).parts(&motion)?.gravity;
        found.extend(moving.into_iter().filter_map(|joint| {
            let residual = spread(rest.col(joint)) / survey.torque_std[joint];
            let joint = (residual < most(joint)).then(|| survey.joints[joint].clone())?;
            Some(Warning::Commanded { joint, residual })
        }));
    }
    Ok(found)
}

/// Torques that are what a controller makes of the position: the torque of a real joint that moves
/// holds friction and inertia too. `None` where that cannot be told.
///
/// - `most`: share of the torque of a joint that position may leave
fn commanded(
    survey: &Survey,
    joints: &[usize],
    most: &dyn Fn(usize) -> f64,
) -> Option<Vec<Warning>> {
    let motion = thinned(&survey.sample, COMMAND_ROWS);
    let tau = motion.tau()?;
    let (m, n) = (motion.n_rows(), motion.n_joints());
    if m < 20 * (2 * n + 1) {
        return None;
    }
    let columns = Mat::from_fn(m, 2 * n + 1, |row, column| match column.checked_sub(1) {
        None => 1.0,
        Some(k) if k % 2 == 0 => motion.q()[(row, k / 2)].sin(),
        Some(k) => motion.q()[(row, k / 2)].cos(),
    });
    let mut gram = columns.transpose() * &columns;
    for j in 0..gram.ncols() {
        gram[(j, j)] += 1e-10 * m as f64;
    }
    let factor = gram.llt(Side::Lower).ok()?;
    let of_joint = |&joint: &usize| {
        let target = tau.col(joint);
        let fitted = &columns * factor.solve(columns.transpose() * target);
        let squares: f64 = target.iter().zip(fitted.iter()).map(|(a, b)| (a - b).powi(2)).sum();
        let residual = (squares / m as f64).sqrt() / survey.torque_std[joint];
        (residual < most(joint))
            .then(|| Warning::Commanded { joint: survey.joints[joint].clone(), residual })
    };
    Some(joints.iter().filter_map(of_joint).collect())
}

impl Warning {
    /// What a log leaves open or hardly can be, before anything is fitted to it.
    pub fn of_survey(survey: &Survey) -> Vec<Self> {
        let name = |joint: usize| survey.joints[joint].clone();
        let joints: Vec<String> = survey.constant_joints().into_iter().map(name).collect();
        let mut warnings = Vec::new();
        warnings.extend((!joints.is_empty()).then_some(Self::ConstantJoints { joints }));
        for joint in 0..survey.joints.len() {
            if survey.torque_std[joint] == 0.0 {
                warnings.push(Self::ConstantTorque { joint: name(joint) });
            }
            let [low, high] = survey.q_range[joint];
            let torque = survey.torque_mean[joint].hypot(survey.torque_std[joint]);
            let largest = [
                (low.abs().max(high.abs()), LARGEST[0], ["positions", "rad", "degrees"]),
                (survey.dq_peak[joint], LARGEST[1], ["velocities", "rad/s", "deg/s"]),
                (torque, LARGEST[3], ["torques", "N·m", "mN·m"]),
            ];
            let beyond = largest.into_iter().filter(|(largest, limit, _)| largest > limit);
            warnings.extend(beyond.map(|(largest, _, what)| Self::Units {
                joint: name(joint),
                what,
                largest,
            }));
        }
        warnings.extend(findings(survey));
        warnings.extend(has_log_twice(&survey.sample).then_some(Self::Repeated));
        warnings
    }

    /// Leaves out what a rough look at the torque of a joint found amiss, where the model predicts
    /// its held-out rows well: a rough look knows neither the other joints nor the noise. Of a joint that
    /// turns through little only, says where it may as well slide.
    pub(crate) fn retain_founded(warnings: &mut Vec<Self>, model: &Model) {
        // What is little of a turn, in rad, is not of a slide, in m.
        let errors = model.training.held_out_errors().unwrap_or_default();
        let place = |joint: &str| model.joints.iter().position(|name| name == joint);
        let slides = |joint: &str| place(joint).is_some_and(|joint| model.kinds().slides(joint));
        let error_of = |joint: &str| errors.get(place(joint)?).copied();
        warnings.retain_mut(|warning| match warning {
            Self::Range { joint, .. } => !slides(joint),
            Self::Speed { joints, .. } | Self::Acceleration { joints, .. } => {
                joints.retain(|joint| !slides(joint));
                !joints.is_empty()
            }
            Self::Unrelated { joint, .. } => {
                error_of(joint).is_none_or(|error| error >= Training::POOR)
            }
            _ => true,
        });
        for warning in &mut *warnings {
            if let Self::Range { joint, .. } = warning
                && is_kind_untold(&model.choices, joint)
            {
                *warning = Self::Kind { joint: std::mem::take(joint), slides: false };
            }
        }
        let slides = model.joints.iter().filter(|joint| slides(joint));
        let untold = slides.filter(|joint| is_kind_untold(&model.choices, joint));
        warnings.extend(untold.map(|joint| Self::Kind { joint: joint.clone(), slides: true }));
    }
}

/// Whether two logs of a sample hold the same positions and torques.
fn has_log_twice(sample: &Motion) -> bool {
    let logs = logs(sample.t());
    let is_same = |a: &Range<usize>, b: &Range<usize>| {
        let signals = std::iter::once(sample.q()).chain(sample.tau());
        let mut rows = a.clone().zip(b.clone());
        a.len() == b.len() && rows.all(|(a, b)| signals.clone().all(|x| x.row(a) == x.row(b)))
    };
    let mut told = logs.iter().enumerate().filter(|(_, log)| log.len() >= TOLD_ROWS);
    told.any(|(k, log)| logs[k + 1..].iter().any(|other| is_same(log, other)))
}

#[cfg(test)]
mod tests;
