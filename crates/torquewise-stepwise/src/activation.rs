//! The activation index: how hard the joints are driven (6) (7) (E1).

use faer::MatRef;
use serde::{Deserialize, Serialize};
use torquewise_motion::{Motion, quantile};
use torquewise_regression::kmeans::kmeans;

/// Which constants the index uses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Scaling {
    /// Each joint by its own range, the sensitivity from the noise floor (E1).
    #[default]
    Scaled,
    /// The constants printed in the paper.
    Paper,
}

/// The index of one vector: I(a) = tanh(h‖a′‖₁) + W‖a′‖₁ sign(Σ a′ᵢ), a′ⱼ = aⱼ/sⱼ.
#[derive(Clone, Debug, PartialEq)]
pub struct ActivationIndex {
    /// sⱼ, n; ones in the paper.
    pub scale: Vec<f64>,
    /// h
    pub sensitivity: f64,
    /// W
    pub weight: f64,
}

/// The pair \[I(q̇) I(q̈)\] that rows are clustered by.
#[derive(Clone, Debug, PartialEq)]
pub struct Activation {
    /// ActivationIndex of the velocities.
    pub velocity: ActivationIndex,
    /// ActivationIndex of the accelerations.
    pub acceleration: ActivationIndex,
}

/// A joint moves with all its might at this quantile of its speeds: the largest may be an outlier.
const RANGE_QUANTILE: f64 = 0.98;
/// Rates below this part of the range count as this part: the logarithm of zero is no number.
const LEAST_RATE: f64 = 1e-3;
/// tanh⁻¹(½): the switch is half on halfway, on a log scale, between noise and motion.
const HALF_ON: f64 = 0.549_306_144_334_054_8;
/// n·W: how far the signed term spreads a cluster along its axis.
const SPREAD: f64 = 0.25;

impl ActivationIndex {
    /// I(a) of one vector, n.
    pub fn of(&self, a: &[f64]) -> f64 {
        let (mut norm, mut sum) = (0.0, 0.0);
        for (a, scale) in a.iter().zip(&self.scale) {
            norm += (a / scale).abs();
            sum += a / scale;
        }
        let sign = if sum == 0.0 { 0.0 } else { f64::signum(sum) };
        (self.sensitivity * norm).tanh() + self.weight * norm * sign
    }

    fn scaled(rates: MatRef<'_, f64>) -> Self {
        let n = rates.ncols();
        let range = |joint: usize| {
            let mut sizes: Vec<f64> = rates.col(joint).iter().map(|a| a.abs()).collect();
            quantile(&mut sizes, RANGE_QUANTILE)
        };
        let mut scale: Vec<f64> = (0..n).map(range).collect();
        // A joint that hardly ever moves would blow its noise up to full range.
        let largest = scale.iter().copied().fold(0.0, f64::max);
        for s in &mut scale {
            *s = if largest > 0.0 { s.max(0.05 * largest) } else { 1.0 };
        }
        let size = |row: usize| {
            let norm: f64 = (0..n).map(|joint| (rates[(row, joint)] / scale[joint]).abs()).sum();
            [norm.max(LEAST_RATE).ln()]
        };
        let sizes: Vec<[f64; 1]> = (0..rates.nrows()).map(size).collect();
        // Rows at rest and rows in motion form two clusters on a log scale, noise or not.
        let halfway = kmeans(&sizes, 2, 0)
            .map_or(0.0, |heaps| 0.5 * (heaps.centres[0][0] + heaps.centres[1][0]));
        let sensitivity = HALF_ON / halfway.exp();
        Self { scale, sensitivity, weight: SPREAD / n.max(1) as f64 }
    }
}

impl Activation {
    /// The constants of the paper: h = 60, W₁ = 0.6, W₂ = 0.32, no scaling.
    pub fn paper(n_joints: usize) -> Self {
        let index =
            |weight| ActivationIndex { scale: vec![1.0; n_joints], sensitivity: 60.0, weight };
        Self { velocity: index(0.6), acceleration: index(0.32) }
    }

    /// Constants from a sample of the log (E1).
    pub fn scaled(sample: &Motion) -> Self {
        Self {
            velocity: ActivationIndex::scaled(sample.dq()),
            acceleration: ActivationIndex::scaled(sample.ddq()),
        }
    }

    /// \[I(q̇) I(q̈)\] of each row of a motion, m.
    pub fn over(&self, motion: &Motion) -> Vec<[f64; 2]> {
        let pair = |row| {
            let [_, dq, ddq] = motion.state(row);
            [self.velocity.of(&dq), self.acceleration.of(&ddq)]
        };
        (0..motion.n_rows()).map(pair).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_printed_index_switches_by_tanh_and_carries_the_sign() {
        let index = Activation::paper(2).velocity;

        let (there, back) = (index.of(&[0.5, 0.25]), index.of(&[-0.5, -0.25]));

        assert!((there - (1.0 + 0.6 * 0.75)).abs() < 1e-12, "tanh(45) is one");
        assert!((back - (1.0 - 0.6 * 0.75)).abs() < 1e-12);
        assert!(index.of(&[0.0, 0.0]).abs() < 1e-15);
    }
}
