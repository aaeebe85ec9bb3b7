//! The verdict: may the model be used, and why.

use crate::excitation::{Finding, list};
use crate::reconstruction::Reconstruction;
use crate::unseen::geometric_mean;
use crate::warning::Warning;
use std::fmt;
use torquewise_model::Training;
use torquewise_model::model::GeometryFound;

/// Held-out error over the spread of the torque up to which a model is good, geometric mean of the
/// joints.
const GOOD: f64 = 0.1;
/// From here a prediction is no better than the mean.
const USELESS: f64 = 1.0;

/// May a model be used?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grade {
    /// As it is.
    Good,
    /// With the reasons in mind.
    Usable,
    /// Not without a better log.
    Unusable,
}

/// A grade, and what it rests on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Verdict {
    /// The grade.
    pub grade: Grade,
    /// Why, the gravest first; one sentence part each.
    pub because: Vec<String>,
}

impl Verdict {
    /// From rows that were held out, by time and by region, and what the motion leaves open. Where
    /// there are too few rows to hold any out, a model is at best usable.
    pub fn of(found: &Reconstruction) -> Self {
        let training = &found.model.training;
        let Some(mut errors) = training.held_out_errors() else {
            let mut because = grave(&found.warnings);
            let grade = if because.is_empty() { Grade::Usable } else { Grade::Unusable };
            because.push("too few rows to hold any out".to_owned());
            return Self { grade, because };
        };
        if found.warnings.iter().any(|warning| matches!(warning, Warning::Refit { .. })) {
            // What was judged on held-out rows is not what the refit left.
            let left = training.residual_rms.iter().zip(&training.torque_std);
            for (error, (left, std)) in errors.iter_mut().zip(left) {
                if *std > 0.0 && !error.is_nan() {
                    *error = error.max(left / std);
                }
            }
        }
        let joints = |is: &dyn Fn(f64) -> bool| -> Vec<String> {
            let named = found.model.joints.iter().zip(&errors);
            named.filter(|(_, error)| is(**error)).map(|(name, _)| name.clone()).collect()
        };
        let useless = joints(&|error| error.is_nan() || error >= USELESS);
        let poor = joints(&|error| (Training::POOR..USELESS).contains(&error));
        let grave = grave(&found.warnings);
        let doubts = doubts(found);
        let mut because = grave;
        if !useless.is_empty() {
            because.push(format!(
                "held-out torque of {} is predicted no better than by its mean",
                list(&useless)
            ));
        }
        let grade = if !because.is_empty() {
            Grade::Unusable
        } else if geometric_mean(&errors) <= GOOD && poor.is_empty() && doubts.is_empty() {
            Grade::Good
        } else {
            Grade::Usable
        };
        because.extend(doubts);
        because.extend(one_way(&found.warnings));
        if !poor.is_empty() {
            because.push(format!(
                "held-out torque of {} is missed by more than {:.0} % of its spread",
                list(&poor),
                100.0 * Training::POOR
            ));
        }
        let (least, most) = errors
            .iter()
            .fold((f64::INFINITY, 0.0_f64), |(least, most), e| (least.min(*e), most.max(*e)));
        because.push(format!(
            "held-out error {:.2} to {:.2} % of the spread of the torque",
            100.0 * least,
            100.0 * most
        ));
        Self { grade, because }
    }
}

/// What makes a model useless whatever the error on its own log.
pub(crate) fn grave(warnings: &[Warning]) -> Vec<String> {
    let of = |warning: &Warning| match warning {
        Warning::Excitation(Finding::Together { joints, .. }) => {
            Some(format!("{} always move together", list(joints)))
        }
        Warning::Excitation(Finding::WrongSign { joint }) => {
            Some(format!("the torque of {joint} has the wrong sign"))
        }
        Warning::Excitation(Finding::Swapped { joints: [one, other] }) => {
            Some(format!("the torques of {one} and {other} seem to be swapped"))
        }
        Warning::Excitation(Finding::Gains { .. }) => {
            Some("the torques of the joints are not in one unit".to_owned())
        }
        Warning::Excitation(Finding::Clipped { joint, .. }) => {
            Some(format!("the torque of {joint} is cut off"))
        }
        Warning::Excitation(Finding::Unrelated { joint, .. }) => {
            Some(format!("the torque of {joint} does not follow its motion"))
        }
        Warning::Excitation(Finding::Commanded { joint, .. }) => {
            Some(format!("the torque of {joint} is a command, no measurement"))
        }
        Warning::Disagreement(_) => Some("logs disagree in what gravity does".to_owned()),
        Warning::Units { joint, .. } => Some(format!("{joint} may be in degrees")),
        _ => None,
    };
    warnings.iter().filter_map(of).collect()
}

/// What keeps a model from being good, whatever its error on held-out rows.
fn doubts(found: &Reconstruction) -> Vec<String> {
    let at_rest = found.warnings.iter().filter_map(|warning| match warning {
        Warning::ConstantJoint { joint } => Some(format!("{joint} never moves")),
        Warning::Excitation(Finding::Weightless) => Some("gravity does nothing".to_owned()),
        Warning::Sliding { .. } => Some("joints seem to slide".to_owned()),
        _ => None,
    });
    let geometry = found.model.training.geometry_found.as_ref().filter(|found| !found.is_certain());
    let geometry = geometry.map(|GeometryFound { times, starts, .. }| {
        format!("its geometry was found by only {times} of {starts} starts")
    });
    let refit = found.warnings.iter().find_map(|warning| match warning {
        Warning::Refit { .. } => Some("all rows are fitted worse than a sample of them".to_owned()),
        _ => None,
    });
    at_rest.chain(geometry).chain(refit).collect()
}

/// Joints of which only one direction was seen.
fn one_way(warnings: &[Warning]) -> Option<String> {
    let of = |warning: &Warning| match warning {
        Warning::Excitation(Finding::OneWay { joint, .. }) => Some(joint.clone()),
        _ => None,
    };
    let joints: Vec<String> = warnings.iter().filter_map(of).collect();
    (!joints.is_empty()).then(|| format!("{}: seen in one direction only", list(&joints)))
}

impl fmt::Display for Grade {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Good => "good",
            Self::Usable => "usable",
            Self::Unusable => "unusable",
        })
    }
}

impl fmt::Display for Verdict {
    /// One line, without a line break.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.grade, self.because.join("; "))
    }
}
