//! Bounds that a measured torque is expected within.

use crate::{Error, Result};
use faer::Mat;
use torquewise_model::{Model, RigidChain, Torque, Training};
use torquewise_motion::{Motion, ReadError, Recording};
use torquewise_stepwise::{IdentifyError, NoiseFloor};

/// What a measured torque is expected within: the parameters are uncertain, noise of the log
/// reaches the prediction, what the model leaves of the torque is not predicted, and dry friction holds a
/// joint at rest with anything up to that at which it breaks away.
pub struct Interval<'a> {
    model: &'a Model,
    chain: &'a RigidChain,
    torque: Torque,
    /// Noise of the log \[rad, rad/s, rad/s²\].
    noise: NoiseFloor,
    /// RMS of what else was left of the torque of each joint \[N·m\], n.
    left: &'a [f64],
    /// Deviations of a normal number on either side.
    deviations: f64,
}

impl<'a> Interval<'a> {
    /// Bounds that a given percentage of torques should lie between.
    ///
    /// - `recording`: the log to predict, whose noise is measured
    /// - `percent`: above 0 and below 100
    ///
    /// # Errors
    /// [`Error::NoCovariance`] if the model is of a library, and those of reading.
    pub fn new(model: &'a Model, recording: &dyn Recording, percent: f64) -> Result<Self> {
        let chain = model.chain.as_ref().filter(|chain| !chain.covariance_root.is_empty());
        let chain = chain.ok_or(Error::NoCovariance)?;
        let Training { unexplained_rms, residual_rms, .. } = &model.training;
        let left = if unexplained_rms.is_empty() { residual_rms } else { unexplained_rms };
        Ok(Self {
            model,
            chain,
            torque: Torque::new(model),
            noise: NoiseFloor::of(recording)?,
            left,
            deviations: normal_quantile(0.5 + percent / 200.0),
        })
    }

    /// Lower and upper bounds of the torque \[N·m\], m×n each.
    ///
    /// - `total`: the torque predicted for the block, m×n
    ///
    /// # Errors
    /// [`ReadError`] if the block does not fit the model.
    pub fn bounds(&self, block: &Motion, total: &Mat<f64>) -> Result<[Mat<f64>; 2], ReadError> {
        let (m, n) = (block.n_rows(), block.n_joints());
        let noise = self.noise.in_torque(&self.torque, block)?;
        let laws = self.torque.laws(block)?;
        let mut half = Mat::zeros(m, n);
        for row in 0..m {
            let state = block.state(row);
            let state = state.each_ref().map(Vec::as_slice);
            let laws: Vec<f64> = laws.row(row).iter().copied().collect();
            let errors = self.chain.std_errors((&self.model.friction, &laws), state)?;
            for (joint, error) in errors.into_iter().enumerate() {
                let left = self.left.get(joint).unwrap_or(&0.0);
                let known = noise[(row, joint)].sqrt();
                half[(row, joint)] = self.deviations * error.hypot(*left).hypot(known);
            }
        }
        let [least, most] = self.torque.held(block)?;
        Ok([total + least - &half, total + most + &half])
    }

    /// Part of measured torques that lies within the bounds of each joint \[%\], n.
    ///
    /// - `measured`: rows with torque, of which one of `every` of each trajectory is looked at
    ///
    /// # Errors
    /// Those of reading, and as [`Self::bounds`].
    pub fn coverage(&self, measured: &dyn Recording, every: usize) -> Result<Vec<f64>> {
        let (mut next, mut seen) = ((0, 0), 0);
        let mut within = vec![0_usize; self.model.n_joints()];
        let mut path = self.torque.path();
        let mut see = |trajectory: usize, block: &Motion| -> Result<(), ReadError> {
            let first = if next.0 == trajectory { next.1 } else { 0 };
            next = (trajectory, first + block.n_rows());
            let few: Vec<usize> =
                (0..block.n_rows()).filter(|row| (first + row).is_multiple_of(every)).collect();
            let block = path.follow(trajectory, block).select(&few);
            let [low, high] = self.bounds(&block, &self.torque.over(&block)?)?;
            let tau = block.require_tau()?;
            seen += few.len();
            for (joint, within) in within.iter_mut().enumerate() {
                let holds = |row: &usize| {
                    let at = (*row, joint);
                    (low[at]..=high[at]).contains(&tau[at])
                };
                *within += (0..few.len()).filter(holds).count();
            }
            Ok(())
        };
        measured.read(&mut see).map_err(IdentifyError::Read)?;
        Ok(within.iter().map(|within| 100.0 * *within as f64 / seen.max(1) as f64).collect())
    }
}

/// The number that a standard normal one is below with probability `p`, above one half.
///
/// Source: M. Abramowitz, I. Stegun, *Handbook of Mathematical Functions* (1964), 26.2.23; the
/// error is below 5e-4.
fn normal_quantile(p: f64) -> f64 {
    let t = (-2.0 * (1.0 - p).ln()).sqrt();
    let above = 2.515_517 + t * (0.802_853 + t * 0.010_328);
    let below = 1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308));
    t - above / below
}
