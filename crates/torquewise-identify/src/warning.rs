//! Warnings: what the user should know, in words.

use crate::disagreement::Disagreement;
use crate::drift::{FrictionDrift, logs};
use crate::excitation::{Finding, findings, list};
use crate::learn::kinds::is_kind_untold;
use crate::residual_shape::Shape;
use crate::unseen::geometric_mean;
use std::fmt;
use std::ops::Range;
use torquewise_model::{Model, Training};
use torquewise_motion::{LARGEST, Motion, Pattern};
use torquewise_stepwise::fit::LibraryFit;
use torquewise_stepwise::orders::OrderCurve;
use torquewise_stepwise::survey::Survey;

/// Something that does not stop the work but may spoil its result. Joints and terms are named.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
#[expect(missing_docs, reason = "each kind explains its fields")]
pub enum Warning {
    /// Joints that never move.
    ConstantJoints { joints: Vec<String> },
    /// A joint's torque never changes.
    ConstantTorque { joint: String },
    /// Rows of a pattern are missing, its terms were fitted with the rows of the next.
    PatternMissing(Pattern),
    /// So many candidates are excited by no row.
    UnassignedCandidates { candidates: usize },
    /// Terms left out of the last fit because they are linearly dependent in this log.
    Dependent { terms: Vec<String> },
    /// Rows of a pattern are missing, so no order can be chosen for its step.
    NoOrder(Pattern),
    /// Even the order chosen of a library, or a step, explains little of a joint's torque: the held-out
    /// residual over the standard deviation of the torque.
    Unexplained { library: String, joint: String, residual: f64 },
    /// Joints seem to slide, as `rrpr`, and were fitted as such that turn.
    Sliding { kinds: String },
    /// A joint that moved by little may as well slide as turn, and is taken to turn.
    Kind { joint: String },
    /// What the motion of the log leaves open.
    Excitation(Finding),
    /// Logs that were fitted together differ in what gravity does.
    Disagreement(Disagreement),
    /// Friction changes along long logs.
    Drift(FrictionDrift),
    /// Most of what is missed of a joint is missed in few rows.
    Shape(Shape),
    /// Gravity pulls elsewhere than a URDF and its user say: along this line in the base of the URDF,
    /// of length 1, as one writes it.
    Gravity { line: String },
    /// The log seems to count joints otherwise than the file that their axes are from: what each may be
    /// in that file, `joint3 as -q + 90°`.
    Coordinates { joints: String },
    /// Two logs hold the same rows.
    Repeated,
    /// M(q) is not positive definite within the range of the log, and where.
    NotPhysical(String),
    /// The fit to all rows leaves far more than the search did on a sample: the ratio of both residuals,
    /// geometric mean of the joints.
    Refit { ratio: f64 },
    /// Positions, velocities or torques larger than those of any joint: which they are, in what unit
    /// they are taken, and in what unit they may be; the largest, of torques the root of their mean
    /// square.
    Units { joint: String, what: [&'static str; 3], largest: f64 },
}

/// The fit to all rows may leave this many times what the search left on a sample.
const MOST_REFIT: f64 = 1.1;
/// And what it leaves more must be this part of the spread of the torque.
const MUCH: f64 = 0.03;
/// A residual below this part of the spread of a torque is none.
const NOTHING: f64 = 1e-3;

/// Fewer rows may be alike by chance, as of an arm at rest.
const TOLD_ROWS: usize = 8;

impl Warning {
    /// Whether it is a note: no reason to doubt the model.
    pub fn is_remark(&self) -> bool {
        matches!(self, Self::PatternMissing(_) | Self::Dependent { .. })
    }

    pub(crate) fn of_library(survey: &Survey, fit: &LibraryFit) -> Vec<Self> {
        let mut warnings = Self::of_survey(survey);
        warnings.extend(fit.missing.iter().copied().map(Self::PatternMissing));
        if fit.unassigned > 0 {
            warnings.push(Self::UnassignedCandidates { candidates: fit.unassigned });
        }
        if !fit.dependent.is_empty() {
            warnings.push(Self::Dependent { terms: fit.dependent.clone() });
        }
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
            Self::Excitation(Finding::Range { joint, .. }) => !slides(joint),
            Self::Excitation(
                Finding::Speed { joints, .. } | Finding::Acceleration { joints, .. },
            ) => {
                joints.retain(|joint| !slides(joint));
                !joints.is_empty()
            }
            Self::Excitation(Finding::Unrelated { joint, .. }) => {
                error_of(joint).is_none_or(|error| error >= Training::POOR)
            }
            _ => true,
        });
        for warning in warnings {
            if let Self::Excitation(Finding::Range { joint, .. }) = warning
                && is_kind_untold(&model.choices, joint)
            {
                *warning = Self::Kind { joint: std::mem::take(joint) };
            }
        }
    }

    /// What to know before trusting the orders chosen.
    ///
    /// - `joints`: their names, n
    pub fn of_orders(curves: &[OrderCurve], joints: &[String]) -> Vec<Self> {
        let missing = Pattern::ALL
            .into_iter()
            .filter(|pattern| !curves.iter().any(|c| c.name == pattern.name()));
        let unexplained = curves.iter().filter_map(|curve| {
            let chosen = curve.points.get(curve.chosen)?;
            let residuals = joints.iter().zip(&chosen.residual);
            let (joint, &residual) = residuals.max_by(|a, b| a.1.total_cmp(b.1))?;
            let (library, joint) = (curve.name.clone(), joint.clone());
            (!chosen.suffices()).then_some(Self::Unexplained { library, joint, residual })
        });
        missing.map(Self::NoOrder).chain(unexplained).collect()
    }

    /// Whether a fit to all rows left more than the search it came from, RMS of each joint; next to
    /// nothing beside the spread of its torque is nothing.
    pub(crate) fn of_refit(
        searched_rms: &[f64],
        residual_rms: &[f64],
        torque_std: &[f64],
    ) -> Option<Self> {
        let measured = searched_rms.iter().zip(residual_rms).zip(torque_std);
        let measured = measured.filter(|(_, std)| **std > 0.0);
        let pairs: Vec<[f64; 2]> = measured
            .map(|((searched, left), std)| [searched, left].map(|rms| (rms / std).max(NOTHING)))
            .collect();
        let [searched, left] =
            [0, 1].map(|k| geometric_mean(&pairs.iter().map(|pair| pair[k]).collect::<Vec<_>>()));
        let (ratio, more) = (left / searched, (left * left - searched * searched).max(0.0).sqrt());
        (ratio > MOST_REFIT && more > MUCH).then_some(Self::Refit { ratio })
    }

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
        warnings.extend(findings(survey).into_iter().map(Self::Excitation));
        warnings.extend(has_log_twice(&survey.sample).then_some(Self::Repeated));
        warnings
    }
}

pub(crate) fn never_move(joints: &[String]) -> String {
    format!("{} never move{}", list(joints), if joints.len() == 1 { "s" } else { "" })
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

impl fmt::Display for Warning {
    #[expect(clippy::too_many_lines, reason = "a table of sentences")]
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ConstantJoints { joints } => write!(
                f,
                "{}: what depends on that motion cannot be found; move all joints",
                never_move(joints)
            ),
            Self::ConstantTorque { joint } => {
                write!(f, "the torque of {joint} never changes: is it measured?")
            }
            Self::PatternMissing(pattern) => write!(
                f,
                "the log shows no {}: its terms were fitted with the rows of the next pattern; \
                 record dwells and strokes of constant speed for a stepwise fit",
                pattern.name()
            ),
            Self::UnassignedCandidates { candidates } => write!(
                f,
                "candidates left out, since no row accelerates: {candidates}; the model has no inertia"
            ),
            Self::Dependent { terms } => write!(
                f,
                "left out, since this log does not tell them from other terms: {}; move more joints, \
                 through more of their range",
                terms.join(", ")
            ),
            Self::Sliding { kinds } => write!(
                f,
                "joints seem to move as {kinds} (r turns, p slides), and were taken to turn: say their \
                 kinds, or learn a chain"
            ),
            Self::NoOrder(pattern) => write!(
                f,
                "the log shows no {}: no order can be chosen for its step; \
                 record dwells and strokes of constant speed",
                pattern.name()
            ),
            Self::Unexplained { library, joint, residual } => write!(
                f,
                "{library}: even the order chosen leaves {:.0} % of the torque of {joint} \
                 unexplained on held-out rows; it lacks what loads the joint, such as friction: \
                 learn a chain instead",
                100.0 * residual
            ),
            Self::Kind { joint } => write!(
                f,
                "{joint} moved by so little that it may as well slide as turn, and is taken to turn: if it \
                 slides, masses, payloads and robot files are wrong until its kind is said"
            ),
            Self::Excitation(finding) => write!(f, "{finding}"),
            Self::Disagreement(logs) => write!(f, "{logs}"),
            Self::Drift(drift) => write!(f, "{drift}"),
            Self::Shape(shape) => write!(f, "{shape}"),
            Self::Gravity { line } => write!(
                f,
                "gravity pulls along {line} of the base of the URDF, not as said: does the arm hang on a \
                 wall or a ceiling? Give that direction of gravity, down positive"
            ),
            Self::Coordinates { joints } => write!(
                f,
                "the log seems to count joints otherwise than the URDF: with {joints} held-out torque is \
                 missed by far less; if so, say it by scale and offset of a profile"
            ),
            Self::Repeated => write!(
                f,
                "two logs hold the same rows, which count twice: errors come out too small; give each \
                 log once"
            ),
            Self::NotPhysical(flaw) => write!(
                f,
                "{flaw}, within the range of the log: simulation and computed torque go wrong there, \
                 and export refuses the model; record more motion, or fit a chain"
            ),
            Self::Refit { ratio } => write!(
                f,
                "the fit to all rows leaves {ratio:.2} times the torque that the search left on a \
                 sample of them: what the search found is no physical arm, as where the log moves \
                 little, or torque has a wrong sign or unit, or given axes or gravity are not the arm's"
            ),
            Self::Units { joint, what: [what, taken, may_be], largest } => write!(
                f,
                "{joint} reaches {largest:.0}: {what} are taken in {taken}; are these {may_be}?"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;
    use torquewise_model::model::Choice;
    use torquewise_motion::Signals;

    /// Two joints, of which the torque of the second is predicted poorly on held-out rows.
    fn model() -> Model {
        let training = Training {
            residual_rms: vec![0.1, 0.1],
            torque_std: vec![1.0, 1.0],
            held_out_rms: vec![0.1, 0.9],
            held_out_by_region_rms: vec![0.1, 0.2],
            ..Training::default()
        };
        let joints = vec!["joint1".into(), "joint2".into()];
        Model { joints, training, ..Model::default() }
    }

    #[test]
    fn a_refit_that_leaves_more_than_the_search_is_told() {
        let told = |left: [f64; 2]| Warning::of_refit(&[0.125; 2], &left, &[1.0; 2]);
        assert!(told([0.25, 1.0]).is_some() && told([0.13, 0.13]).is_none());
    }

    #[test]
    fn a_log_given_twice_is_told_from_two_alike() {
        let logs = |second: f64| {
            let t: Vec<f64> = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0].repeat(2);
            let of = |row: usize| (0.7 * t[row]).sin() + if row == 15 { second } else { 0.0 };
            let column = || Mat::from_fn(16, 1, |row, _| of(row));
            let (joints, [q, dq, ddq]) = (vec!["joint1".into()], [column(), column(), column()]);
            let tau = Some(column());
            Motion::new(Signals { joints, t: t.clone(), q, dq, ddq, tau }).unwrap()
        };

        assert!(has_log_twice(&logs(0.0)));
        assert!(!has_log_twice(&logs(1e-9)));
    }

    #[test]
    fn doubts_about_a_joint_that_is_predicted_well_are_dropped() {
        let unrelated = |joint: &str| {
            Warning::Excitation(Finding::Unrelated { joint: joint.into(), residual: 0.9 })
        };
        let mut warnings = vec![unrelated("joint1"), unrelated("joint2")];
        Warning::retain_founded(&mut warnings, &model());

        assert_eq!(warnings, [unrelated("joint2")]);
    }

    #[test]
    fn a_joint_of_untold_kind_is_said_to_be() {
        let range =
            |joint: &str| Warning::Excitation(Finding::Range { joint: joint.into(), range: 0.1 });
        let mut warnings = vec![range("joint1"), range("joint2")];
        let choice = Choice { what: "kind of joint2".into(), ..Choice::default() };
        let model = Model { choices: vec![choice], ..model() };

        Warning::retain_founded(&mut warnings, &model);

        assert_eq!(warnings, [range("joint1"), Warning::Kind { joint: "joint2".into() }]);
    }
}
