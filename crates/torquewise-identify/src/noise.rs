//! Motion blocks → noise floor: the white noise in q, q̇ and q̈ of each joint (E7).

use crate::activation::quantile;
use faer::ColRef;
use torquewise_motion::Motion;

/// Standard deviation of the white noise in each signal of each joint.
#[derive(Clone, Debug, PartialEq)]
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

    /// Whether there is none.
    pub fn is_none(&self) -> bool {
        [&self.q, &self.dq, &self.ddq].into_iter().flatten().all(|&sigma| sigma == 0.0)
    }
}

/// Mean squared fourth differences of each signal, block by block, where the rows ask for it.
///
/// A fourth difference of motion sampled at dt is dt⁴ times its fourth derivative, next to nothing;
/// that of white noise has the variance 70σ². The few rows where an acceleration jumps are left out
/// of a block, and the median over blocks shrugs off what is left of them.
#[derive(Clone, Debug)]
pub(crate) struct NoiseSum {
    /// `[signal][joint]` → one variance per block.
    blocks: [Vec<Vec<f64>>; 3],
    /// `[signal][joint]` → largest size seen.
    peaks: [Vec<f64>; 3],
}

const FOURTH_DIFFERENCE: [f64; 5] = [1.0, -4.0, 6.0, -4.0, 1.0];
/// 1 + 16 + 36 + 16 + 1
const GAIN: f64 = 70.0;
/// Median of |x| of a standard normal x.
const NORMAL_MEDIAN: f64 = 0.674_489_750_196_081_7;
/// Differences beyond this many deviations are jumps; noise loses 6e-5 of its rows by it.
const JUMP: f64 = 4.0;
/// A block with fewer differences says too little about a variance.
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
    pub(crate) fn new(n_joints: usize) -> Self {
        Self {
            blocks: std::array::from_fn(|_| vec![Vec::new(); n_joints]),
            peaks: std::array::from_fn(|_| vec![0.0; n_joints]),
        }
    }

    /// Adds the rows of a block that are among five in a row of which `still` is true.
    pub(crate) fn add(&mut self, block: &Motion, still: impl Fn(usize) -> bool) {
        let places = block.n_rows().saturating_sub(FOURTH_DIFFERENCE.len() - 1);
        let starts: Vec<usize> =
            (0..places).filter(|&row| (row..row + FOURTH_DIFFERENCE.len()).all(&still)).collect();
        let signals = [block.q(), block.dq(), block.ddq()];
        for (place, signal) in signals.into_iter().enumerate() {
            for (joint, column) in signal.col_iter().enumerate() {
                let peak = &mut self.peaks[place][joint];
                *peak = column.iter().fold(*peak, |peak, x| peak.max(x.abs()));
                let variances = &mut self.blocks[place][joint];
                if variances.len() < MOST_BLOCKS {
                    variances.extend(variance(column, &starts));
                }
            }
        }
    }

    /// The noise of all rows, zero where it is unlikely to be noise.
    pub(crate) fn finish(self) -> NoiseFloor {
        let limits: Vec<Vec<f64>> = self
            .peaks
            .iter()
            .map(|peaks| peaks.iter().map(|peak| UNLIKELY * peak).collect())
            .collect();
        let likely = |values: Vec<f64>, limits: &[f64]| -> Vec<f64> {
            let pairs = values.into_iter().zip(limits);
            pairs.map(|(sigma, &limit)| if sigma > limit { 0.0 } else { sigma }).collect()
        };
        let NoiseFloor { q, dq, ddq } = self.floor();
        NoiseFloor {
            q: likely(q, &limits[0]),
            dq: likely(dq, &limits[1]),
            ddq: likely(ddq, &limits[2]),
        }
    }

    /// The noise of rows known to stand still; `None` if they are too few.
    pub(crate) fn finish_still(self) -> Option<NoiseFloor> {
        let enough = self.blocks[0].iter().all(|blocks| blocks.len() >= LEAST_BLOCKS);
        enough.then(|| self.floor())
    }

    fn floor(self) -> NoiseFloor {
        let mut peaks = self.peaks.into_iter();
        let [q, dq, ddq] = self.blocks.map(|signal| {
            let peaks = peaks.next().unwrap_or_default();
            let deviation = |(mut blocks, peak): (Vec<f64>, f64)| {
                let sigma = quantile(&mut blocks, 0.5).sqrt();
                if sigma > NEGLIGIBLE * peak { sigma } else { 0.0 }
            };
            signal.into_iter().zip(peaks).map(deviation).collect::<Vec<f64>>()
        });
        NoiseFloor { q, dq, ddq }
    }
}

/// Variance of the noise in one signal of a block, if it is long enough.
fn variance(signal: ColRef<'_, f64>, starts: &[usize]) -> Option<f64> {
    let difference = |&row: &usize| {
        let terms = FOURTH_DIFFERENCE.iter().enumerate().map(|(k, c)| c * signal[row + k]);
        terms.sum::<f64>().abs()
    };
    let mut sizes: Vec<f64> = starts.iter().map(difference).collect();
    if sizes.len() < LEAST_ROWS {
        return None;
    }
    let limit = JUMP * quantile(&mut sizes, 0.5) / NORMAL_MEDIAN;
    let kept: Vec<f64> = sizes.into_iter().filter(|&size| size <= limit).collect();
    let sum: f64 = kept.iter().map(|size| size * size).sum();
    Some(sum / (GAIN * kept.len().max(1) as f64))
}
