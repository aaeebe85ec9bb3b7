//! Spread of the momentum observer in motion free of contact (E16).

use crate::clustered::Stretches;
use torquewise_model::Model;
use torquewise_motion::quantile;

/// What the variance of a joint is a sum of: a constant, its speed squared, the accelerations of all
/// joints squared, that it has just reversed, and what jumps of its torque leave open.
pub(super) const FOLLOWED: usize = 5;
/// The last of them is known: a jump between two samples is at any instant between them alike, so
/// that the mean torque there misses a twelfth of its square on average.
const SOLVED: usize = FOLLOWED - 1;

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
    /// Torque of the sample before \[N·m\], n.
    tau: Vec<f64>,
    pub(super) followed: Vec<[f64; FOLLOWED]>,
    /// What dry friction may hold at rest \[N·m\], n.
    pub(super) held: Vec<f64>,
}

impl Follower {
    pub(super) fn new(model: &Model, gain: f64) -> Self {
        let n = model.n_joints();
        Self {
            gain,
            slow: model.rest_speeds(),
            signs: vec![0.0; n],
            tau: vec![f64::NAN; n],
            followed: vec![[0.0; FOLLOWED]; n],
            held: vec![0.0; n],
        }
    }

    pub(super) fn reset(&mut self) {
        self.signs.fill(0.0);
        self.tau.fill(f64::NAN);
        self.followed.fill([0.0; FOLLOWED]);
        self.held.fill(0.0);
    }

    /// - `held`: what dry friction of each joint may hold of its torque at the moment \[N·m\], n
    pub(super) fn step(&mut self, dt: f64, [dq, ddq, tau]: [&[f64]; 3], held: &[f64]) {
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
            let before = std::mem::replace(&mut self.tau[joint], tau[joint]);
            let jump = (1.0 - stays) * (tau[joint] - before);
            let jump = if jump.is_nan() { 0.0 } else { jump * jump / 12.0 };
            let jumps = stays * stays * own[4] + jump;
            *own = [1.0, lag(own[1], dq[joint] * dq[joint]), lag(own[2], squares), reversed, jumps];
            self.held[joint] = lag(self.held[joint], held[joint]);
        }
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
        let mut spread = Self { coefficients: [mean, 0.0, 0.0, 0.0, 1.0], whole: mean.sqrt() };
        for _ in 0..ROUNDS {
            let mut columns = [true; SOLVED];
            let solved = loop {
                let mut sums = Stretches::new(SOLVED, usize::MAX, usize::MAX);
                for (x, at) in rows {
                    let weight = spread.variance(at).max(f64::MIN_POSITIVE.sqrt()).powi(-2);
                    let own: [f64; SOLVED] =
                        std::array::from_fn(|k| if columns[k] { at[k] } else { 0.0 });
                    sums.add(&own, square(*x) - LEAST_CONSTANT * mean - at[SOLVED], weight);
                }
                let Some(solved) = sums.solved() else { return spread };
                let least =
                    (0..SOLVED).min_by(|i, j| solved.values[*i].total_cmp(&solved.values[*j]));
                match least {
                    Some(k) if solved.values[k] < 0.0 => columns[k] = false,
                    _ => break solved,
                }
            };
            spread.coefficients[..SOLVED].copy_from_slice(&solved.values);
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
    use super::{FOLLOWED, Follower, Row, SOLVED, Spread};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};
    use torquewise_model::Model;

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
                0.0,
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
        let at = |speed: f64, reversed: f64| spread.at(&[1.0, speed, 2.0, reversed, 0.0]);
        assert!((at(1.0, 0.0) / 2.04_f64.sqrt() - 1.0).abs() < 0.05, "{spread:?}");
        assert!((at(0.5, 1.0) / 10.04_f64.sqrt() - 1.0).abs() < 0.1, "{spread:?}");
        assert!(spread.coefficients.iter().all(|c| *c >= 0.0), "{spread:?}");
        let spread = Spread::of(&rows(|_| 0.25), true);

        assert!((spread.whole - 0.5).abs() < 0.01, "{spread:?}");
        assert!((spread.at(&[1.0, 0.3, 2.0, 0.0, 0.0]) - 0.5).abs() < 0.05, "{spread:?}");
    }

    #[test]
    fn a_jump_of_torque_leaves_open_what_its_unknown_instant_is_worth() {
        let model = Model { joints: vec!["axis".to_owned()], ..Model::default() };
        let (gain, dt, jump) = (30.0, 0.005, 4.0);
        let mut follower = Follower::new(&model, gain);
        let still = [0.0];
        follower.step(0.0, [&still, &still, &[1.0]], &still);
        assert!(follower.followed[0][SOLVED].abs() <= 0.0);

        let after: Vec<f64> = (0..20)
            .map(|_| {
                follower.step(dt, [&still, &still, &[1.0 + jump]], &still);
                follower.followed[0][SOLVED]
            })
            .collect();

        // The mean of two samples misses the true one by jump · (u − ½), u uniform in 0 to 1.
        let stays = (-gain * dt).exp();
        let instants = (0..10_000).map(|k| (f64::from(k) + 0.5) / 10_000.0);
        let squares = instants.map(|u| ((1.0 - stays) * jump * (u - 0.5)).powi(2));
        let variance = squares.sum::<f64>() / 10_000.0;
        for (k, own) in (0..).zip(after) {
            let expected = variance * stays.powi(2 * k);
            assert!((own / expected - 1.0).abs() < 1e-6, "{k}: {own}, expected {expected}");
        }
        follower.reset();
        follower.step(dt, [&still, &still, &[-9.0]], &still);
        assert!(follower.followed[0][SOLVED].abs() <= 0.0);
    }
}
