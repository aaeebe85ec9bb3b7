//! Standstill rows → noise floor: the white noise in q, q̇ and q̈ of each joint [E7].

use crate::activation::quantile;
use crate::error::IdentifyError;
use crate::patterns::Patterns;
use faer::MatRef;
use torquewise_motion::{Motion, Pattern, Recording};

/// Standard deviation of the white noise in each signal of each joint; zeros where a log has no
/// standstill to read it from.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseFloor {
    /// In q \[rad\], n.
    pub q: Vec<f64>,
    /// In q̇ \[rad/s\], n.
    pub dq: Vec<f64>,
    /// In q̈ \[rad/s²\], n.
    pub ddq: Vec<f64>,
    /// Rows it was read from.
    pub rows: usize,
}

/// Reads the noise from the standstill rows of a recording, in one pass.
///
/// # Errors
/// [`IdentifyError::Read`] with the reader's message.
pub fn noise_floor(
    recording: &(impl Recording + ?Sized),
    patterns: &Patterns,
) -> Result<NoiseFloor, IdentifyError> {
    let mut sum = NoiseSum::new(recording.joints().len());
    recording
        .read(&mut |_, block| {
            sum.add(block, &patterns.label(block));
            Ok(())
        })
        .map_err(IdentifyError::Read)?;
    Ok(sum.finish())
}

/// Mean squared second differences of standstill rows, block by block: a slow drift does not count
/// as noise, and the median over blocks shrugs off a few rows taken for standstill by mistake.
#[derive(Clone, Debug)]
pub(crate) struct NoiseSum {
    /// `[signal][joint]` → one mean square per block.
    squares: [Vec<Vec<f64>>; 3],
    rows: usize,
}

/// A block with fewer such rows says too little about a variance.
const LEAST_ROWS: usize = 30;
/// Blocks remembered, so that memory does not grow with the log.
const MOST_BLOCKS: usize = 4096;
/// x₋ − 2x + x₊ of white noise has the variance 6σ².
const SECOND_DIFFERENCE: f64 = 6.0;

impl NoiseSum {
    pub(crate) fn new(n_joints: usize) -> Self {
        Self { squares: std::array::from_fn(|_| vec![Vec::new(); n_joints]), rows: 0 }
    }

    /// Adds the rows whose neighbours stand still too.
    pub(crate) fn add(&mut self, block: &Motion, labels: &[Pattern]) {
        let still: Vec<usize> = labels
            .windows(3)
            .enumerate()
            .filter(|(_, three)| three.iter().all(|&pattern| pattern == Pattern::Standstill))
            .map(|(row, _)| row)
            .collect();
        self.rows += still.len();
        if still.len() < LEAST_ROWS {
            return;
        }
        let signals = [block.q(), block.dq(), block.ddq()];
        for (squares, signal) in self.squares.iter_mut().zip(signals) {
            for (joint, blocks) in squares.iter_mut().enumerate() {
                let sum: f64 =
                    still.iter().map(|&row| second_difference(signal, row, joint).powi(2)).sum();
                if blocks.len() < MOST_BLOCKS {
                    blocks.push(sum / still.len() as f64);
                }
            }
        }
    }

    pub(crate) fn finish(self) -> NoiseFloor {
        let deviation =
            |mut blocks: Vec<f64>| (quantile(&mut blocks, 0.5) / SECOND_DIFFERENCE).sqrt();
        let [q, dq, ddq] =
            self.squares.map(|signal| signal.into_iter().map(deviation).collect::<Vec<f64>>());
        NoiseFloor { q, dq, ddq, rows: self.rows }
    }
}

fn second_difference(signal: MatRef<'_, f64>, row: usize, joint: usize) -> f64 {
    signal[(row, joint)] - 2.0 * signal[(row + 1, joint)] + signal[(row + 2, joint)]
}

impl NoiseFloor {
    /// No noise in n joints.
    pub fn none(n_joints: usize) -> Self {
        let zeros = || vec![0.0; n_joints];
        Self { q: zeros(), dq: zeros(), ddq: zeros(), rows: 0 }
    }

    /// Whether there is none.
    pub fn is_none(&self) -> bool {
        [&self.q, &self.dq, &self.ddq].into_iter().flatten().all(|&sigma| sigma == 0.0)
    }
}
