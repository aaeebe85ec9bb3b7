//! Standstill rows → noise floor: the white noise in q, q̇ and q̈ of each joint [E7].

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

/// Sums of squared second differences over standstill rows: a slow drift does not count as noise.
#[derive(Clone, Debug)]
pub(crate) struct NoiseSum {
    squares: [Vec<f64>; 3],
    rows: usize,
}

/// Fewer rows say too little about a variance.
const LEAST_ROWS: usize = 200;
/// x₋ − 2x + x₊ of white noise has the variance 6σ².
const SECOND_DIFFERENCE: f64 = 6.0;

impl NoiseSum {
    pub(crate) fn new(n_joints: usize) -> Self {
        Self { squares: std::array::from_fn(|_| vec![0.0; n_joints]), rows: 0 }
    }

    /// Adds the rows whose neighbours stand still too.
    pub(crate) fn add(&mut self, block: &Motion, labels: &[Pattern]) {
        for (row, neighbours) in labels.windows(3).enumerate() {
            if neighbours.iter().any(|&pattern| pattern != Pattern::Standstill) {
                continue;
            }
            let signals = [block.q(), block.dq(), block.ddq()];
            for (squares, signal) in self.squares.iter_mut().zip(signals) {
                for (joint, square) in squares.iter_mut().enumerate() {
                    *square += second_difference(signal, row, joint).powi(2);
                }
            }
            self.rows += 1;
        }
    }

    pub(crate) fn finish(self) -> NoiseFloor {
        let enough = self.rows >= LEAST_ROWS;
        let count = SECOND_DIFFERENCE * self.rows.max(1) as f64;
        let [q, dq, ddq] = self.squares.map(|squares| {
            squares.iter().map(|s| if enough { (s / count).sqrt() } else { 0.0 }).collect()
        });
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
