//! What the motion of a log cannot determine, in words a person can act on.

use crate::rough::unexplained_part;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use std::fmt;
use torquewise_motion::Motion;
use torquewise_motion::stats::quantile;
use torquewise_stepwise::survey::{Survey, thinned};

/// Something that the motion of a log leaves open. Joints are named.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
#[expect(missing_docs, reason = "each kind explains its fields")]
pub enum Finding {
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
    /// A torque that does not follow the motion at all: the share that no rough model explains.
    Unrelated { joint: String, residual: f64 },
}

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

/// A torque that a rough model explains no better than this is none of the motion.
const MOST_RESIDUAL: f64 = 0.85;
/// Rows by which a command is recognised.
const COMMAND_ROWS: usize = 2_000;

/// What the motion of a log leaves open, joint by joint; joints that never move are left to the
/// warnings of the survey.
pub fn findings(survey: &Survey) -> Vec<Finding> {
    let motion = &survey.sample;
    let still = survey.constant_joints();
    let joints: Vec<usize> =
        (0..motion.n_joints()).filter(|joint| !still.contains(joint)).collect();
    let peaks: Vec<[f64; 2]> = joints.iter().map(|&joint| peaks(survey, joint)).collect();
    let mut found: Vec<Finding> =
        joints.iter().flat_map(|&joint| of_joint(survey, joint)).collect();
    let lame = |derivative: usize, least: f64| {
        let each = joints.iter().zip(&peaks).map(|(&joint, peaks)| (joint, peaks[derivative]));
        let (lame, peaks): (Vec<usize>, Vec<f64>) = each.filter(|(_, peak)| *peak < least).unzip();
        let names: Vec<String> = lame.iter().map(|&joint| survey.joints[joint].clone()).collect();
        (!names.is_empty()).then(|| (names, peaks.into_iter().fold(0.0, f64::max)))
    };
    let slow = lame(0, LEAST_SPEED).map(|(joints, peak)| Finding::Speed { joints, peak });
    let gentle = lame(1, LEAST_ACCELERATION);
    let gentle = gentle.map(|(joints, peak)| Finding::Acceleration { joints, peak });
    found.extend(slow.into_iter().chain(gentle));
    found.extend(together(survey, &joints));
    let moving: Vec<usize> = joints.into_iter().filter(|joint| moves(survey, *joint)).collect();
    found.extend(commanded(survey, &moving).unwrap_or_default());
    found.extend(moving.iter().filter_map(|&joint| {
        let residual = unexplained_part(motion, joint).filter(|left| *left > MOST_RESIDUAL)?;
        Some(Finding::Unrelated { joint: survey.joints[joint].clone(), residual })
    }));
    found
}

/// Groups of joints of which each moves together with another one of its group.
fn together(survey: &Survey, joints: &[usize]) -> Vec<Finding> {
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
            Finding::Together { joints, correlation }
        })
        .collect()
}

fn of_joint(survey: &Survey, joint: usize) -> Vec<Finding> {
    let name = || survey.joints[joint].clone();
    let mut found = Vec::new();
    let range = survey.range(joint);
    if range < LEAST_RANGE {
        found.push(Finding::Range { joint: name(), range });
    }
    let speeds = survey.sample.dq().col(joint);
    let [forward, backward] =
        [1.0, -1.0].map(|way| speeds.iter().map(|dq| (way * dq).max(0.0)).sum::<f64>());
    if forward.min(backward) < LEAST_SHARE * (forward + backward) {
        found.push(Finding::OneWay { joint: name(), forward: forward > backward });
    }
    found
}

/// Whether a joint moves at all, under a torque that changes; an arm that does so gently must not
/// escape what is looked for.
fn moves(survey: &Survey, joint: usize) -> bool {
    survey.dq_peak[joint] > LEAST_SPEED
        && survey.ddq_peak[joint] > LEAST_ACCELERATION
        && survey.torque_std[joint] > 0.0
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

/// Torques that are what a controller makes of the position: the torque of a real joint that moves
/// holds friction and inertia too. `None` where that cannot be told.
fn commanded(survey: &Survey, joints: &[usize]) -> Option<Vec<Finding>> {
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
        (residual < LEAST_RESIDUAL)
            .then(|| Finding::Commanded { joint: survey.joints[joint].clone(), residual })
    };
    Some(joints.iter().filter_map(of_joint).collect())
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

impl fmt::Display for Finding {
    #[expect(clippy::too_many_lines, reason = "a table of sentences")]
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
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
            Self::Unrelated { joint, residual } => write!(
                f,
                "the torque of {joint} does not follow its motion, {:.0} % of it is something \
                 else: is its motor on, and its sensor fine enough? Leave it out or drive it",
                100.0 * residual
            ),
            Self::Clipped { joint, share } => write!(
                f,
                "the torque of {joint} is at one of its ends in {:.0} % of its motion, as if it \
                 were cut off: check the limits of its drive and sensor, and drive it more gently",
                100.0 * share
            ),
            Self::Gains { joints, gains } => {
                let each = joints.iter().zip(gains);
                let each: Vec<String> = each
                    .map(|(own, [gain, error])| format!("{own} {gain:.3} ± {error:.3}"))
                    .collect();
                write!(
                    f,
                    "the torques are not in one unit, as currents of different motors are not: the \
                     links that joints share ask for gains of {}; give these as the scale of tau in \
                     a profile, and find their common factor by a payload of known mass",
                    list(&each)
                )
            }
            Self::Weightless => write!(
                f,
                "gravity does nothing to the torques: has the driver taken it out of the effort that it \
                 publishes, or does a spring or gear bear it? A model of such torque lacks it: have \
                 the driver publish the whole torque, as the motors give it"
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
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Finding, findings};
    use faer::Mat;
    use torquewise_motion::{Motion, Signals};
    use torquewise_stepwise::survey::survey;

    /// A sine per joint, (amplitude, rate, phase), and a smaller and faster one, without which
    /// inertia and gravity look the same; torque by `tau`.
    fn log(sines: [(f64, f64, f64); 2], tau: impl Fn([f64; 3]) -> f64) -> Motion {
        let t: Vec<f64> = (0..2_000).map(|row| 0.01 * f64::from(row)).collect();
        let of = |order: i32| {
            let t = t.clone();
            Mat::from_fn(t.len(), 2, move |row, joint| {
                let (amplitude, rate, phase) = sines[joint];
                let quarter = f64::from(order) * std::f64::consts::FRAC_PI_2;
                let wave = |size: f64, rate: f64| {
                    size * amplitude * rate.powi(order) * (rate * t[row] + phase + quarter).sin()
                };
                wave(1.0, rate) + wave(0.3, 2.3 * rate)
            })
        };
        let (q, dq, ddq) = (of(0), of(1), of(2));
        let torque = |row: usize, j: usize| tau([q[(row, j)], dq[(row, j)], ddq[(row, j)]]);
        let tau = Some(Mat::from_fn(t.len(), 2, torque));
        let joints = vec!["hip".into(), "knee".into()];
        Motion::new(Signals { joints, t, q, dq, ddq, tau }).unwrap()
    }

    fn of(log: &Motion) -> Vec<Finding> {
        findings(&survey(log).unwrap())
    }

    #[test]
    fn what_spoils_a_log_is_told_and_a_lively_one_leaves_nothing_open() {
        let lively = |tau: fn([f64; 3]) -> f64| of(&log([(1.0, 3.0, 0.0), (0.8, 4.3, 1.0)], tau));
        let sound = lively(|[q, dq, ddq]| 3.0 * q.sin() + 0.4 * dq.signum() + 0.2 * ddq);
        assert_eq!(sound, []);

        let off = lively(|[q, dq, ddq]| 0.01 * (1e4 * (q + 2.0 * dq + 3.0 * ddq)).sin());
        assert_eq!(off.len(), 2, "{off:?}");
        assert!(off.iter().all(|finding| matches!(finding, Finding::Unrelated { .. })));
        let led_by_hand = lively(|[q, ..]| 3.31 * q.sin());
        assert_eq!(led_by_hand.len(), 2);
        assert!(led_by_hand.iter().all(|finding| matches!(finding, Finding::Commanded { .. })));
        let step = log([(1.0, 3.0, 0.0), (0.8, 3.0, 0.0)], |[q, dq, ddq]| q + dq + ddq);
        assert!(matches!(&of(&step)[..], [Finding::Together { .. }]));
    }

    #[test]
    fn a_joint_that_moves_one_way_only_is_named_and_not_one_that_creeps_while_it_rests() {
        let both = log([(1.0, 3.0, 0.0), (0.8, 4.3, 1.0)], |[q, dq, ddq]| q + dq + ddq);
        let said = |dq: &dyn Fn(usize, f64) -> f64| {
            let mut signals = both.clone().into_signals();
            for (row, own) in signals.dq.col_mut(1).iter_mut().enumerate() {
                *own = dq(row, *own);
            }
            let found = of(&Motion::new(signals).unwrap());
            found.iter().any(|own| matches!(own, Finding::OneWay { forward: false, .. }))
        };

        assert!(said(&|_, dq| -dq.abs()));
        assert!(!said(&|row, dq| if row < 300 { dq } else { -1e-3 }));
    }

    #[test]
    fn a_lame_joint_is_named_with_what_it_lacks() {
        let lame = log([(1.0, 3.0, 0.0), (0.05, 1.0, 0.0)], |[q, dq, ddq]| q + dq + ddq);
        // So is one that starts sharply once.
        let mut jerked = lame.clone().into_signals();
        jerked.dq.col_mut(1).subrows_mut(0, 10).fill(2.0);
        jerked.ddq.col_mut(1).subrows_mut(0, 10).fill(20.0);
        for found in [of(&lame), of(&Motion::new(jerked).unwrap())] {
            assert!(
                matches!(&found[0], Finding::Range { joint, .. } if joint == "knee"),
                "{found:?}"
            );
            assert!(matches!(&found[1], Finding::Speed { .. }), "{found:?}");
            assert!(matches!(&found[2], Finding::Acceleration { .. }), "{found:?}");
        }
    }
}
