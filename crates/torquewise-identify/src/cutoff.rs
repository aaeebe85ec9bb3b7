//! One log filtered at several cut-offs → the cut-off, by torque predicted on held-out blocks.

use faer::Mat;
use std::f64::consts::TAU;
use std::ops::Range;
use torquewise_diagnose::rough::{Normal, columns};
use torquewise_model::model::Choice;
use torquewise_motion::Motion;
use torquewise_survey::held_out::{BLOCKS, Trial, choose_worth, listed};

/// Cut-offs worth trying, as multiples of the one that spectra suggest; that one comes first.
pub const MULTIPLES: [f64; 5] = [1.0, 0.5, std::f64::consts::FRAC_1_SQRT_2, 1.5, 2.0];

/// A model that leaves more than this part of the torque of held-out rows compares nothing.
const TELLS: f64 = 0.2;
/// A gain below this part is not worth a cut-off that the spectra do not suggest.
const WORTH: f64 = 0.05;
/// Fewer windows than this in a block tell nothing of it.
const LEAST_WINDOWS: usize = 4;
/// Length of a window, in periods of the lowest cut-off: the weights let nothing above it pass.
const WINDOW: f64 = 2.0;
/// Ridge on columns of unit length.
const RIDGE: f64 = 1e-6;

/// Chooses among cut-offs of one log by cross-validation in blocks of time.
///
/// A lower cut-off leaves less of the torque to predict, so errors after the filter cannot be
/// compared. What is compared is the torque in the band that all candidates pass: its weighted
/// means over windows of two periods of the lowest cut-off. A higher cut-off may then be better,
/// since the model sees more of the motion, or worse, since noise in q̇ and q̈ biases it.
///
/// The model is linear and rough, the same for every arm: what is compared is filters. The first
/// candidate is taken unless another is better by more than a standard error, and by 5 %.
///
/// - `candidates`: cut-offs \[Hz\] and what passed at each, with torque
/// - returns: the place of the choice and its record, whose errors are fractions of 1; `None`
///   where the log is too short to tell, or too much for that model
pub fn choose_cutoff(candidates: &[(f64, Motion)]) -> Option<(usize, Choice)> {
    let lowest = candidates.iter().map(|(cutoff, _)| *cutoff).reduce(f64::min)?;
    let mut span = (f64::MIN, f64::MAX);
    for (_, motion) in candidates {
        let t = motion.t();
        span = (span.0.max(*t.first()?), span.1.min(*t.last()?));
    }
    let clock = Clock::new(span, WINDOW / lowest)?;
    let trials = candidates.iter().map(|(cutoff, motion)| {
        let errors = errors(motion, &clock)?;
        Some(Trial { label: format!("{cutoff:.2} Hz"), complexity: 0, errors })
    });
    let trials = trials.collect::<Option<Vec<Trial>>>()?;
    let (first, rest) = trials.split_first()?;
    let best = rest.iter().min_by(|a, b| a.error().total_cmp(&b.error()))?;
    if first.error().min(best.error()) > TELLS {
        return None;
    }
    let (place, choice) = choose_worth("cut-off", &[first.clone(), best.clone()], WORTH)?;
    let chosen = trials.iter().position(|trial| place > 0 && trial.label == best.label);
    Some((chosen.unwrap_or_default(), Choice { from: listed(&trials), ..choice }))
}

/// Blocks of time, cut into windows.
struct Clock {
    begin: f64,
    end: f64,
    window: f64,
}

impl Clock {
    /// `None` if a block holds too few windows.
    fn new((begin, end): (f64, f64), window: f64) -> Option<Self> {
        let windows = (end - begin) / (window * BLOCKS as f64);
        (windows >= LEAST_WINDOWS as f64).then_some(Self { begin, end, window })
    }

    /// Rows of a block.
    fn block(&self, t: &[f64], block: usize) -> Range<usize> {
        let edge = |block: usize| {
            let at = self.begin + (self.end - self.begin) * block as f64 / BLOCKS as f64;
            t.partition_point(|t| *t < at)
        };
        edge(block)..if block + 1 == BLOCKS { t.len() } else { edge(block + 1) }
    }

    /// Means of a signal over the windows within these rows, each weighted by 1 − cos: what is
    /// above the lowest cut-off does not pass.
    fn means(&self, t: &[f64], rows: Range<usize>, signal: &[f64]) -> Vec<f64> {
        let rows = rows.start..rows.end.min(t.len());
        let Some(&[first, .., last]) = t.get(rows.clone()) else { return Vec::new() };
        let mut means = Vec::new();
        let mut begin = first;
        while begin + self.window <= last {
            let inside =
                t.partition_point(|t| *t < begin)..t.partition_point(|t| *t <= begin + self.window);
            let (mut sum, mut weights) = (0.0, 0.0);
            for row in inside {
                let weight = 1.0 - (TAU * (t[row] - begin) / self.window).cos();
                (sum, weights) = (sum + weight * signal[row], weights + weight);
            }
            if weights > 0.0 {
                means.push(sum / weights);
            }
            begin += 0.5 * self.window;
        }
        means
    }
}

/// Error on each block: geometric mean over the joints that move.
fn errors(motion: &Motion, clock: &Clock) -> Option<Vec<f64>> {
    let mut sums = [(0.0, 0_usize); BLOCKS];
    for joint in 0..motion.n_joints() {
        let Some(errors) = errors_of(motion, joint, clock) else { continue };
        for (sum, error) in sums.iter_mut().zip(errors) {
            *sum = (sum.0 + error.max(f64::MIN_POSITIVE).ln(), sum.1 + 1);
        }
    }
    sums.iter().map(|(sum, count)| (*count > 0).then(|| (sum / *count as f64).exp())).collect()
}

/// Error of a joint on each block, over the spread of its torque; `None` if it does not move or the
/// torque is constant.
fn errors_of(motion: &Motion, joint: usize, clock: &Clock) -> Option<Vec<f64>> {
    let columns = columns(motion, joint)?;
    let (t, p) = (motion.t(), columns.ncols());
    let tau: Vec<f64> = motion.tau()?.col(joint).iter().copied().collect();
    let all = clock.means(t, 0..t.len(), &tau);
    let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
    let spread = rms(&all.iter().map(|x| x - mean).collect::<Vec<f64>>());
    let response = Mat::from_fn(tau.len(), 1, |row, _| tau[row]);
    let parts: Vec<(Mat<f64>, Mat<f64>)> = (0..BLOCKS)
        .map(|block| {
            let rows = clock.block(t, block);
            let own = columns.subrows(rows.start, rows.len());
            (own.transpose() * own, own.transpose() * response.subrows(rows.start, rows.len()))
        })
        .collect();
    let rest = |block: usize| {
        let others = (0..BLOCKS).filter(move |other| *other != block);
        others.fold((Mat::zeros(p, p), Mat::zeros(p, 1)), |sum: (Mat<f64>, Mat<f64>), other| {
            (sum.0 + &parts[other].0, sum.1 + &parts[other].1)
        })
    };
    let of = |block: usize| {
        let (gram, moments) = rest(block);
        let fitted = &columns * Normal::new(gram, RIDGE)?.solve(&moments);
        let left: Vec<f64> = tau.iter().enumerate().map(|(row, x)| x - fitted[(row, 0)]).collect();
        Some(rms(&clock.means(t, clock.block(t, block), &left)) / spread)
    };
    if spread > 0.0 { (0..BLOCKS).map(of).collect() } else { None }
}

fn rms(x: &[f64]) -> f64 {
    (x.iter().map(|x| x * x).sum::<f64>() / x.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests;
