//! From noise, model to effective variance: how the noise of a row reaches the torque \[E17\].

use crate::error::ExperimentError;
use faer::Mat;
use torquewise_model::{Model, Torque};
use torquewise_motion::Motion;
use torquewise_stepwise::NoiseFloor;

/// A row counts at most this many times as much as one of mean variance: where the slope of the
/// torque vanishes, its curvature, which is left out here, still lets some noise through.
const MOST: f64 = 100.0;

/// Effective variance v = Σ_z (∂τ̂ᵢ/∂z)² σ_z² + σ_τᵢ² of each row \[(N·m)²\], m×n.
///
/// σ_τᵢ² is what the propagated noise leaves of the mean squared residual of the model, zero at
/// least. No row has less than a hundredth of the mean.
pub(crate) fn effective_variance(
    model: &Model,
    motion: &Motion,
    noise: &NoiseFloor,
) -> Result<Mat<f64>, ExperimentError> {
    let mut variance = noise.in_torque(&Torque::new(model), motion)?;
    let (expected, tau) = (Torque::new(model).over(motion)?, motion.require_tau()?);
    let m = motion.n_rows().max(1) as f64;
    for joint in 0..motion.n_joints() {
        let residual = tau.col(joint).iter().zip(expected.col(joint).iter());
        let squares: f64 = residual.map(|(a, b)| (a - b).powi(2)).sum::<f64>() / m;
        let own = variance.col_as_slice_mut(joint);
        let propagated = own.iter().sum::<f64>() / m;
        let torque_noise = (squares - propagated).max(0.0);
        let least = (propagated + torque_noise) / MOST;
        for v in own {
            *v = (*v + torque_noise).max(least);
        }
    }
    Ok(variance)
}

/// Weights 1/v of rows, scaled to a mean of one; ones where v is the same in all rows, as it is
/// without noise.
pub(crate) fn inverse_weights(variance: &[f64]) -> Vec<f64> {
    let alike = variance.windows(2).all(|pair| pair[0].to_bits() == pair[1].to_bits());
    if alike || variance.iter().any(|v| *v <= 0.0) {
        return vec![1.0; variance.len()];
    }
    let mean = variance.iter().map(|v| v.recip()).sum::<f64>() / variance.len() as f64;
    variance.iter().map(|v| v.recip() / mean).collect()
}

/// How many times the variance of a regression with equal weights is that with weights 1/v, if a
/// row's leverage has nothing to do with its v: mean(v) · mean(1/v), one or more.
pub(crate) fn possible_gain(variance: &[f64]) -> f64 {
    let mean = variance.iter().sum::<f64>() / variance.len().max(1) as f64;
    let weights = variance.iter().map(|v| v.recip()).sum::<f64>() / variance.len().max(1) as f64;
    if mean > 0.0 && weights.is_finite() { mean * weights } else { 1.0 }
}
