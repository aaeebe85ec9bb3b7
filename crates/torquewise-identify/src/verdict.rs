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
/// A test log whose error is this many times that of held-out rows is told.
const BEYOND: f64 = 2.0;

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
    ///
    /// - `test`: errors on a log of another motion over the spread of its torque, n or none: the
    ///   grade is that of the larger errors. A torque that never changes tells nothing.
    pub fn of(found: &Reconstruction, test: &[f64]) -> Self {
        let joints = &found.model.joints;
        let held_out = held_out(found);
        let same = |joint: usize| held_out.get(joint).copied().unwrap_or_default();
        let test = test.iter().enumerate();
        let test: Vec<f64> = test.map(|(k, e)| if e.is_finite() { *e } else { same(k) }).collect();
        let judged = [("held-out", &held_out), ("test", &test)];
        let judged = judged.into_iter().filter(|(_, errors)| !errors.is_empty());
        let missed = |is: &dyn Fn(f64) -> bool, how: &str| -> Vec<String> {
            let of = |(rows, errors): (&str, &Vec<f64>)| {
                let named = joints.iter().zip(errors).filter(|(_, error)| is(**error));
                let named: Vec<String> = named.map(|(name, _)| name.clone()).collect();
                (!named.is_empty()).then(|| format!("{rows} torque of {} is {how}", list(&named)))
            };
            judged.clone().filter_map(of).collect()
        };
        let mut because = grave(&found.warnings);
        let is_useless = |error: f64| error.is_nan() || error >= USELESS;
        because.extend(missed(&is_useless, "predicted no better than by its mean"));
        let how = format!("missed by more than {:.0} % of its spread", 100.0 * Training::POOR);
        let poor = missed(&|error| (Training::POOR..USELESS).contains(&error), &how);
        let doubts = doubts(found);
        let mean = judged.clone().map(|(_, errors)| geometric_mean(errors)).fold(0.0, f64::max);
        let has_no_doubt = !held_out.is_empty() && poor.is_empty() && doubts.is_empty();
        let grade = match because.is_empty() {
            false => Grade::Unusable,
            true if has_no_doubt && mean <= GOOD => Grade::Good,
            true => Grade::Usable,
        };
        because.extend(doubts);
        because.extend(one_way(&found.warnings));
        because.extend(poor);
        because.extend(beyond(joints, &held_out, &test));
        if held_out.is_empty() {
            because.push("too few rows to hold any out".to_owned());
        }
        because.extend(judged.map(|(rows, errors)| {
            let [least, most] = [f64::min, f64::max].map(|of| errors.iter().copied().reduce(of));
            let [least, most] = [least, most].map(|error| 100.0 * error.unwrap_or_default());
            format!("{rows} error {least:.2} to {most:.2} % of the spread of the torque")
        }));
        if grade == Grade::Usable && has_no_doubt {
            let [mean, good] = [mean, GOOD].map(|error| 100.0 * error);
            because.push(format!("{mean:.1} % in the mean of the joints, over {good:.0} %"));
        }
        Self { grade, because }
    }
}

/// Errors on held-out rows over the spread of the torque, n, those of the residual where a refit left
/// more; none where no rows could be held out.
pub fn held_out(found: &Reconstruction) -> Vec<f64> {
    let training = &found.model.training;
    let mut errors = training.held_out_errors().unwrap_or_default();
    if found.warnings.iter().any(|warning| matches!(warning, Warning::Refit { .. })) {
        // What was judged on held-out rows is not what the refit left.
        let left = training.residual_rms.iter().zip(&training.torque_std);
        for (error, (left, std)) in errors.iter_mut().zip(left) {
            if *std > 0.0 && !error.is_nan() {
                *error = error.max(left / std);
            }
        }
    }
    errors
}

/// The joint that a test log shows to be furthest beyond what held-out rows promise.
fn beyond(joints: &[String], held_out: &[f64], test: &[f64]) -> Option<String> {
    let all = joints.iter().zip(held_out.iter().zip(test));
    let beyond = all.filter(|(_, (own, test))| **test > BEYOND * **own);
    let (name, (own, test)) = beyond.max_by(|a, b| (a.1.1 / a.1.0).total_cmp(&(b.1.1 / b.1.0)))?;
    let [own, test] = [own, test].map(|error| 100.0 * error);
    Some(format!(
        "the test log is predicted worse than held-out rows: {name} is missed by {test:.2} %, held \
         out by {own:.2} %"
    ))
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
        let asked = GeometryFound::CERTAIN;
        format!("its geometry was found by only {times} of {starts} starts, fewer than {asked}")
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
