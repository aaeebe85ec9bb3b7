//! Spread of the momentum observer in motion free of contact (E16).

use crate::clustered::Stretches;
use crate::disagreement::slow;
use torquewise_model::Model;
use torquewise_motion::stats::quantile;

/// What the variance of a joint is a sum of: a constant, its speed squared, the accelerations of all
/// joints squared, and that it has just reversed.
pub(super) const FOLLOWED: usize = 4;

/// External torque of a joint \[N·m\], and what its variance is a sum of there.
pub(super) type Row = (f64, [f64; FOLLOWED]);

/// The constant is at least this part of the mean square: a log of motion alone does not say how
/// still the arm is at rest.
const LEAST_CONSTANT: f64 = 0.05;
/// Part of the absolute values that count as they are where some may be contacts.
const CALM: f64 = 0.95;
/// Rounds in which rows are weighted by the variance of the round before.
const ROUNDS: usize = 4;

/// Passes the motion through the low-pass of the observer.
#[derive(Clone, Debug)]
pub(super) struct Follower {
    gain: f64,
    /// Speeds below which a joint is not seen to move \[rad/s\], n.
    slow: Vec<f64>,
    /// Sign of the last motion seen, n.
    signs: Vec<f64>,
    followed: Vec<[f64; FOLLOWED]>,
}

impl Follower {
    pub(super) fn new(model: &Model, gain: f64) -> Self {
        let n = model.n_joints();
        Self { gain, slow: slow(model), signs: vec![0.0; n], followed: vec![[0.0; FOLLOWED]; n] }
    }

    pub(super) fn reset(&mut self) {
        self.signs.fill(0.0);
        self.followed.fill([0.0; FOLLOWED]);
    }

    pub(super) fn step(&mut self, dt: f64, dq: &[f64], ddq: &[f64]) -> &[[f64; FOLLOWED]] {
        let stays = (-self.gain * dt).exp();
        let squares: f64 = ddq.iter().map(|x| x * x).sum();
        for (joint, own) in self.followed.iter_mut().enumerate() {
            let sign = if dq[joint].abs() > self.slow[joint] { dq[joint].signum() } else { 0.0 };
            let reverses = sign * self.signs[joint] < 0.0;
            if sign != 0.0 {
                self.signs[joint] = sign;
            }
            let lag = |before: f64, x: f64| stays * before + (1.0 - stays) * x;
            let reversed = if reverses { 1.0 } else { stays * own[3] };
            *own = [1.0, lag(own[1], dq[joint] * dq[joint]), lag(own[2], squares), reversed];
        }
        &self.followed
    }
}

/// Standard deviation of the external torque of a joint as it follows the motion.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Spread {
    /// Of the variance, none negative.
    coefficients: [f64; FOLLOWED],
    /// In all motion that it was found in \[N·m\].
    pub(super) whole: f64,
}

impl Spread {
    /// Non-negative least squares of squares of torque, weighted as those of a normal distribution
    /// are: by the inverse square of their variance.
    ///
    /// - `is_free`: whether nothing touched the arm; else the largest squares are cut
    pub(super) fn of(rows: &[Row], is_free: bool) -> Self {
        let mut sizes: Vec<f64> = rows.iter().map(|(x, _)| x.abs()).collect();
        let most = if is_free { f64::INFINITY } else { quantile(&mut sizes, CALM) };
        let square = |x: f64| x.abs().min(most).powi(2);
        let mean = rows.iter().map(|(x, _)| square(*x)).sum::<f64>() / rows.len().max(1) as f64;
        let mut spread = Self { coefficients: [mean, 0.0, 0.0, 0.0], whole: mean.sqrt() };
        for _ in 0..ROUNDS {
            let mut columns = [true; FOLLOWED];
            spread.coefficients = loop {
                let mut sums = Stretches::new(FOLLOWED, usize::MAX, usize::MAX);
                for (x, at) in rows {
                    let weight = spread.variance(at).max(f64::MIN_POSITIVE.sqrt()).powi(-2);
                    let at: [f64; FOLLOWED] =
                        std::array::from_fn(|k| if columns[k] { at[k] } else { 0.0 });
                    sums.add(&at, square(*x) - LEAST_CONSTANT * mean, weight);
                }
                let Some(solved) = sums.solved() else { return spread };
                let least =
                    (0..FOLLOWED).min_by(|i, j| solved.values[*i].total_cmp(&solved.values[*j]));
                match least {
                    Some(k) if solved.values[k] < 0.0 => columns[k] = false,
                    _ => break std::array::from_fn(|k| solved.values[k]),
                }
            };
            spread.coefficients[0] += LEAST_CONSTANT * mean;
        }
        spread
    }

    fn variance(&self, at: &[f64; FOLLOWED]) -> f64 {
        self.coefficients.iter().zip(at).map(|(c, x)| c * x).sum()
    }

    /// \[N·m\].
    pub(super) fn at(&self, at: &[f64; FOLLOWED]) -> f64 {
        self.variance(at).max(f64::MIN_POSITIVE).sqrt()
    }

    /// Torque beside its spread there, squared.
    pub(super) fn square(&self, (torque, at): &Row) -> f64 {
        (torque / self.at(at)).powi(2)
    }

    /// \[N·m\].
    pub(super) fn at_rest(&self) -> f64 {
        self.coefficients[0].sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::{FOLLOWED, Row, Spread};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    /// Normal torque of a variance, by what it follows.
    fn rows(variance: impl Fn(&[f64; FOLLOWED]) -> f64) -> Vec<Row> {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let row = |k: u32| {
            let phase = f64::from(k) * 0.01;
            let at = [
                1.0,
                phase.sin().powi(2),
                2.0 + phase.cos(),
                f64::from(u8::from(k.is_multiple_of(50))),
            ];
            let unit: f64 = StandardNormal.sample(&mut random);
            (unit * variance(&at).sqrt(), at)
        };
        (0..20_000).map(row).collect()
    }

    #[test]
    fn what_a_variance_follows_is_found_and_a_constant_one_is_that_of_all_rows() {
        let followed = rows(|at| 0.04 + 2.0 * at[1] + 9.0 * at[3]);

        let spread = Spread::of(&followed, true);

        assert!((0.18..0.35).contains(&spread.at_rest()), "{spread:?}");
        let at = |speed: f64, reversed: f64| spread.at(&[1.0, speed, 2.0, reversed]);
        assert!((at(1.0, 0.0) / 2.04_f64.sqrt() - 1.0).abs() < 0.05, "{spread:?}");
        assert!((at(0.5, 1.0) / 10.04_f64.sqrt() - 1.0).abs() < 0.1, "{spread:?}");
        assert!(spread.coefficients.iter().all(|c| *c >= 0.0), "{spread:?}");
        let spread = Spread::of(&rows(|_| 0.25), true);

        assert!((spread.whole - 0.5).abs() < 0.01, "{spread:?}");
        assert!((spread.at(&[1.0, 0.3, 2.0, 0.0]) - 0.5).abs() < 0.05, "{spread:?}");
    }
}
