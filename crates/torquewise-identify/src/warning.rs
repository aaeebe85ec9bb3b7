//! Warnings: what the user should know, in words.

use crate::residual_shape::ResidualPlace;
use crate::{Disagreement, geometric_mean, score};
use std::fmt;
use torquewise_motion::Pattern;
use torquewise_stepwise::Survey;
use torquewise_stepwise::fit::LibraryFit;
use torquewise_stepwise::orders::OrderCurve;

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
    /// A joint that may as well slide as turn: what it is taken to do.
    Kind { joint: String, slides: bool },
    /// A joint turns through too small a range \[rad\].
    Range { joint: String, range: f64 },
    /// Joints that move too slowly: the speed that they hardly ever exceed \[rad/s\].
    Speed { joints: Vec<String>, peak: f64 },
    /// Joints that accelerate too little: what they hardly ever exceed \[rad/s²\].
    Acceleration { joints: Vec<String>, peak: f64 },
    /// A joint moves in one direction only.
    OneWay { joint: String, forward: bool },
    /// Two joints or more that always move together: least correlation of the speeds of two of them.
    Together { joints: Vec<String>, correlation: f64 },
    /// A torque that was cut off: at one of its ends in this share of its motion.
    Clipped { joint: String, share: f64 },
    /// Torques that fit those of the other joints, or all that fit their motion, turned round alone.
    WrongSign { joints: Vec<String> },
    /// Torques that no gravity is in.
    Weightless,
    /// Two torques that fit the motion of each other's joint.
    Swapped { joints: [String; 2] },
    /// Torques that are not in one unit, such as the currents of different motors: of all joints what
    /// a unit is worth beside the others, geometric mean 1, and its standard error, n.
    Gains { joints: Vec<String>, gains: Vec<[f64; 2]> },
    /// A torque that follows from the position but for a share.
    Commanded { joint: String, residual: f64 },
    /// Torques that are the velocities of their joints.
    Velocity { joints: Vec<String> },
    /// A torque that does not follow the motion at all: the share that no rough model explains.
    Unrelated { joint: String, residual: f64 },
    /// Joints that dry friction may hold at rest with any torque up to breakaway: names, and the RMS
    /// of what this explains of the error over the spread of the torque, where it explains most.
    Held { joints: Vec<(String, f64)> },
    /// Logs that were fitted together differ in what gravity does.
    Disagreement(Disagreement),
    /// By what part of itself the friction of a joint grows from the beginning of long logs to their
    /// end, and its standard error; falls if negative. The longest lasts so long \[s\].
    Drift { joint: String, part: f64, std_error: f64, seconds: f64 },
    /// Most of what is missed of a joint is missed in few rows: part of the squared residual that lies
    /// there, and of the rows.
    Shape { joint: String, place: ResidualPlace, shares: [f64; 2] },
    /// Gravity pulls elsewhere than a URDF and its user say: along this line in the base of the URDF,
    /// of length 1, as one writes it.
    Gravity { line: String },
    /// The log seems to count joints otherwise than the file that their axes are from: what each may be
    /// in that file, `joint3 as -q + 90°`.
    Coordinates { joints: String },
    /// Axes that are looked for leave so many times less of the torque than those that were given.
    Axes { ratio: f64 },
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

impl Warning {
    /// Whether it is a note: no reason to doubt the model.
    pub fn is_remark(&self) -> bool {
        matches!(self, Self::PatternMissing(_) | Self::Dependent { .. } | Self::Held { .. })
    }

    pub(crate) fn of_library(survey: &Survey, fit: &LibraryFit) -> Vec<Self> {
        let mut warnings = Self::of_survey(survey);
        warnings.extend(fit.missing.iter().copied().map(Self::PatternMissing));
        let (candidates, terms) = (fit.unassigned, fit.dependent.clone());
        warnings.extend((candidates > 0).then_some(Self::UnassignedCandidates { candidates }));
        warnings.extend((!terms.is_empty()).then_some(Self::Dependent { terms }));
        warnings
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

    /// Whether a fit to all rows left more than the search it came from, RMS of each joint, rows at rest
    /// counted as they are fitted, 0 where that is not asked; next to nothing beside the spread of its
    /// torque is nothing.
    pub(crate) fn of_refit(
        searched_rms: &[f64],
        left_rms: &[f64],
        torque_std: &[f64],
    ) -> Option<Self> {
        let measured = searched_rms.iter().zip(left_rms).zip(torque_std);
        let measured = measured.filter(|((searched, _), std)| **searched > 0.0 && **std > 0.0);
        let pairs: Vec<[f64; 2]> = measured
            .map(|((searched, left), std)| [searched, left].map(|rms| (rms / std).max(NOTHING)))
            .collect();
        let [searched, left] =
            [0, 1].map(|k| geometric_mean(&pairs.iter().map(|pair| pair[k]).collect::<Vec<_>>()));
        let (ratio, more) = (left / searched, (left * left - searched * searched).max(0.0).sqrt());
        (ratio > MOST_REFIT && more > MUCH).then_some(Self::Refit { ratio })
    }
}

pub(crate) fn never_move(joints: &[String]) -> String {
    format!("{} never move{}", list(joints), if joints.len() == 1 { "s" } else { "" })
}

/// Names as a sentence has them.
pub fn list(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [name] => name.clone(),
        [before @ .., last] => format!("{} and {last}", before.join(", ")),
    }
}

/// One name, or several, and what they are.
fn are(names: &[String]) -> String {
    format!("{} {}", list(names), if names.len() == 1 { "is" } else { "are" })
}

/// A gain is told where its error is below this part of it.
const TOLD: f64 = 0.2;

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
            Self::Kind { joint, slides } => {
                let [taken, other] = if *slides { ["slide", "turn"] } else { ["turn", "slide"] };
                write!(
                    f,
                    "{joint} is taken to {taken}, as the log does not tell: if it {other}s, masses, payloads \
                     and robot files are wrong until its kind is said"
                )
            }
            Self::Range { joint, range } => write!(
                f,
                "{joint} turns through {range:.2} rad only: gravity and inertia that depend on its \
                 angle are guesses; swing it further, or say that it slides"
            ),
            Self::Speed { joints, peak } => write!(
                f,
                "{} hardly ever faster than {peak:.2} rad/s: Coriolis terms and viscous friction there \
                 are guesses; drive faster, forward and backward",
                are(joints)
            ),
            Self::Acceleration { joints, peak } => write!(
                f,
                "{} hardly ever accelerated by more than {peak:.2} rad/s²: inertia there is a guess; \
                 start and stop more sharply",
                are(joints)
            ),
            Self::OneWay { joint, forward } => write!(
                f,
                "{joint} moves {} only: dry friction cannot be told from an offset of its torque; \
                 move it back as slowly as forth",
                if *forward { "forward" } else { "backward" }
            ),
            Self::Together { joints, correlation } => write!(
                f,
                "{} always move together (correlation {correlation:.3}): what each of them causes \
                 cannot be told apart; move one while the others rest",
                list(joints)
            ),
            Self::Commanded { joint, residual } => write!(
                f,
                "the torque of {joint} follows from the positions alone (but for {:.2} %) though \
                 it accelerates: is it the command of a gravity compensation, and someone's hand \
                 does the rest? Record measured torque of a driven arm",
                100.0 * residual
            ),
            Self::Velocity { joints } => write!(
                f,
                "the torque of {} is the velocity: are columns exchanged? Check names, or the profile",
                list(joints)
            ),
            Self::Unrelated { joint, residual } => write!(
                f,
                "the torque of {joint} does not follow its motion, {:.0} % of it is something \
                 else: is its motor on, and its sensor fine enough? Leave it out or drive it",
                100.0 * residual
            ),
            Self::Held { joints } => {
                let names: Vec<String> = joints.iter().map(|(joint, _)| joint.clone()).collect();
                f.write_str(&score::note_of_rest(&names))
            }
            Self::Clipped { joint, share } => write!(
                f,
                "the torque of {joint} is at one of its ends in {:.0} % of its motion, as if it \
                 were cut off: check the limits of its drive and sensor, and drive it more gently",
                100.0 * share
            ),
            Self::Gains { joints, gains } => {
                let (told, untold): (Vec<_>, Vec<_>) =
                    (joints.iter().zip(gains)).partition(|(_, [gain, error])| *error < TOLD * gain);
                let told =
                    told.iter().map(|(own, [gain, error])| format!("{own} {gain:.3} ± {error:.3}"));
                let told: Vec<String> = told.collect();
                let untold: Vec<String> = untold.iter().map(|(own, _)| (*own).clone()).collect();
                f.write_str(
                    "the torques are not in one unit, as currents of different motors are not",
                )?;
                if !told.is_empty() {
                    write!(
                        f,
                        ": the links that joints share ask for gains of {}; give these as the scale of tau \
                         in a profile, and find their common factor by a payload of known mass",
                        list(&told)
                    )?;
                }
                if untold.is_empty() {
                    return Ok(());
                }
                write!(
                    f,
                    "; the gain of {} is not told, as links load it too little or axes are not known: look \
                     it up, or give a URDF",
                    list(&untold)
                )
            }
            Self::Weightless => write!(
                f,
                "gravity does nothing to the torques: has the driver taken it out of the effort that it \
                 publishes, does a spring or gear bear it, or do all axes stand upright? A model of such \
                 torque lacks it: unless they do, have the driver publish the whole torque, as the \
                 motors give it"
            ),
            Self::Swapped { joints: [one, other] } => write!(
                f,
                "the torque of {one} fits the motion of {other}, and that of {other} the motion of \
                 {one}: check the order of the torque columns"
            ),
            Self::WrongSign { joints } => write!(
                f,
                "turned round, the torque of {} would fit the motion and all other torques: check the \
                 sign of torque, gear or torque constant against the position",
                list(joints)
            ),
            Self::Disagreement(logs) => write!(f, "{logs}"),
            Self::Drift { joint, part, std_error, seconds } => write!(
                f,
                "friction of {joint} {} by {:.0} ± {:.0} % along the log of {:.0} min{}: move the arm \
                 for as long before you record, or expect so much more error when it is cold",
                if *part < 0.0 { "falls" } else { "rises" },
                100.0 * part.abs(),
                100.0 * std_error,
                seconds / 60.0,
                if *part < 0.0 { ", as gears that warm do" } else { "" },
            ),
            Self::Shape { joint, place, shares: [left, rows] } => write!(
                f,
                "{:.0} % of what is missed of {joint} lies in {:.0} % of its rows, {place}",
                100.0 * left,
                100.0 * rows
            ),
            Self::Gravity { line } => write!(
                f,
                "gravity pulls along {line} of the base of the URDF, not as said: does the arm hang on a \
                 wall or a ceiling? Give the direction of gravity, in which things fall"
            ),
            Self::Coordinates { joints } => write!(
                f,
                "the log seems to count joints otherwise than the URDF: with {joints} held-out torque is \
                 missed by far less; if so, say it by scale and offset of a profile"
            ),
            Self::Axes { ratio } => write!(
                f,
                "an arm with axes elsewhere than in the URDF leaves {ratio:.1} times less of the torque: is \
                 it the URDF of this arm, its joints in this order? See what a fit without it finds"
            ),
            Self::Repeated => write!(
                f,
                "two logs hold the same rows, which count twice: errors come out too small; give each \
                 log once"
            ),
            Self::NotPhysical(flaw) => write!(
                f,
                "{flaw}, within the range of the log: simulation and computed torque go wrong there, \
                 and export refuses the model; record more motion, or fit with library chain"
            ),
            Self::Refit { ratio } => write!(
                f,
                "the fit to all rows leaves {ratio:.2} times the torque that the search left on a \
                 sample of them: what the search found is no physical arm, as where the log moves \
                 little, or torque has a wrong sign or unit, or given axes or gravity are not the arm's"
            ),
            Self::Units { joint, what: [what, taken, may_be], largest } => write!(
                f,
                "{joint} reaches {largest:.0}: {what}, or their source, are in {taken}; are these {may_be}?"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Warning;

    #[test]
    fn a_refit_that_leaves_more_than_the_search_is_told() {
        let told = |left: [f64; 2]| Warning::of_refit(&[0.125; 2], &left, &[1.0; 2]);
        assert!(told([0.25, 1.0]).is_some() && told([0.13, 0.13]).is_none());
    }
}
