//! Dormand and Prince's method with error control.

use crate::{Result, SimError};

/// Where the stages of a step are: x + h Σ Aᵢⱼ kⱼ. The last row is the solution of order 5.
const A: [&[f64]; 6] = [
    &[1.0 / 5.0],
    &[3.0 / 40.0, 9.0 / 40.0],
    &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
    &[19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0],
    &[9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
    &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];

/// Order 5 less order 4: the error of a step.
const ERROR: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339_200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// A step grows or shrinks by these factors at most.
const GROWTH: [f64; 2] = [0.2, 5.0];
/// The next step is this share of what its error would allow.
const SAFETY: f64 = 0.9;
/// Steps of one stretch at most: more means that something runs away.
const MOST_STEPS: usize = 100_000;

/// Remembers the step that the last stretch ended with.
#[derive(Clone, Debug)]
pub(crate) struct Integrator {
    tolerance: f64,
    step: f64,
    slopes: [Vec<f64>; 7],
    trial: Vec<f64>,
}

impl Integrator {
    /// For states of `size` numbers; a step may be wrong by `tolerance`·(1 + |x|) in each.
    pub(crate) fn new(size: usize, tolerance: f64) -> Self {
        let slopes = std::array::from_fn(|_| vec![0.0; size]);
        Self { tolerance, step: f64::INFINITY, slopes, trial: vec![0.0; size] }
    }

    /// Follows x' = slope(x) for some seconds; `t` is where that is, for the error alone.
    ///
    /// Source: Dormand and Prince, J. Comput. Appl. Math. 6 (1980), 19–26.
    pub(crate) fn advance(
        &mut self,
        x: &mut [f64],
        [t, seconds]: [f64; 2],
        mut slope: impl FnMut(&[f64], &mut [f64]) -> Result<()>,
    ) -> Result<()> {
        let (mut left, mut steps) = (seconds, 0);
        slope(x, &mut self.slopes[0])?;
        while left > 0.0 {
            let last = self.step >= left;
            let h = if last { left } else { self.step };
            for (stage, weights) in A.iter().enumerate() {
                for (i, (trial, x)) in self.trial.iter_mut().zip(&*x).enumerate() {
                    let sum: f64 = weights.iter().zip(&self.slopes).map(|(a, k)| a * k[i]).sum();
                    *trial = x + h * sum;
                }
                slope(&self.trial, &mut self.slopes[stage + 1])?;
            }
            let error = self.error(x, h);
            let [least, most] = GROWTH;
            let factor = (SAFETY * error.powf(-0.2)).clamp(least, most);
            // An error that is not finite shrinks the step like any that is too large.
            let factor = if error.is_finite() { factor } else { least };
            let accepted = error <= 1.0;
            if accepted {
                x.copy_from_slice(&self.trial);
                self.slopes.swap(0, 6);
                left = if last { 0.0 } else { left - h };
            }
            // A step that was cut short by the end says nothing against the step it was cut from.
            let cut = accepted && last && self.step.is_finite();
            self.step = if cut { self.step.max(h * factor) } else { h * factor };
            steps += 1;
            if steps > MOST_STEPS || self.step < 1e-14 {
                return Err(SimError::Diverged { t: t + seconds - left });
            }
        }
        Ok(())
    }

    fn error(&self, x: &[f64], h: f64) -> f64 {
        let mut largest = 0.0_f64;
        for (i, (before, after)) in x.iter().zip(&self.trial).enumerate() {
            let wrong: f64 = ERROR.iter().zip(&self.slopes).map(|(e, k)| e * k[i]).sum();
            let allowed = self.tolerance * (1.0 + before.abs().max(after.abs()));
            let share = (h * wrong / allowed).abs();
            // `max` would pass over NaN.
            if share.is_nan() {
                return f64::NAN;
            }
            largest = largest.max(share);
        }
        largest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where x' = slope(x) leads in some seconds.
    fn followed<const N: usize>(
        mut x: [f64; N],
        tolerance: f64,
        seconds: f64,
        slope: impl Fn(&[f64]) -> [f64; N],
    ) -> Result<[f64; N], SimError> {
        let mut integrator = Integrator::new(N, tolerance);
        integrator.advance(&mut x, [0.0, seconds], |x, dx| {
            dx.copy_from_slice(&slope(x));
            Ok(())
        })?;
        Ok(x)
    }

    #[test]
    fn the_error_follows_the_tolerance_and_a_polynomial_of_degree_five_is_exact() {
        for tolerance in [1e-6, 1e-9, 1e-12] {
            let [x, dx] = followed([1.0, 0.0], tolerance, 10.0, |x| [x[1], -x[0]]).unwrap();

            let wrong = (x - 10.0_f64.cos()).abs().max((dx + 10.0_f64.sin()).abs());
            // Some dozens to hundreds of steps, each wrong by the tolerance at most.
            assert!(wrong < 300.0 * tolerance, "{wrong} at {tolerance}");
        }
        // x₁ is the time, so that x₀ = t⁵ from t = 1 to 3; rounding only, of numbers up to 243.
        let [x, _] = followed([1.0; 2], 1e-3, 2.0, |x| [5.0 * x[1].powi(4), 1.0]).unwrap();
        assert!((x - 243.0).abs() < 243.0 * 1e-13, "{x}");
    }

    #[test]
    fn what_runs_away_is_an_error() {
        let found = followed([1.0], 1e-9, 2.0, |x| [x[0] * x[0]]);

        assert!(matches!(found, Err(SimError::Diverged { t }) if (t - 1.0).abs() < 1e-3));
    }
}
