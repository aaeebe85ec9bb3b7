//! Joints whose gravity differs from log to log.

use crate::clustered::Stretches;
use crate::verdict::HALF;
use std::fmt;
use std::ops::RangeInclusive;
use torquewise_model::{Model, Torque};
use torquewise_motion::{Motion, Recording};
use torquewise_stepwise::IdentifyError;

/// Two logs in which gravity loads joints differently, as under another payload.
#[derive(Clone, Debug, PartialEq)]
pub struct Disagreement {
    /// Their names.
    pub logs: [String; 2],
    /// The joints at odds, base to tip.
    pub joints: Vec<JointAtOdds>,
}

/// A joint whose gravity torque differs between two logs.
#[derive(Clone, Debug, PartialEq)]
pub struct JointAtOdds {
    /// Its name.
    pub joint: String,
    /// By what part of itself the gravity of the model falls short in each of the two logs.
    pub excess: [f64; 2],
    /// Standard errors of these.
    pub std_error: [f64; 2],
}

/// Logs that are compared at most; later ones are not.
const MOST_LOGS: usize = 1_000;
/// Batches of a log at most: then neighbours are joined.
const MOST_BATCHES: usize = 16;
/// Fewer batches give no standard error.
const LEAST_BATCHES: usize = 6;
/// A difference of excess outside these is no payload worth a word, or what hardly weighs.
const DIFFERENCE: RangeInclusive<f64> = 0.03..=30.0;
/// A difference below this many standard errors is chance.
const LEAST_ERRORS: f64 = 6.0;
/// Gravity must explain this part of the residual that the other columns leave in one log.
const LEAST_SHARE: f64 = 0.2;
/// Part of the squares of gravity that no other column may explain.
const LEAST_FREE: f64 = 1e-3;
/// A load is worth this part at least of what the model misses of other motion, which logs that contradict
/// each other make larger.
const LEAST_MISSED: f64 = 0.5;
/// Of two logs, gravity must make this part of the squares in one that it makes in the other.
const LEAST_SIZE: f64 = 0.01;

/// Columns beside each other: gravity, inertia, one, speed and its sign.
const COLUMNS: usize = 5;

/// The joints whose gravity differs between logs that one model was fitted to.
///
/// In each log and for each joint, what the model leaves of the torque is regressed on the
/// gravity of the model, r = a G + b + …, beside its inertia, a constant, the speed and its sign,
/// which take what a warmer gear changes. Rows at which the joint rests say nothing: a brake may hold it,
/// or its friction. A payload adds to gravity in proportion, so that a is
/// positive with it and negative without. Standard errors are those of sums over some 10
/// stretches of time (clusters), since neighbouring residuals are alike. One pass, fixed memory
/// per log.
///
/// - `log_of`: name of the log that a trajectory of the recording belongs to
/// - returns: for each joint the two logs that differ most, joints with the same two logs together;
///   none for a single log
///
/// # Errors
/// [`IdentifyError`]: the reader's message, missing torque, or a model of another arm.
pub fn disagreements(
    model: &Model,
    recording: &(impl Recording + ?Sized),
    log_of: &dyn Fn(usize) -> String,
) -> Result<Vec<Disagreement>, IdentifyError> {
    model.check_joints(recording.joints())?;
    let (torque, slow) = (Torque::new(model), model.rest_speeds());
    let mut logs = Logs { torque, slow, each: Vec::new() };
    let mut path = logs.torque.path();
    recording.read(&mut |trajectory, block| {
        let Some(place) = logs.place(log_of(trajectory)) else { return Ok(()) };
        logs.add(place, &path.follow(trajectory, block))
    })?;
    Ok(logs.compared(model))
}

/// What was summed of each log.
struct Logs {
    torque: Torque,
    slow: Vec<f64>,
    each: Vec<(String, Vec<Stretches>)>,
}

impl Logs {
    fn place(&mut self, name: String) -> Option<usize> {
        // Blocks of a log follow one another.
        let known = self.each.iter().rposition(|(known, _)| *known == name);
        if known.is_none() && self.each.len() < MOST_LOGS {
            let none = Stretches::new(COLUMNS, MOST_BATCHES, 1);
            self.each.push((name, vec![none; self.slow.len()]));
            return Some(self.each.len() - 1);
        }
        known
    }

    fn add(&mut self, place: usize, block: &Motion) -> Result<(), torquewise_motion::ReadError> {
        let (tau, parts) = (block.require_tau()?, self.torque.parts(block)?);
        let tau_hat = parts.total();
        for (joint, batches) in self.each[place].1.iter_mut().enumerate() {
            for row in 0..block.n_rows() {
                let dq = block.dq()[(row, joint)];
                if dq.abs() < self.slow[joint] {
                    continue;
                }
                let sign = (dq / self.slow[joint]).tanh();
                let (gravity, inertia) = (parts.gravity[(row, joint)], parts.inertia[(row, joint)]);
                let residual = tau[(row, joint)] - tau_hat[(row, joint)];
                batches.add(&[gravity, inertia, 1.0, dq, sign], residual, 1.0);
            }
        }
        Ok(())
    }

    fn compared(&self, model: &Model) -> Vec<Disagreement> {
        let mut found: Vec<Disagreement> = Vec::new();
        let training = &model.training;
        let unseen = training.unseen_rms();
        let parts = training.residual_rms.iter().zip(&training.torque_std);
        // What is missed of a torque that follows the model but little says nothing of its gravity.
        let follows: Vec<bool> = parts.map(|(rms, std)| *rms < HALF * std).collect();
        for (joint, name) in model.joints.iter().enumerate() {
            if follows.get(joint) == Some(&false) {
                continue;
            }
            let slopes = self.each.iter().enumerate();
            let slopes: Vec<(usize, Slope)> =
                slopes.filter_map(|(log, (_, own))| Some((log, slope(&own[joint])?))).collect();
            let missed = unseen.get(joint).copied().unwrap_or_default();
            let Some([(one, a), (other, b)]) = most_apart(&slopes, missed) else { continue };
            let logs = [one, other].map(|log| self.each[log].0.clone());
            let at_odds = JointAtOdds {
                joint: name.clone(),
                excess: [a.value, b.value],
                std_error: [a.error, b.error],
            };
            match found.iter_mut().find(|known| known.logs == logs) {
                Some(known) => known.joints.push(at_odds),
                None => found.push(Disagreement { logs, joints: vec![at_odds] }),
            }
        }
        found
    }
}

/// The two slopes that differ by most errors, if they differ enough, and no third that is known as well
/// lies between them, told from neither: what changes little by little is no load that was taken up.
///
/// - `missed`: what the model misses of other motion \[N·m\]
fn most_apart(slopes: &[(usize, Slope)], missed: f64) -> Option<[(usize, Slope); 2]> {
    let pairs = slopes
        .iter()
        .enumerate()
        .flat_map(|(place, one)| slopes[place + 1..].iter().map(move |other| [*one, *other]));
    let errors = |[(_, a), (_, b)]: &[(usize, Slope); 2]| a.errors_from(b);
    pairs
        .filter(|pair| {
            let [(_, a), (_, b)] = pair;
            let is_between = |(_, own): &(usize, Slope)| {
                own.error <= a.error.max(b.error)
                    && [a, b].iter().all(|end| own.errors_from(end) <= LEAST_ERRORS)
            };
            let apart = (a.value - b.value).abs();
            DIFFERENCE.contains(&apart)
                && apart * a.size.min(b.size).sqrt() > LEAST_MISSED * missed
                && a.size.min(b.size) > LEAST_SIZE * a.size.max(b.size)
                && a.share.max(b.share) > LEAST_SHARE
                && errors(pair) > LEAST_ERRORS
                && !slopes.iter().any(is_between)
        })
        .max_by(|one, other| errors(one).total_cmp(&errors(other)))
}

/// How the residual of a joint grows with its gravity in one log.
#[derive(Clone, Copy, Debug)]
struct Slope {
    value: f64,
    error: f64,
    /// Part of the squares that the other columns leave which gravity explains.
    share: f64,
    /// Mean square of what the other columns leave of gravity itself.
    size: f64,
}

impl Slope {
    /// By how many standard errors of both it differs from another.
    fn errors_from(&self, other: &Self) -> f64 {
        (self.value - other.value).abs() / self.error.hypot(other.error).max(f64::MIN_POSITIVE)
    }
}

/// `None` if gravity hardly changes, or too little was recorded.
fn slope(of: &Stretches) -> Option<Slope> {
    let total = of.total();
    if of.all().count() < LEAST_BATCHES || total.rows < 4.0 * COLUMNS as f64 {
        return None;
    }
    let solved = of.solved()?;
    if solved.free[0] < LEAST_FREE {
        return None;
    }
    let gained = solved.gained[0];
    Some(Slope {
        value: solved.values[0],
        error: solved.std_errors[0],
        share: gained / (gained + solved.left).max(f64::MIN_POSITIVE),
        size: solved.free[0] * total.gram[(0, 0)] / total.rows,
    })
}

impl fmt::Display for Disagreement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [one, other] = &self.logs;
        let percent = |JointAtOdds { joint, excess: [a, b], .. }: &JointAtOdds| {
            format!("{joint} ({:+.0} % / {:+.0} %)", 100.0 * a, 100.0 * b)
        };
        let joints: Vec<String> = self.joints.iter().map(percent).collect();
        write!(
            f,
            "{one} and {other} disagree about the gravity of {}: another payload, tool or \
             mounting? Take them apart, or leave one out",
            joints.join(", ")
        )
    }
}

#[cfg(test)]
mod tests {
    use super::{COLUMNS, MOST_BATCHES, Slope, Stretches, most_apart, slope};
    use faer::Mat;

    #[test]
    fn the_slope_is_that_of_least_squares_however_long_the_log() {
        for rows in [100, 1_000, 20_000] {
            let x = |row: i32| {
                let t = 0.07 * f64::from(row);
                [2.0 + t.sin(), (3.0 * t).sin(), 1.0, t.cos(), t.cos().signum()]
            };
            let residual = |row: i32| {
                let [gravity, inertia, one, dq, sign] = x(row);
                let noise = 0.1 * (f64::from(row) * 12.9898).sin();
                0.07 * gravity + 0.3 * inertia - one + 0.2 * dq + 0.5 * sign + noise
            };
            let mut batches = Stretches::new(COLUMNS, MOST_BATCHES, 1);
            (0..rows).for_each(|row| batches.add(&x(row), residual(row), 1.0));

            let slope = slope(&batches).unwrap();

            let columns = Mat::from_fn(rows.unsigned_abs() as usize, 5, |row, i| {
                x(i32::try_from(row).unwrap())[i]
            });
            let y =
                Mat::from_fn(columns.nrows(), 1, |row, _| residual(i32::try_from(row).unwrap()));
            let exact = faer::linalg::solvers::SolveLstsq::solve_lstsq(&columns.qr(), &y);
            // The ridge of 1e-10 and normal equations.
            assert!((slope.value - exact[(0, 0)]).abs() < 1e-7, "{slope:?} {exact:?}");
            assert!((slope.value - 0.07).abs() < 5.0 * slope.error + 1e-7, "{slope:?}");
            assert!(batches.all().count() <= MOST_BATCHES);
        }
    }

    #[test]
    fn what_changes_little_by_little_from_log_to_log_is_no_load() {
        let with = |value, error| Slope { value, error, share: 0.9, size: 1.0 };

        let both = [(0, with(0.0, 0.02)), (1, with(0.2, 0.02))];
        assert!(most_apart(&both, 0.0).is_some());
        assert!(most_apart(&[both[0], both[1], (2, with(0.19, 0.02))], 0.0).is_some());
        assert!(most_apart(&[both[0], both[1], (2, with(0.1, 0.02))], 0.0).is_none());
        // A log that says little is no witness.
        assert!(most_apart(&[both[0], both[1], (2, with(0.1, 0.1))], 0.0).is_some());
    }

    #[test]
    fn logs_with_hardly_any_gravity_say_nothing() {
        let with = |value, size| Slope { value, error: 1e-3, share: 0.9, size };

        assert!(most_apart(&[(0, with(0.0, 1.0)), (1, with(0.5, 0.02))], 0.0).is_some());
        assert!(most_apart(&[(0, with(0.0, 1.0)), (1, with(0.5, 0.005))], 0.0).is_none());
    }
}
