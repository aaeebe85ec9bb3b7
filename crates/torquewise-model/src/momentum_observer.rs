//! External torque from the generalised momentum, without q̈ (E16).

use crate::error::expect;
use crate::{Model, ModelError, Torque};
use torquewise_motion::Path;

/// Follows the torque that others put on an arm, sample by sample, from q, q̇ and the motor torque.
///
/// The momentum p = M(q) q̇ changes by ṗ = τ + C(q, q̇)ᵀ q̇ − G − F + τ_ext, so that what is left of its
/// change is τ_ext; r follows it as a low-pass of first order with bandwidth K:
/// ṙ = K (ṗ − τ − Cᵀq̇ + G + F − r).
///
/// Source: A. De Luca, R. Mattone, *Actuator failure detection and isolation using generalized
/// momenta*, ICRA (2003) \[E16\].
#[derive(Clone, Debug)]
pub struct MomentumObserver {
    torque: Torque,
    path: Path,
    /// K \[1/s\].
    gain: f64,
    last: Option<Sample>,
    /// r \[N·m\], n.
    external: Vec<f64>,
}

/// What the next sample needs of the last one.
#[derive(Clone, Debug)]
struct Sample {
    momentum: Vec<f64>,
    /// τ + Cᵀq̇ − G − F \[N·m\], n.
    change: Vec<f64>,
}

/// Way \[rad\] of the fastest joint over which M is differentiated along the motion.
const WAY: f64 = 1e-4;

impl MomentumObserver {
    /// An observer that has seen nothing.
    ///
    /// - `gain`: K \[1/s\], 2π times the bandwidth \[Hz\]
    pub fn new(model: &Model, gain: f64) -> Self {
        let torque = Torque::new(model);
        let path = torque.path();
        Self { torque, path, gain, last: None, external: vec![0.0; model.n_joints()] }
    }

    /// Forgets all samples, as before another trajectory.
    pub fn reset(&mut self) {
        self.last = None;
        self.path.reset();
        self.external.fill(0.0);
    }

    /// Takes a sample: r ≈ τ_ext \[N·m\], n. From one that is not finite nothing is learned.
    ///
    /// - `dt`: time since the last sample \[s\]
    /// - `q` \[rad\], `dq` \[rad/s\], `tau` \[N·m\]: n each
    ///
    /// # Errors
    /// [`ModelError::Shape`] if one has another length than the model has joints.
    pub fn step(&mut self, dt: f64, [q, dq, tau]: [&[f64]; 3]) -> Result<&[f64], ModelError> {
        self.path.step(q);
        let sample = self.sample(q, dq, tau)?;
        let all = sample.momentum.iter().chain(&sample.change).chain([&dt]);
        let is_finite = all.into_iter().all(|x| x.is_finite());
        if let Some(last) = &self.last
            && is_finite
            && dt > 0.0
        {
            let stays = (-self.gain * dt).exp();
            for (joint, external) in self.external.iter_mut().enumerate() {
                let momentum = (sample.momentum[joint] - last.momentum[joint]) / dt;
                let change = 0.5 * (sample.change[joint] + last.change[joint]);
                *external = stays * *external + (1.0 - stays) * (momentum - change);
            }
        }
        self.last = is_finite.then_some(sample);
        Ok(&self.external)
    }

    fn sample(&self, q: &[f64], dq: &[f64], tau: &[f64]) -> Result<Sample, ModelError> {
        let n = q.len();
        expect("tau", tau.len(), n)?;
        let momentum_at = |q: &[f64]| -> Result<Vec<f64>, ModelError> {
            let mass = self.torque.mass_matrix(q)?;
            Ok((0..n).map(|i| (0..n).map(|j| mass[(i, j)] * dq[j]).sum()).collect())
        };
        let coriolis = self.torque.coriolis(q, dq)?;
        let gravity = self.torque.gravity(q)?;
        let friction = self.torque.friction_after(&self.path, dq)?;
        // Cᵀq̇ = Ṁq̇ − Cq̇, and Ṁ is the derivative of M along q̇.
        let fastest = dq.iter().fold(0.0_f64, |most, dq| most.max(dq.abs()));
        let step = WAY / fastest.max(f64::MIN_POSITIVE);
        let turning = if fastest > 0.0 {
            let ahead =
                |by: f64| -> Vec<f64> { q.iter().zip(dq).map(|(q, v)| q + by * v).collect() };
            let [after, before] = [momentum_at(&ahead(step))?, momentum_at(&ahead(-step))?];
            after.iter().zip(before).map(|(a, b)| (a - b) / (2.0 * step)).collect()
        } else {
            vec![0.0; n]
        };
        let change = (0..n).map(|joint| {
            tau[joint] + turning[joint] - coriolis[joint] - gravity[joint] - friction[joint]
        });
        Ok(Sample { momentum: momentum_at(q)?, change: change.collect() })
    }
}
