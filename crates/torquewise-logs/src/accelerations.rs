//! Whether recorded accelerations follow from recorded velocities.

use faer::MatRef;
use std::ops::{Index, RangeInclusive};
use torquewise_motion::{Motion, quantile};

/// Rows that are looked at in a file.
const ROWS: usize = 20_000;
/// Rows that a slope is taken over: noise counts little.
const WINDOW: usize = 11;
/// Correlation below which rates are no slopes, or mostly noise; and slopes that it takes.
const LEAST: f64 = 0.7;
const LEAST_SLOPES: usize = 100;
/// Correlation from which the gain of a velocity is that of its joint, not of noise.
const FOLLOWS: f64 = 0.95;
/// Gains of velocities against slopes; beyond, rows are not as far apart as their stamps say.
const GAINS: RangeInclusive<f64> = 0.5..=2.0;
/// Rates over slopes that filters of a robot may explain.
pub const LEAST_GAIN: f64 = 0.8;
/// Slopes and rates count up to so many times the upper tenth of those of a joint that are not zero.
const MOST: f64 = 2.0;

/// Velocities and accelerations against the slopes of positions and velocities.
#[derive(Default)]
pub(crate) struct Accelerations {
    rows: usize,
    velocity: Pairs,
    acceleration: Pairs,
}

/// Slope of a value over each window of rows; of the rate beside it the mean, and that in the middle.
///
/// - `t`: clock, and seconds of its unit
pub(crate) fn slopes<X: Index<usize, Output = f64>>(
    (t, seconds): (&[f64], f64),
    value: &X,
    rate: &X,
) -> impl Iterator<Item = [f64; 3]> {
    (0..(t.len() + 1).saturating_sub(WINDOW)).filter_map(move |first| {
        let last = first + WINDOW - 1;
        let step = (t[last] - t[first]) * seconds;
        let slope = (value[last] - value[first]) / step;
        let mean = (first..=last).map(|row| rate[row]).sum::<f64>() / WINDOW as f64;
        let all = [slope, mean, rate[first + WINDOW / 2]];
        (step > 0.0 && all.iter().all(|x| x.is_finite())).then_some(all)
    })
}

/// Slopes, and the rates beside them, of each joint.
#[derive(Default)]
struct Pairs(Vec<Vec<[f64; 2]>>);

impl Pairs {
    /// - `of`: which rate, see [`slopes`]
    fn add(&mut self, t: &[f64], value: MatRef<'_, f64>, rate: MatRef<'_, f64>, of: usize) {
        self.0.resize_with(value.ncols().max(self.0.len()), Vec::new);
        for ((value, rate), pairs) in value.col_iter().zip(rate.col_iter()).zip(&mut self.0) {
            pairs.extend(slopes((t, 1.0), &value, &rate).map(|all| [all[0], all[of]]));
        }
    }

    /// Correlation and gain of slopes and rates of some joints, both made smaller where one is beyond some
    /// times the upper tenth of its joint, so that a few wrong numbers count little. Nothing where there are
    /// too few slopes.
    fn correlation_and_gain(joints: &[Vec<[f64; 2]>]) -> Option<[f64; 2]> {
        let (mut slopes, mut rates, mut products) = (0.0, 0.0, 0.0);
        for pairs in joints {
            let most = [0, 1].map(|of| {
                let sizes = pairs.iter().map(|pair| pair[of].abs());
                let mut sizes: Vec<f64> = sizes.filter(|size| *size > 0.0).collect();
                MOST * quantile(&mut sizes, 0.9)
            });
            for pair in pairs {
                let [own, other] = [0, 1].map(|k| most[k] / pair[k].abs());
                let [slope, rate] = pair.map(|x| x * own.min(other).min(1.0));
                slopes += slope * slope;
                rates += rate * rate;
                products += slope * rate;
            }
        }
        let count: usize = joints.iter().map(Vec::len).sum();
        let is_known = count >= LEAST_SLOPES && slopes > 0.0;
        let correlation = if rates > 0.0 { products / (slopes * rates).sqrt() } else { 0.0 };
        is_known.then(|| [correlation, products / slopes])
    }
}

impl Accelerations {
    pub(crate) fn add(&mut self, block: &Motion) {
        self.velocity.add(block.t(), block.q(), block.dq(), 1);
        // Of accelerations that are used as they are, noise counts.
        self.acceleration.add(block.t(), block.dq(), block.ddq(), 2);
        self.rows += block.n_rows();
    }

    /// Whether more rows would tell no more.
    pub(crate) fn is_enough(&self) -> bool {
        self.rows >= ROWS
    }

    /// Correlation and gain where velocities are slopes: rows that are no path or of an arm at rest, and
    /// stamps that are none of the rows, tell nothing.
    pub(crate) fn agreement(&self) -> Option<[f64; 2]> {
        let is_slope =
            |[correlation, gain]: &[f64; 2]| *correlation >= LEAST && GAINS.contains(gain);
        Pairs::correlation_and_gain(&self.velocity.0).filter(is_slope)?;
        Pairs::correlation_and_gain(&self.acceleration.0)
    }

    /// Velocity over the slope of the position of each joint, n; nothing where it does not follow.
    pub(crate) fn velocity_gains(&self) -> Vec<Option<f64>> {
        let of = |joint: &Vec<[f64; 2]>| {
            let [correlation, gain] = Pairs::correlation_and_gain(std::slice::from_ref(joint))?;
            (correlation >= FOLLOWS && GAINS.contains(&gain)).then_some(gain)
        };
        self.velocity.0.iter().map(of).collect()
    }

    /// Correlation and gain of the file whose accelerations follow best, where these are no slopes.
    pub(crate) fn odd(files: impl Iterator<Item = Option<[f64; 2]>>) -> Option<[f64; 2]> {
        let best = files.flatten().max_by(|a, b| a[0].total_cmp(&b[0]));
        best.filter(|[correlation, gain]| {
            // Noise in slopes lowers the gain, by the square of the correlation at most.
            let least = LEAST_GAIN * correlation.powi(2);
            *correlation < LEAST || !(least..=1.0 / LEAST_GAIN).contains(gain)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;
    use torquewise_motion::Signals;

    /// - `state`: position, velocity and acceleration in a row at a time
    fn seen(state: impl Fn(usize, f64) -> [f64; 3]) -> Accelerations {
        let t: Vec<f64> = (0..1_000).map(|row| 0.02 * f64::from(row)).collect();
        let of = |k: usize| Mat::from_fn(t.len(), 1, |row, _| state(row, t[row])[k]);
        let joints = vec!["joint1".into()];
        let signals = Signals { joints, t: t.clone(), q: of(0), dq: of(1), ddq: of(2), tau: None };
        let mut seen = Accelerations::default();
        seen.add(&Motion::new(signals).unwrap());
        assert!(!seen.is_enough());
        seen
    }

    fn noise(row: usize) -> f64 {
        (9e4 * (row as f64).sin()).sin()
    }

    fn sine(ddq: impl Fn(usize, f64) -> f64) -> Accelerations {
        seen(|row, t| [-(3.0 * t).cos() / 3.0, (3.0 * t).sin(), ddq(row, t)])
    }

    #[test]
    fn noise_commands_other_factors_and_empty_columns_are_told_from_measured_accelerations() {
        let odd = |seen: Accelerations| Accelerations::odd([seen.agreement()].into_iter());
        let measured = |row, t: f64| 3.0 * (3.0 * t).cos() + 3.0 * noise(row);

        assert_eq!(odd(sine(measured)), None);
        assert!(odd(sine(|row, t| measured(row, t) + 30.0 * noise(row + 1))).is_some());
        assert!(odd(sine(|_, t| measured(0, t - 1.0))).is_some_and(|found| found[0] < 0.0));
        assert!(odd(sine(|row, t| measured(row, t) + 3.0 * noise(2 * row))).is_some());
        assert_eq!(odd(sine(|_, _| 0.0)), Some([0.0, 0.0]));
        // Low-passed, of another unit, and right beside noisy velocities.
        for (factor, late) in [(0.4, 0.1), (57.3, 0.0)] {
            let [_, gain] = odd(sine(|row, t| factor * measured(row, t - late))).unwrap();
            assert!((gain / factor - 1.0).abs() < 0.1, "{gain}");
        }
        let rough = |row, t: f64| [-t.cos(), t.sin() + 0.1 * noise(row), t.cos()];
        assert!(seen(rough).agreement().is_some_and(|[_, gain]| gain < LEAST_GAIN));
        assert_eq!(odd(seen(rough)), None);
        // Rows that are no path.
        assert_eq!(odd(seen(|row, _| [1, 2, 3].map(|k| noise(k * row)))), None);
        // One row in ten of a log, the stamps of them all.
        let thinned = |row, t: f64| [-(30.0 * t).cos() / 3.0, (30.0 * t).sin(), noise(row)];
        assert_eq!(odd(seen(thinned)), None);
        // One file whose accelerations follow keeps those of all.
        let files = [sine(|_, _| 0.0), sine(measured)].map(|file| file.agreement());
        assert_eq!(Accelerations::odd(files.into_iter()), None);
    }

    #[test]
    fn velocities_of_another_scale_are_told_where_they_follow() {
        let scaled = |factor: f64| {
            let rate = |t: f64| factor * (3.0 * t).sin();
            seen(|_, t| [-(3.0 * t).cos() / 3.0, rate(t), 3.0 * (3.0 * t).cos()]).velocity_gains()
        };
        for factor in [0.7, 1.0, 1.2] {
            assert!(scaled(factor)[0].is_some_and(|gain| (gain / factor - 1.0).abs() < 0.01));
        }
        assert_eq!(seen(|row, _| [1, 2, 3].map(|k| noise(k * row))).velocity_gains(), [None]);
    }

    #[test]
    fn joints_at_rest_tell_nothing() {
        let still = |row: usize, _| [0.0, 2e-3 * noise(row), 5e-2 * noise(row + 1)];
        let mut seen = sine(|_, t| 3.0 * (3.0 * t).cos());
        let own = seen.agreement();
        for _ in 0..6 {
            let Accelerations { velocity, acceleration, .. } = self::seen(still);
            seen.velocity.0.extend(velocity.0);
            seen.acceleration.0.extend(acceleration.0);
        }
        let mut odd = sine(|_, t| -3.0 * (3.0 * t).cos());
        odd.acceleration.0.push(vec![[0.0, 0.0]; 20_000]);

        assert!(own.zip(seen.agreement()).is_some_and(|(own, all)| own[0] > 0.99 && all[0] > 0.95));
        assert!(odd.agreement().is_some_and(|[found, _]| found < -0.9));
    }

    #[test]
    fn a_few_damaged_numbers_do_not_count() {
        let damaged = |row: usize| (500..525).contains(&row).then(|| 1e200 * noise(row));
        let rate = |row, t: f64| damaged(row).unwrap_or(3.0 * (3.0 * t).cos());
        let value = |row, t: f64| damaged(row).unwrap_or((3.0 * t).sin());
        let position = |t: f64| -(3.0 * t).cos() / 3.0;

        let of_rate = seen(|row, t| [position(t), (3.0 * t).sin(), rate(row, t)]);
        let of_value = seen(|row, t| [position(t), value(row, t), 3.0 * (3.0 * t).cos()]);

        for file in [of_rate, of_value] {
            assert!(file.agreement().is_some_and(|[found, _]| found > 0.8));
        }
    }
}
