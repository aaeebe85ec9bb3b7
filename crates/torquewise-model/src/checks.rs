//! Model → is it physics? M(q) symmetric positive definite, Ṁ − 2C skew, on sampled states.

use crate::error::ModelError;
use crate::model::Model;
use crate::torque::Torque;
use faer::{Mat, Side};

/// What the checks found, the worst over the states looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct Checks {
    /// States looked at.
    pub states: usize,
    /// Smallest eigenvalue of the symmetric part of M(q) \[kg·m²\]; positive for a real arm.
    pub smallest_eigenvalue: f64,
    /// Largest ‖M − Mᵀ‖ / ‖M‖; zero for a real arm.
    pub asymmetry: f64,
    /// Largest |q̇ᵀ(Ṁq̇ − 2c)| / (‖q̇‖‖Ṁq̇‖ + 2‖q̇‖‖c‖), which is zero where Ṁ − 2C is skew: the
    /// power of the Coriolis torque is the change of kinetic energy that M accounts for.
    pub skew_defect: f64,
}

impl Checks {
    /// Whether M is symmetric and positive definite and Ṁ − 2C skew at all states looked at.
    pub fn passed(&self) -> bool {
        self.smallest_eigenvalue > 0.0 && self.asymmetry < 1e-6 && self.skew_defect < 1e-6
    }
}

/// Step of the central difference for Ṁ: its error is h² ≈ 1e-10 beside ε/h ≈ 2e-11.
const STEP: f64 = 1e-5;

/// Checks a model at states (q \[rad\], dq \[rad/s\]), n each.
///
/// # Errors
/// [`ModelError::Shape`] if a state has another length than the model has joints.
pub fn check(model: &Model, states: &[(Vec<f64>, Vec<f64>)]) -> Result<Checks, ModelError> {
    let torque = Torque::new(model);
    let mut checks = Checks {
        states: states.len(),
        smallest_eigenvalue: f64::INFINITY,
        asymmetry: 0.0,
        skew_defect: 0.0,
    };
    for (q, dq) in states {
        let mass = torque.mass_matrix(q)?;
        checks.smallest_eigenvalue = checks.smallest_eigenvalue.min(smallest_eigenvalue(&mass));
        let scale = mass.norm_l2().max(f64::MIN_POSITIVE);
        let asymmetry = (&mass - mass.transpose()).norm_l2() / scale;
        checks.asymmetry = checks.asymmetry.max(asymmetry);
        checks.skew_defect = checks.skew_defect.max(skew_defect(&torque, q, dq)?);
    }
    Ok(checks)
}

/// Smallest eigenvalue of the symmetric part; −∞ where none can be computed.
fn smallest_eigenvalue(mass: &Mat<f64>) -> f64 {
    let symmetric = faer::Scale(0.5) * (mass + mass.transpose());
    symmetric
        .self_adjoint_eigenvalues(Side::Lower)
        .map_or(f64::NEG_INFINITY, |values| values.into_iter().fold(f64::INFINITY, f64::min))
}

fn skew_defect(torque: &Torque, q: &[f64], dq: &[f64]) -> Result<f64, ModelError> {
    let n = q.len();
    let moved = |h: f64| -> Vec<f64> { q.iter().zip(dq).map(|(q, dq)| q + h * dq).collect() };
    let (ahead, behind) = (torque.mass_matrix(&moved(STEP))?, torque.mass_matrix(&moved(-STEP))?);
    let coriolis = torque.coriolis(q, dq)?;

    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let m_dot_dq: Vec<f64> = (0..n)
        .map(|i| (0..n).map(|j| (ahead[(i, j)] - behind[(i, j)]) / (2.0 * STEP) * dq[j]).sum())
        .collect();
    let norm = |a: &[f64]| dot(a, a).sqrt();
    let scale = norm(dq) * (norm(&m_dot_dq) + 2.0 * norm(&coriolis));
    let power = dot(dq, &m_dot_dq) - 2.0 * dot(dq, &coriolis);
    // An arm whose M is constant has no Coriolis torque: rounding must not be divided by rounding.
    Ok(if scale > 1e-9 { power.abs() / scale } else { 0.0 })
}
