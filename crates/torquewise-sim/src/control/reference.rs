//! Desired motions: smooth, periodic, at rest between their periods.

use crate::state::motion;
use crate::{Arm, Result, SimError, State, between, check_between, direction};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;
use torquewise_motion::{Motion, whole};

/// A periodic motion within the ranges of an arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Periodic {
    /// Whole length \[s\].
    pub seconds: f64,
    /// Length of a period \[s\].
    pub period: f64,
    /// Rows per second \[Hz\]: the rate of the controller.
    pub rate: f64,
    /// Speed of the fastest joint \[rad/s\] at most.
    pub speed: f64,
    /// Its acceleration \[rad/s²\] at most.
    pub acceleration: f64,
    /// Seed of what each joint does.
    pub seed: u64,
}

impl Default for Periodic {
    /// Two periods of 8 s at 1 kHz, as fast as arms move among people.
    fn default() -> Self {
        let (speed, acceleration) = (1.0, 2.0);
        Self { seconds: 16.0, period: 8.0, rate: 1000.0, speed, acceleration, seed: 0 }
    }
}

const WAVES: usize = 2;
/// Share of a joint's range that is used at most.
const USED: f64 = 0.8;
const MOST_ROWS: f64 = 5e6;

/// qᵢ(t) = cᵢ + Aᵢ Σₖ uᵢₖ (sin kωt − k/(k+1) sin (k+1)ωt), at rest without acceleration at t = 0
/// and after each period.
///
/// - returns: q, q̇ and q̈ at each tick, `seconds`·`rate` + 1 rows
///
/// # Errors
/// [`SimError::Setting`] for a number out of bounds.
pub fn periodic(arm: &Arm, plan: &Periodic) -> Result<Motion> {
    let most = MOST_ROWS / plan.rate.max(1.0);
    check_between("the control rate [Hz]", plan.rate, [10.0, 1e5], "from 10 to 100000")?;
    let expected = "above 0 and at most 5000000 control periods";
    check_between("the length of the motion [s]", plan.seconds, [2.0 / plan.rate, most], expected)?;
    check_between("the period of the motion [s]", plan.period, [0.1, 1e4], "from 0.1 to 10000")?;
    let above = [1e-6, 1e6];
    check_between("the speed of the motion [rad/s]", plan.speed, above, "above 0")?;
    check_between("the acceleration of the motion [rad/s²]", plan.acceleration, above, "above 0")?;

    let mut random = ChaCha8Rng::seed_from_u64(plan.seed);
    let joints: Vec<Wave> =
        arm.ranges().into_iter().map(|range| Wave::draw(range, plan, &mut random)).collect();
    let rows = whole((plan.seconds * plan.rate).round()) + 1;
    let t: Vec<f64> = (0..rows).map(|row| row as f64 / plan.rate).collect();
    let state = |t: &f64| State::of_joints(joints.iter().map(|wave| wave.at(*t)));
    let states: Vec<State> = t.iter().map(state).collect();
    motion(arm.joints(), t, &states, None)
}

#[derive(Clone, Debug)]
struct Wave {
    middle: f64,
    w: f64,
    /// Aᵢ uᵢₖ of k = 1, 2, …
    sizes: Vec<f64>,
}

impl Wave {
    fn draw([lower, upper]: [f64; 2], plan: &Periodic, random: &mut ChaCha8Rng) -> Self {
        let w = TAU / plan.period;
        let mut signed = || between(random, [0.3, 1.0]) * direction(random);
        let sizes: Vec<f64> = (1..=WAVES).map(|k| signed() / (k * k) as f64).collect();
        let mut wave = Self { middle: f64::midpoint(lower, upper), w, sizes };
        let points = (0..400).map(|k| wave.at(plan.period * f64::from(k) / 400.0));
        let mut peaks = [0.0_f64; 3];
        for state in points {
            let from_middle = [state[0] - wave.middle, state[1], state[2]];
            for (peak, x) in peaks.iter_mut().zip(from_middle) {
                *peak = peak.max(x.abs());
            }
        }
        let bounds = [USED * (upper - lower) / 2.0, plan.speed, plan.acceleration];
        let scale = bounds.iter().zip(peaks).fold(f64::INFINITY, |s, (b, peak)| s.min(b / peak));
        wave.sizes.iter_mut().for_each(|size| *size *= scale);
        wave
    }

    fn at(&self, t: f64) -> [f64; 3] {
        let [mut q, mut dq, mut ddq] = [self.middle, 0.0, 0.0];
        for (place, size) in self.sizes.iter().enumerate() {
            let k = (place + 1) as f64;
            let (slow, fast) = (k * self.w, (k + 1.0) * self.w);
            let ((sin, cos), (sin_fast, cos_fast)) = ((slow * t).sin_cos(), (fast * t).sin_cos());
            q += size * (sin - k / (k + 1.0) * sin_fast);
            dq += size * slow * (cos - cos_fast);
            ddq += size * slow * (fast * sin_fast - slow * sin);
        }
        [q, dq, ddq]
    }
}

/// Time between rows may differ by this share of itself: stamps are rounded.
const SLACK: f64 = 1e-3;

/// Seconds between the rows of a desired motion.
pub(crate) fn period(motion: &Motion) -> Result<f64> {
    let (t, rows) = (motion.t(), motion.n_rows());
    check_between("rows of the desired motion", rows as f64, [2.0, f64::MAX], "2 or more")?;
    let period = (t[rows - 1] - t[0]) / (rows - 1) as f64;
    let is_even = |pair: &[f64]| (pair[1] - pair[0] - period).abs() <= SLACK * period;
    let uneven = t.windows(2).position(|pair| period <= 0.0 || !is_even(pair));
    uneven.map_or(Ok(period), |row| Err(SimError::Uneven { row: row + 1 }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::MatRef;

    #[test]
    fn it_is_at_rest_at_each_end_within_its_limits_and_its_rates_are_the_derivatives() {
        let arm = Arm::builtin("puma560-3").unwrap();
        let plan = Periodic { seconds: 8.0, period: 4.0, ..Periodic::default() };

        let motion = periodic(&arm, &plan).unwrap();

        assert_eq!(motion.n_rows(), 8001);
        for (joint, [lower, upper]) in arm.ranges().into_iter().enumerate() {
            for row in [0, 4000, 8000] {
                assert!(motion.dq()[(row, joint)].abs() < 1e-12);
                assert!(motion.ddq()[(row, joint)].abs() < 1e-11);
            }
            let mut fastest = 0.0_f64;
            for row in 0..8001 {
                let [q, dq, ddq] = [motion.q(), motion.dq(), motion.ddq()].map(|x| x[(row, joint)]);
                assert!((lower..=upper).contains(&q));
                // Peaks between the 400 points that are looked at.
                assert!(dq.abs() < 1.001 * plan.speed && ddq.abs() < 1.001 * plan.acceleration);
                fastest = fastest.max(dq.abs());
                if (1..8000).contains(&row) {
                    let slope =
                        |x: MatRef<'_, f64>| 500.0 * (x[(row + 1, joint)] - x[(row - 1, joint)]);
                    // h²/6 times the third derivative of q and of q̇, some tens, h = 1 ms.
                    assert!((slope(motion.q()) - dq).abs() < 1e-5);
                    assert!((slope(motion.dq()) - ddq).abs() < 1e-4);
                }
            }
            assert!(fastest > 0.3, "joint {joint} moves");
        }
    }

    #[test]
    fn a_motion_that_cannot_be_is_refused() {
        let arm = Arm::builtin("planar-2").unwrap();
        let usual = Periodic::default();
        let plans = [
            Periodic { seconds: 0.0, ..usual },
            Periodic { rate: f64::NAN, ..usual },
            Periodic { period: -1.0, ..usual },
            Periodic { speed: 0.0, ..usual },
            Periodic { seconds: 1e9, ..usual },
        ];

        for plan in plans {
            assert!(matches!(periodic(&arm, &plan), Err(SimError::Setting { .. })));
        }
    }
}
