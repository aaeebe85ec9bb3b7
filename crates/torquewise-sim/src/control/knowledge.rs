//! What a controller may ask about the arm before it.

use crate::{Arm, Plant, Result};
use faer::Mat;
use torquewise_model::{Model, Torque};
use torquewise_motion::Path;

/// What a controller may ask about the arm before it; slices hold n numbers in SI units, others are
/// refused.
#[expect(clippy::missing_errors_doc, reason = "slices of another length are refused by all")]
pub trait Knowledge: Sync {
    /// Number of joints n.
    fn n_joints(&self) -> usize;

    /// M̂(q) q̈ + Ĉ(q, q̇) q̇ + Ĝ(q) \[N·m\], n.
    fn rigid(&self, q: &[f64], dq: &[f64], ddq: &[f64]) -> Result<Vec<f64>>;

    /// The way of a motion before its first sample, with all that friction remembers of it.
    fn path(&self) -> Path;

    /// F̂ \[N·m\], n, at the end of a way and at q̇; zeros where no friction is known.
    fn friction(&self, path: &Path, dq: &[f64]) -> Result<Vec<f64>>;

    /// Ĝ(q) and the friction of slow motion at the end of a way and at q̇ \[N·m\], n: what is known
    /// after step 1.
    fn slow(&self, path: &Path, dq: &[f64]) -> Result<Vec<f64>>;

    /// M̂ᵢᵢ(q) \[kg·m²\], n.
    fn inertia(&self, q: &[f64]) -> Result<Vec<f64>>;
}

/// A reconstructed model made ready for control.
#[derive(Clone, Debug)]
pub struct Learned {
    n_joints: usize,
    whole: Torque,
    first_step: Torque,
}

/// Half width \[rad/s\] of reversals: no drive should follow a jump, but a desired velocity is free
/// of the noise that the learner smooths them for.
const REVERSAL: f64 = 0.002;

/// Whether a model is of the joints of an arm: by name, or by their number where it has no names.
pub fn is_of_joints(model: &Model, arm: &Arm) -> bool {
    let mut numbered = model.joints.iter().enumerate();
    let is_numbered = numbered.all(|(place, name)| *name == format!("joint{}", place + 1));
    let same_count = model.n_joints() == arm.n_joints();
    same_count && (is_numbered || model.joints == arm.joints())
}

impl Learned {
    /// Takes the model as it is, and for controller 1 its friction and the gravity that was known
    /// after the first of its steps. A model that was found in one step has its gravity instead.
    ///
    /// # Errors
    /// `SimError::Model` if its steps cannot be told apart.
    pub fn new(model: &Model) -> Result<Self> {
        let first = if model.stages.is_empty() { model.clone() } else { model.after_step(1)? };
        // Slow motion knows friction at low speed only.
        let first = Model { friction: model.friction.clone(), ..first };
        let whole = Torque::new(&sharp(model));
        let first_step = Torque::new(&sharp(&first));
        Ok(Self { n_joints: model.n_joints(), whole, first_step })
    }
}

/// The model with the reversal of its friction as sharp as a desired velocity allows.
pub fn sharp(model: &Model) -> Model {
    model.with_reversal(REVERSAL)
}

impl Knowledge for Learned {
    fn n_joints(&self) -> usize {
        self.n_joints
    }

    fn rigid(&self, q: &[f64], dq: &[f64], ddq: &[f64]) -> Result<Vec<f64>> {
        let whole = self.whole.at(q, dq, ddq)?;
        Ok(sum(whole, -1.0, &self.whole.friction(q, dq)?))
    }

    fn path(&self) -> Path {
        self.whole.path()
    }

    fn friction(&self, path: &Path, dq: &[f64]) -> Result<Vec<f64>> {
        Ok(self.whole.friction_after(path, dq)?)
    }

    fn slow(&self, path: &Path, dq: &[f64]) -> Result<Vec<f64>> {
        let gravity = self.first_step.gravity(path.q())?;
        Ok(sum(gravity, 1.0, &self.first_step.friction_after(path, dq)?))
    }

    fn inertia(&self, q: &[f64]) -> Result<Vec<f64>> {
        Ok(diagonal(&self.whole.mass_matrix(q)?))
    }
}

/// The truth, to compare with; bristles are taken as slipping.
impl Knowledge for Plant {
    fn n_joints(&self) -> usize {
        self.arm.n_joints()
    }

    fn rigid(&self, q: &[f64], dq: &[f64], ddq: &[f64]) -> Result<Vec<f64>> {
        Ok(self.arm.inverse_dynamics(q, dq, ddq))
    }

    fn path(&self) -> Path {
        Path::new(self.arm.n_joints(), &[])
    }

    fn friction(&self, _path: &Path, dq: &[f64]) -> Result<Vec<f64>> {
        Ok(self.friction.torques(dq))
    }

    fn slow(&self, path: &Path, dq: &[f64]) -> Result<Vec<f64>> {
        Ok(sum(self.arm.gravity_torque(path.q()), 1.0, &self.friction.torques(dq)))
    }

    fn inertia(&self, q: &[f64]) -> Result<Vec<f64>> {
        Ok(diagonal(&self.arm.mass_matrix(q)))
    }
}

fn diagonal(matrix: &Mat<f64>) -> Vec<f64> {
    matrix.diagonal().column_vector().iter().copied().collect()
}

pub(crate) fn sum(mut a: Vec<f64>, share: f64, b: &[f64]) -> Vec<f64> {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += share * b);
    a
}
