//! The noise floor: white noise in q, q̇ and q̈ of each joint (E7).

use crate::systematic_sample::SystematicSample;
use faer::{ColRef, Mat};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};
use torquewise_model::{ModelError, Torque};
use torquewise_motion::{Motion, ReadError, Recording, quantile};

/// Standard deviation of the white noise in each signal of each joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NoiseFloor {
    /// In q \[rad\], n.
    pub q: Vec<f64>,
    /// In q̇ \[rad/s\], n.
    pub dq: Vec<f64>,
    /// In q̈ \[rad/s²\], n.
    pub ddq: Vec<f64>,
}

impl NoiseFloor {
    /// No noise in n joints.
    pub fn none(n_joints: usize) -> Self {
        let zeros = || vec![0.0; n_joints];
        Self { q: zeros(), dq: zeros(), ddq: zeros() }
    }

    /// The noise of a recording whose rows were not filtered: that of filtered rows is not white,
    /// and what is left of it is next to none.
    ///
    /// # Errors
    /// The reader's own.
    pub fn of(recording: &(impl Recording + ?Sized)) -> Result<Self, ReadError> {
        let n = recording.joints().len();
        if recording.is_filtered() {
            return Ok(Self::none(n));
        }
        let mut sum = NoiseSum::new(n);
        recording.read(&mut |_, block| {
            sum.add(block, |_| true);
            Ok(())
        })?;
        Ok(sum.finish())
    }

    /// Variance that this noise gives the torque of a model, Σ_z (∂τ̂ᵢ/∂z)² σ_z².
    ///
    /// Slopes are central differences over ±σ_z, so that (∂τ̂ᵢ/∂z)σ_z is half a difference of
    /// torques; exact for what is linear or quadratic in a signal.
    ///
    /// - returns: \[(N·m)²\], m×n
    ///
    /// # Errors
    /// [`ModelError::JointCount`] if the motion is of another arm.
    pub fn in_torque(&self, torque: &Torque, motion: &Motion) -> Result<Mat<f64>, ModelError> {
        let n = self.q.len();
        let mut variance = Mat::zeros(motion.n_rows(), motion.n_joints());
        for (place, &sigma) in self.deviations().enumerate().filter(|(_, sigma)| **sigma > 0.0) {
            let [above, below] = [sigma, -sigma].map(|step| -> Result<Mat<f64>, ModelError> {
                let mut signals = motion.clone().into_signals();
                let shifted = [&mut signals.q, &mut signals.dq, &mut signals.ddq];
                let column = shifted[place / n].col_mut(place % n);
                column.iter_mut().for_each(|x| *x += step);
                torque.over(&Motion::new(signals)?.with_memory(motion.memory().cloned()))
            });
            faer::zip!(&mut variance, &above?, &below?)
                .for_each(|faer::unzip!(v, a, b)| *v += 0.25 * (*a - *b).powi(2));
        }
        Ok(variance)
    }

    /// Draws noise for so many rows, q, q̇ and q̈ side by side, m×3n.
    pub fn draw(&self, random: &mut impl Rng, rows: usize) -> Mat<f64> {
        let mut out = Mat::zeros(rows, SIGNALS * self.q.len());
        for (j, &sigma) in self.deviations().enumerate() {
            for value in out.col_as_slice_mut(j) {
                let unit: f64 = StandardNormal.sample(random);
                *value = sigma * unit;
            }
        }
        out
    }

    /// Whether there is none.
    pub fn is_none(&self) -> bool {
        self.deviations().all(|&sigma| sigma == 0.0)
    }

    fn deviations(&self) -> impl Iterator<Item = &f64> {
        [&self.q, &self.dq, &self.ddq].into_iter().flatten()
    }
}

/// Mean squared fourth differences of each signal, block by block, where the rows ask for it.
///
/// A fourth difference of motion sampled at dt is dt⁴ times its fourth derivative, next to nothing;
/// that of white noise has the variance 70σ². The few rows where an acceleration jumps are left out
/// of a block, and the median over blocks shrugs off what is left of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NoiseSum {
    /// Variance of each signal of each joint, signal by signal, of an even sample of the blocks.
    blocks: SystematicSample,
    /// Largest size seen of each signal of each joint, in the same order.
    peaks: Vec<f64>,
    /// Blocks of this log so far.
    seen: u64,
}

/// q, q̇ and q̈.
const SIGNALS: usize = 3;
const FOURTH_DIFFERENCE: [f64; 5] = [1.0, -4.0, 6.0, -4.0, 1.0];
/// 1 + 16 + 36 + 16 + 1
const GAIN: f64 = 70.0;
/// Median of |x| of a standard normal x.
const NORMAL_MEDIAN: f64 = 0.674_489_750_196_081_7;
/// Differences beyond this many deviations are jumps; noise loses 6e-5 of its rows by it.
const JUMP: f64 = 4.0;
/// A block with fewer differences does not determine a variance.
const LEAST_ROWS: usize = 30;
/// Fewer blocks of standstill rows are not relied on.
const LEAST_BLOCKS: usize = 5;
/// Blocks remembered, so that memory does not grow with the log.
const MOST_BLOCKS: usize = 4096;
/// Noise below this part of a signal's peak is rounding or motion; it does no harm.
const NEGLIGIBLE: f64 = 1e-6;
/// Above this part of the peak, rows that do not follow each other were taken for noise.
const UNLIKELY: f64 = 0.15;

impl NoiseSum {
    /// Nothing of n joints yet.
    pub fn new(n_joints: usize) -> Self {
        let width = SIGNALS * n_joints;
        Self { blocks: SystematicSample::new(width, MOST_BLOCKS), peaks: vec![0.0; width], seen: 0 }
    }

    /// Adds the rows of a block that are among five in a row of which `still` is true.
    pub fn add(&mut self, block: &Motion, still: impl Fn(usize) -> bool) {
        let signals = [block.q(), block.dq(), block.ddq()];
        let columns = || signals.iter().flat_map(|signal| signal.col_iter());
        for (peak, column) in self.peaks.iter_mut().zip(columns()) {
            *peak = column.iter().fold(*peak, |peak, x| peak.max(x.abs()));
        }
        let place = self.seen;
        self.seen += 1;
        if !self.blocks.is_sampled(place) {
            return;
        }
        let places = block.n_rows().saturating_sub(FOURTH_DIFFERENCE.len() - 1);
        let starts: Vec<usize> =
            (0..places).filter(|&row| (row..row + FOURTH_DIFFERENCE.len()).all(&still)).collect();
        if starts.len() >= LEAST_ROWS {
            self.blocks.push(place, || variances(&columns().collect::<Vec<_>>(), &starts));
        }
    }

    /// Adds the blocks of other logs.
    pub fn merge(&mut self, other: &Self) {
        self.blocks.merge(&other.blocks);
        for (peak, more) in self.peaks.iter_mut().zip(&other.peaks) {
            *peak = peak.max(*more);
        }
        self.seen = 0;
    }

    /// Puts what it holds in an order of its own.
    pub fn sort(&mut self) {
        self.blocks.sort();
        self.seen = 0;
    }

    /// Whether it holds what one of n joints does.
    pub fn is_sound(&self, n_joints: usize) -> bool {
        let width = SIGNALS * n_joints;
        self.blocks.is_sound(width, MOST_BLOCKS)
            && self.peaks.len() == width
            && self.peaks.iter().all(|peak| peak.is_finite())
    }

    /// The noise of all rows, zero where it is unlikely to be noise.
    pub fn finish(&self) -> NoiseFloor {
        self.floor(|sigma, peak| if sigma > UNLIKELY * peak { 0.0 } else { sigma })
    }

    /// The noise of rows known to stand still; `None` if they are too few.
    pub fn finish_still(&self) -> Option<NoiseFloor> {
        (self.blocks.len() >= LEAST_BLOCKS).then(|| self.floor(|sigma, _| sigma))
    }

    fn floor(&self, accept: impl Fn(f64, f64) -> f64) -> NoiseFloor {
        let deviation = |(place, &peak): (usize, &f64)| {
            let mut variances: Vec<f64> = self.blocks.records().map(|block| block[place]).collect();
            let sigma = quantile(&mut variances, 0.5).sqrt();
            accept(if sigma > NEGLIGIBLE * peak { sigma } else { 0.0 }, peak)
        };
        let mut sigmas = self.peaks.iter().enumerate().map(deviation);
        let n = self.peaks.len() / SIGNALS;
        let mut signal = || sigmas.by_ref().take(n).collect();
        NoiseFloor { q: signal(), dq: signal(), ddq: signal() }
    }
}

/// Variance of the noise in each signal of a block.
///
/// Where one of them jumps, the motion changes its course: that instant says nothing of the noise
/// of the others either, since joints start and stop together.
fn variances(signals: &[ColRef<'_, f64>], starts: &[usize]) -> Vec<f64> {
    let difference = |signal: &ColRef<'_, f64>, row: usize| {
        let terms = FOURTH_DIFFERENCE.iter().enumerate().map(|(k, c)| c * signal[row + k]);
        terms.sum::<f64>().abs()
    };
    let of_signal = |signal| starts.iter().map(|&row| difference(signal, row)).collect();
    let differences: Vec<Vec<f64>> = signals.iter().map(of_signal).collect();
    // Among normal numbers some are much larger: the deviation of those within two is found by
    // repetition.
    let limit = |sizes: &Vec<f64>| {
        let mut deviation = quantile(&mut sizes.clone(), 0.5) / NORMAL_MEDIAN;
        for _ in 0..CLIPPINGS {
            let kept = sizes.iter().filter(|size| **size <= 2.0 * deviation);
            let (sum, count) =
                kept.fold((0.0, 0), |(sum, count), size| (sum + size * size, count + 1));
            deviation = (sum / (f64::from(count.max(1)) * WITHIN_TWO)).sqrt();
        }
        JUMP * deviation
    };
    let limits: Vec<f64> = differences.iter().map(limit).collect();
    let is_smooth =
        |row: &usize| differences.iter().zip(&limits).all(|(sizes, limit)| sizes[*row] <= *limit);
    let kept: Vec<usize> = (0..starts.len()).filter(is_smooth).collect();
    let variance = |sizes: &Vec<f64>| {
        let sum: f64 = kept.iter().map(|&row| sizes[row].powi(2)).sum();
        sum / (GAIN * kept.len().max(1) as f64)
    };
    differences.iter().map(variance).collect()
}

/// Variance of a standard normal number that is within ±2.
const WITHIN_TWO: f64 = 0.773_741_3;
/// Rounds of leaving out what is beyond two deviations.
const CLIPPINGS: usize = 8;
