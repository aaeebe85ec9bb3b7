//! Whether recorded accelerations follow from recorded velocities.

use crate::error::LogError;
use torquewise_motion::Motion;

/// Rows that are looked at.
const ROWS: usize = 20_000;
/// Rows on either side of one that its slope is taken over: noise counts little.
const REACH: usize = 5;
/// Correlation below which accelerations are something else, or mostly noise; and slopes that it
/// takes.
const LEAST: f64 = 0.7;
const LEAST_SLOPES: usize = 100;

/// Enough rows were seen, or one that cannot be read: whoever reads them all says so.
pub(crate) struct Stop;

impl From<LogError> for Stop {
    fn from(_: LogError) -> Self {
        Self
    }
}

/// Accelerations against slopes of velocities.
#[derive(Default)]
pub(crate) struct Accelerations {
    rows: usize,
    slopes: usize,
    /// Σ slope², Σ acceleration², Σ slope · acceleration.
    sums: [f64; 3],
}

impl Accelerations {
    /// Adds a block, until there are enough.
    pub(crate) fn add(&mut self, block: &Motion) -> Result<(), Stop> {
        let (t, window) = (block.t(), 2 * REACH + 1);
        for (dq, ddq) in block.dq().col_iter().zip(block.ddq().col_iter()) {
            for first in 0..(block.n_rows() + 1).saturating_sub(window) {
                let last = first + window - 1;
                let slope = (dq[last] - dq[first]) / (t[last] - t[first]);
                let mean = (first..=last).map(|row| ddq[row]).sum::<f64>() / window as f64;
                let products = [slope * slope, mean * mean, slope * mean];
                if products.iter().all(|product| product.is_finite()) {
                    self.sums.iter_mut().zip(products).for_each(|(sum, product)| *sum += product);
                    self.slopes += 1;
                }
            }
        }
        self.rows += block.n_rows();
        if self.rows < ROWS { Ok(()) } else { Err(Stop) }
    }

    /// The correlation, where accelerations do not follow from velocities.
    pub(crate) fn odd(&self) -> Option<f64> {
        let [slopes, own, product] = self.sums;
        let correlation = product / (slopes * own).sqrt();
        (self.slopes >= LEAST_SLOPES && correlation < LEAST).then_some(correlation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;
    use torquewise_motion::Signals;

    #[test]
    fn noise_and_commands_are_told_from_measured_accelerations() {
        let odd = |noise: f64, lag: f64| {
            let t: Vec<f64> = (0..1_000).map(|row| 0.02 * f64::from(row)).collect();
            let of = |value: &dyn Fn(usize) -> f64| Mat::from_fn(t.len(), 1, |row, _| value(row));
            let hum = |row: usize| noise * (9e4 * (row as f64).sin()).sin();
            let signals = Signals {
                joints: vec!["joint1".into()],
                t: t.clone(),
                q: of(&|row| -(3.0 * t[row]).cos() / 3.0),
                dq: of(&|row| (3.0 * t[row]).sin()),
                ddq: of(&|row| 3.0 * (3.0 * (t[row] - lag)).cos() + hum(row)),
                tau: None,
            };
            let mut seen = Accelerations::default();
            assert!(seen.add(&Motion::new(signals).unwrap()).is_ok());
            seen.odd()
        };

        assert_eq!(odd(0.0, 0.0), None);
        assert_eq!(odd(3.0, 0.02), None);
        assert!(odd(30.0, 0.0).is_some());
        assert!(odd(0.0, 1.0).is_some_and(|correlation| correlation < 0.0));
    }
}
