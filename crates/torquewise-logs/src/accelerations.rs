//! Whether recorded accelerations follow from recorded velocities.

use faer::MatRef;
use torquewise_motion::Motion;

/// Rows that are looked at in a file.
const ROWS: usize = 20_000;
/// Rows that a slope is taken over: noise counts little.
const WINDOW: usize = 11;
/// Correlation below which rates are no slopes, or mostly noise; and slopes that it takes.
const LEAST: f64 = 0.7;
const LEAST_SLOPES: usize = 100;

/// Velocities and accelerations against the slopes of positions and velocities.
#[derive(Default)]
pub(crate) struct Accelerations {
    rows: usize,
    velocity: Pairs,
    acceleration: Pairs,
}

/// Slopes, and the rates beside them.
#[derive(Default)]
struct Pairs(Vec<[f64; 2]>);

impl Pairs {
    fn add(&mut self, t: &[f64], value: MatRef<'_, f64>, rate: MatRef<'_, f64>) {
        for (value, rate) in value.col_iter().zip(rate.col_iter()) {
            for first in 0..(t.len() + 1).saturating_sub(WINDOW) {
                let last = first + WINDOW - 1;
                let slope = (value[last] - value[first]) / (t[last] - t[first]);
                let mean = (first..=last).map(|row| rate[row]).sum::<f64>() / WINDOW as f64;
                self.0.extend([[slope, mean]].iter().filter(|pair| pair[0].is_finite()));
            }
        }
    }

    /// Σ w sgn(slope) sgn(rate) / Σ w, where w is |slope|, at most its upper tenth: as a correlation
    /// is, whatever a few wrong numbers are. Nothing where there are too few slopes.
    fn correlation(&self) -> Option<f64> {
        let mut sizes: Vec<f64> = self.0.iter().map(|[slope, _]| slope.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let most = *sizes.get(sizes.len() * 9 / 10)?;
        let agreed = self.0.iter().map(|&[slope, rate]| {
            let sign = if rate > 0.0 {
                1.0
            } else if rate < 0.0 {
                -1.0
            } else {
                0.0
            };
            slope.clamp(-most, most) * sign
        });
        let all = sizes.iter().map(|size| size.min(most)).sum::<f64>();
        (sizes.len() >= LEAST_SLOPES && all > 0.0).then(|| agreed.sum::<f64>() / all)
    }
}

impl Accelerations {
    /// Adds a block.
    pub(crate) fn add(&mut self, block: &Motion) {
        self.velocity.add(block.t(), block.q(), block.dq());
        self.acceleration.add(block.t(), block.dq(), block.ddq());
        self.rows += block.n_rows();
    }

    /// Whether more rows would tell no more.
    pub(crate) fn is_enough(&self) -> bool {
        self.rows >= ROWS
    }

    /// Where velocities correlate: rows that are no path, or of an arm at rest, tell nothing.
    pub(crate) fn correlation(&self) -> Option<f64> {
        self.velocity.correlation().filter(|velocity| *velocity >= LEAST)?;
        self.acceleration.correlation()
    }

    /// The largest correlation of several files, where none has accelerations that follow.
    pub(crate) fn odd(files: impl Iterator<Item = Option<f64>>) -> Option<f64> {
        files.flatten().reduce(f64::max).filter(|correlation| *correlation < LEAST)
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
    fn noise_commands_and_columns_that_were_never_filled_are_told_from_measured_accelerations() {
        let odd = |seen: Accelerations| Accelerations::odd([seen.correlation()].into_iter());
        let measured = |row, t: f64| 3.0 * (3.0 * t).cos() + 3.0 * noise(row);

        assert_eq!(odd(sine(measured)), None);
        assert!(odd(sine(|row, t| measured(row, t) + 30.0 * noise(row + 1))).is_some());
        assert!(odd(sine(|_, t| measured(0, t - 1.0))).is_some_and(|found| found < 0.0));
        assert_eq!(odd(sine(|_, _| 0.0)), Some(0.0));
        // Rows that are no path.
        assert_eq!(odd(seen(|row, _| [1, 2, 3].map(|k| noise(k * row)))), None);
        // One file whose accelerations follow keeps those of all.
        let files = [sine(|_, _| 0.0), sine(measured)].map(|file| file.correlation());
        assert_eq!(Accelerations::odd(files.into_iter()), None);
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
            assert!(file.correlation().is_some_and(|found| found > 0.9));
        }
    }
}
