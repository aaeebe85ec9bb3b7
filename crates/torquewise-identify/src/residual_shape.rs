//! Where a model misses the torque of a joint: at rest, about reversals, at speed, or in one pose.
//! Each asks for another cure.

use crate::Warning;
use std::fmt;
use torquewise_model::{Model, Torque};
use torquewise_motion::{Motion, ends};
use torquewise_stepwise::IdentifyError;

/// Rows in which most of what is left of a torque lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ResidualPlace {
    /// The joint rests.
    Rest,
    /// It moves slowly, about its reversals.
    Slow,
    /// It moves fast.
    Fast,
    /// It is between two angles \[rad\].
    Pose([f64; 2]),
}

/// Speeds, of the largest: up to the first a joint rests, up to the second it is slow, from the
/// third on it is fast.
const SPEEDS: [f64; 3] = [0.02, 0.15, 0.7];
const POSES: usize = 6;
/// Of the squared residual this part must lie there, and so many times as much as of the rows.
const MOST: f64 = 0.6;
const DENSER: f64 = 2.0;
/// Fewer rows than this part of all are too few.
const FEW: f64 = 0.01;

/// The joints, of some that a model misses, of which most is missed in few rows.
pub(crate) fn shapes(
    model: &Model,
    sample: &Motion,
    missed: &[usize],
) -> Result<Vec<Warning>, IdentifyError> {
    let left = sample.require_tau()? - Torque::new(model).over(sample)?;
    let of_joint = |&joint: &usize| {
        let [q, dq, left] = [sample.q(), sample.dq(), left.as_ref()]
            .map(|x| x.col(joint).iter().copied().collect::<Vec<f64>>());
        let (place, shares) = densest(&q, &dq, &left)?;
        Some(Warning::Shape { joint: model.joints[joint].clone(), place, shares })
    };
    Ok(missed.iter().filter_map(of_joint).collect())
}

/// Where the squared residual of a joint is densest, if most of it is there.
fn densest(q: &[f64], dq: &[f64], left: &[f64]) -> Option<(ResidualPlace, [f64; 2])> {
    let peak = dq.iter().fold(0.0_f64, |peak, dq| peak.max(dq.abs()));
    let [low, high] = ends(q.iter().copied());
    let speed = |row: usize| dq[row].abs() / peak.max(f64::MIN_POSITIVE);
    let edge = |part: usize| low + (high - low) * part as f64 / POSES as f64;
    let mut places = vec![ResidualPlace::Rest, ResidualPlace::Slow, ResidualPlace::Fast];
    places.extend((0..POSES).map(|part| ResidualPlace::Pose([edge(part), edge(part + 1)])));
    let is_in = |place: ResidualPlace, row: usize| match place {
        ResidualPlace::Rest => speed(row) < SPEEDS[0],
        ResidualPlace::Slow => (SPEEDS[0]..SPEEDS[1]).contains(&speed(row)),
        ResidualPlace::Fast => speed(row) >= SPEEDS[2],
        ResidualPlace::Pose([from, to]) => q[row] >= from && q[row] <= to,
    };
    let total: f64 = left.iter().map(|left| left * left).sum();
    let shares = |place: ResidualPlace| {
        let rows: Vec<usize> = (0..left.len()).filter(|&row| is_in(place, row)).collect();
        let own: f64 = rows.iter().map(|&row| left[row] * left[row]).sum();
        [own / total, rows.len() as f64 / left.len() as f64]
    };
    let all = places.into_iter().map(|place| (place, shares(place)));
    let dense =
        all.filter(|(_, [left, rows])| *rows >= FEW && *left >= MOST && *left >= DENSER * rows);
    dense.max_by(|a, b| (a.1[0] / a.1[1]).total_cmp(&(b.1[0] / b.1[1])))
}

/// What the rows are, and what to do.
impl fmt::Display for ResidualPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rest => f.write_str(
                "at rest: friction holds it there with any torque; record motion with fewer stops",
            ),
            Self::Slow => f.write_str(
                "slow ones about reversals: record slow strokes to and fro, over its whole range",
            ),
            Self::Fast => f.write_str("fast ones: record more fast motion, with many reversals"),
            Self::Pose([from, to]) => write!(
                f,
                "between positions {from:.2} and {to:.2}: record more there, and look for a stop, a cable or \
                 a load that acts in this pose"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{ResidualPlace, densest};

    /// A joint that swings over ±1 rad and rests every fifth time, and what is left where asked.
    fn planted(is_missed: impl Fn(f64, f64) -> bool) -> Option<ResidualPlace> {
        let phase = |row: usize| row as f64 * 0.01 % std::f64::consts::TAU;
        let rests = |row: usize| (row / 628) % 5 == 4;
        let q = |row: usize| if rests(row) { 0.0 } else { phase(row).sin() };
        let dq = |row: usize| if rests(row) { 0.0 } else { phase(row).cos() };
        let (q, dq): (Vec<f64>, Vec<f64>) = (0..6280).map(|row| (q(row), dq(row))).unzip();
        let left: Vec<f64> = (0..6280)
            .map(|row| {
                let noise = if row % 2 == 0 { 0.1 } else { -0.1 };
                if is_missed(q[row], dq[row]) { 1.0 + noise } else { noise }
            })
            .collect();
        densest(&q, &dq, &left).map(|(place, _)| place)
    }

    #[test]
    fn planted_residuals_are_placed() {
        assert_eq!(planted(|_, dq| dq.abs() > 0.8), Some(ResidualPlace::Fast));
        assert_eq!(planted(|_, dq| dq != 0.0 && dq.abs() < 0.1), Some(ResidualPlace::Slow));
        assert!(
            matches!(planted(|q, _| q > 0.7), Some(ResidualPlace::Pose([from, _])) if from > 0.6)
        );
        assert_eq!(planted(|_, dq| dq == 0.0), Some(ResidualPlace::Rest));
        assert_eq!(planted(|_, _| true), None);
    }
}
