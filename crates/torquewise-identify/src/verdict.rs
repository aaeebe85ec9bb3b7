//! The verdict: may the model be used, and why.

use crate::warning::{list, never_move};
use crate::{Reconstruction, Warning, geometric_mean};
use torquewise_model::{GeometryFound, Model, Training};
use torquewise_stepwise::held_out::mean;

pub use torquewise_model::verdict::{Grade, Verdict};

/// Held-out error over the spread of the torque up to which a model is good, geometric mean of the
/// joints.
const GOOD: f64 = 0.1;
/// From here a prediction is hardly better than the mean: four fifths of the squares are left.
const USELESS: f64 = 0.9;
/// A model that misses this part of the spread in the mean of the joints is of no use.
pub(crate) const HALF: f64 = 0.5;

/// Percentage of the torque of a test that believable 95 % intervals hold in the mean of the joints.
const HELD: f64 = 80.0;

/// Errors over the spread of the torque, by joint, of the rows of a name: where the arm also went in
/// other rows, and the larger of these and of those in regions held out.
type Judged<'a> = (&'static str, Vec<(&'a String, [f64; 2])>);

/// The verdict from rows that were held out, by time and by region, and what the motion leaves open.
/// Where there are too few rows to hold any out, a model is at best usable.
pub fn judge(found: &Reconstruction) -> Verdict {
    let judged = errors(found);
    let mut doubts = doubts(found);
    let mut grave = grave(&found.warnings);
    // Unlike what is grave whatever the axes, it does not keep these from being doubted.
    if found.warnings.iter().any(|own| matches!(own, Warning::Gravity { .. })) {
        grave.push("gravity pulls elsewhere than was said".to_owned());
    }
    if found.model.training.torque_std.iter().all(|std| *std == 0.0) {
        grave.push("no torque ever changes".to_owned());
    } else if judged[0].1.is_empty() {
        doubts.push("too few rows to hold any out".to_owned());
    }
    let mut verdict = graded(grave, doubts, &judged);
    verdict.because.extend(one_way(&found.warnings));
    verdict
}

/// The verdict of a log of another motion: the worse of that by its own fit, where the model keeps
/// one, and that by how the log is predicted.
///
/// - `errors`: over the spread of the torque, n; one that is not finite, as that of a torque that never
///   changes, tells nothing
/// - `held`: percentage of the torques within their 95 % intervals, n; none where a model has no errors
pub fn judge_by(model: &Model, errors: &[f64], held: Option<&[f64]>) -> Verdict {
    let named = model.joints.iter().zip(errors.iter().map(|error| [*error; 2]));
    let named: Vec<_> = named.filter(|(_, [error, _])| error.is_finite()).collect();
    let unchanging = named
        .is_empty()
        .then(|| "no joint of the test moves, or no torque of the test changes".to_owned());
    let held = held.map(mean).filter(|held| *held < HELD);
    let held = held.map(|held| format!("its 95 % intervals hold {held:.0} % of the test torque"));
    let doubts = unchanging.into_iter().chain(held).collect();
    let verdict = graded(Vec::new(), doubts, &[("test", named)]);
    match &model.training.verdict {
        Some(own) => own.clone().with(verdict),
        None => verdict,
    }
}

/// The verdict where some reasons make a model useless, doubts keep it from being good, and the larger
/// errors decide what else there is. A model that is lost where the arm never was may still be of use.
fn graded(mut because: Vec<String>, doubts: Vec<String>, judged: &[Judged<'_>]) -> Verdict {
    let judged = judged.iter().filter(|(_, errors)| !errors.is_empty());
    let missed = |is: &dyn Fn([f64; 2]) -> bool, how: &str| -> Vec<String> {
        let of = |(rows, errors): &Judged<'_>| {
            let named = errors.iter().filter(|(_, error)| is(*error));
            let named: Vec<String> = named.map(|(name, _)| (*name).clone()).collect();
            (!named.is_empty()).then(|| format!("{rows} torque of {} is {how}", list(&named)))
        };
        judged.clone().filter_map(of).collect()
    };
    let is_useless = |error: f64| error.is_nan() || error >= USELESS;
    let lost = "predicted hardly better than by its mean";
    because.extend(missed(&|[near, _]| is_useless(near), lost));
    let elsewhere = format!("{lost} in regions held out");
    let mut poor = missed(&|[near, error]| !is_useless(near) && is_useless(error), &elsewhere);
    let how = format!("missed by more than {:.0} % of its spread", 100.0 * Training::POOR);
    poor.extend(missed(&|[_, error]| (Training::POOR..USELESS).contains(&error), &how));
    let [near, all] = [0, 1];
    let errors_of = |errors: &[(&String, [f64; 2])], which: usize| -> Vec<f64> {
        errors.iter().map(|(_, error)| error[which]).collect()
    };
    let mean = |which| {
        let means = judged.clone().map(|(_, own)| geometric_mean(&errors_of(own, which)));
        means.fold(0.0, f64::max)
    };
    let (missed, mean) = (mean(near), mean(all));
    if missed >= HALF && because.is_empty() {
        let missed = 100.0 * missed;
        because.push(format!("{missed:.0} % of the torque is missed in the mean of the joints"));
    }
    let has_no_doubt = poor.is_empty() && doubts.is_empty();
    let grade = match because.is_empty() {
        false => Grade::Unusable,
        true if has_no_doubt && mean <= GOOD => Grade::Good,
        true => Grade::Usable,
    };
    because.extend(doubts.into_iter().chain(poor));
    because.extend(judged.map(|(rows, errors)| {
        let [least, most] =
            [f64::min, f64::max].map(|of| errors_of(errors, all).into_iter().reduce(of));
        let [least, most] = [least, most].map(|error| 100.0 * error.unwrap_or_default());
        format!("{rows} error {least:.2} to {most:.2} % of the spread of the torque")
    }));
    if grade == Grade::Usable && has_no_doubt {
        let [mean, good] = [mean, GOOD].map(|error| 100.0 * error);
        because.push(format!("{mean:.1} % in the mean of the joints, over {good:.0} %"));
    }
    Verdict { grade, because }
}

/// Errors of the joints that move, if any does, and whose torque changes, without what friction may hold
/// at rest, on the rows that judge: those held out, and all where a refit left more.
fn errors(found: &Reconstruction) -> [Judged<'_>; 2] {
    let (training, still) = (&found.model.training, found.survey.constant_joints());
    let all_rest = found.survey.stands_still();
    let named = |errors: Vec<[f64; 2]>| {
        let named = found.model.joints.iter().zip(errors);
        let unheld = |joint, error| unheld(&found.warnings, joint, error);
        let named = named.map(|(joint, errors)| (joint, errors.map(|error| unheld(joint, error))));
        let named = named.zip(&training.torque_std).enumerate();
        let counts = |joint, std: f64| std > 0.0 && (all_rest || !still.contains(&joint));
        let named = named.filter(|(joint, (_, std))| counts(*joint, **std));
        named.map(|(_, (named, _))| named).collect::<Vec<_>>()
    };
    let near = training.held_out_rms.iter().zip(&training.torque_std).map(|(rms, std)| rms / std);
    let larger = training.held_out_errors().unwrap_or_default();
    let held_out = named(near.zip(larger).map(|(near, larger)| [near, larger]).collect());
    let is_refit = found.warnings.iter().any(|own| matches!(own, Warning::Refit { .. }));
    // What was judged on held-out rows is not what a refit left.
    let left = training.residual_rms.iter().zip(&training.torque_std).map(|(rms, std)| rms / std);
    let mut fitted = named(left.filter(|_| is_refit).map(|error| [error; 2]).collect());
    fitted.retain(|(_, [error, _])| error.is_finite());
    [("held-out", held_out), ("fitted", fitted)]
}

/// What is left of an error, over the spread of the torque, without what friction may hold at rest.
pub(crate) fn unheld(warnings: &[Warning], joint: &str, error: f64) -> f64 {
    let held = warnings.iter().find_map(|own| match own {
        Warning::Held { joints } => joints.iter().find(|(name, _)| name == joint),
        _ => None,
    });
    held.map_or(error, |(_, held)| (error * error - held * held).max(0.0).sqrt())
}

/// What makes a model useless whatever the error on its own log.
pub(crate) fn grave(warnings: &[Warning]) -> Vec<String> {
    let of = |warning: &Warning| match warning {
        Warning::Together { joints, .. } => Some(format!("{} always move together", list(joints))),
        Warning::WrongSign { joints } => {
            Some(format!("the torque of {} has the wrong sign", list(joints)))
        }
        Warning::Swapped { joints: [one, other] } => {
            Some(format!("the torques of {one} and {other} seem to be swapped"))
        }
        Warning::Gains { .. } => Some("the torques of the joints are not in one unit".to_owned()),
        Warning::Clipped { joint, .. } => Some(format!("the torque of {joint} is cut off")),
        Warning::Unrelated { joint, .. } => {
            Some(format!("the torque of {joint} does not follow its motion"))
        }
        Warning::Commanded { joint, .. } => {
            Some(format!("the torque of {joint} is a command, no measurement"))
        }
        Warning::Velocity { joints } => {
            Some(format!("the torque of {} is the velocity", list(joints)))
        }
        Warning::Disagreement(_) => Some("logs disagree in what gravity does".to_owned()),
        Warning::Units { joint, what: ["positions", ..], .. } => {
            Some(format!("{joint} may be in degrees"))
        }
        _ => None,
    };
    let mut reasons: Vec<String> = warnings.iter().filter_map(of).collect();
    // Those of one kind stand beside each other.
    reasons.dedup();
    reasons
}

/// What keeps a model from being good, whatever its error on held-out rows.
fn doubts(found: &Reconstruction) -> Vec<String> {
    let at_rest = found.warnings.iter().filter_map(|warning| match warning {
        Warning::ConstantJoints { joints } => Some(never_move(joints)),
        Warning::Weightless => Some("gravity does nothing".to_owned()),
        Warning::Sliding { .. } => Some("joints seem to slide".to_owned()),
        Warning::Axes { .. } => Some("axes elsewhere than in the URDF leave less".to_owned()),
        Warning::Coordinates { .. } => {
            Some("joints seem to be counted otherwise than in the URDF".to_owned())
        }
        Warning::ConstantTorque { joint } => Some(format!("the torque of {joint} never changes")),
        Warning::Repeated => Some("a log was given twice".to_owned()),
        Warning::NotPhysical(_) => Some("M(q) is not positive definite".to_owned()),
        _ => None,
    });
    let geometry = found.model.training.geometry_found.as_ref().filter(|found| !found.is_certain());
    let geometry = geometry.map(|GeometryFound { times, starts, .. }| {
        let asked = GeometryFound::CERTAIN;
        format!("its geometry was found by only {times} of {starts} starts, fewer than {asked}")
    });
    let is_refit = found.warnings.iter().any(|own| matches!(own, Warning::Refit { .. }));
    let refit = is_refit.then(|| "the fit leaves more than the search for the arm did".to_owned());
    at_rest.chain(geometry).chain(refit).collect()
}

/// Joints of which only one direction was seen.
fn one_way(warnings: &[Warning]) -> Option<String> {
    let of = |warning: &Warning| match warning {
        Warning::OneWay { joint, .. } => Some(joint.clone()),
        _ => None,
    };
    let joints: Vec<String> = warnings.iter().filter_map(of).collect();
    (!joints.is_empty()).then(|| format!("{}: seen in one direction only", list(&joints)))
}
